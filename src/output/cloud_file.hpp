// SPDX-License-Identifier: Apache-2.0
// Clouds of files, and their comparison.
#pragma once

#include <array>
#include <filesystem>
#include <utility>

#include "gnosphere/output.hpp"

namespace gnosphere {

/// The point from which the coordinates of a cloud are taken before they become floats, which have only 24 bits: in
/// metres, in the frame of the file. Each coordinate is a whole multiple of 1,024 m, so that it is 0 near the frame's
/// origin, and coordinates as those of UTM keep their millimetres.
using Origin = std::array<double, 3>;

/// A cloud of a file.
struct CloudFile {
  Scan scan;  ///< with points from `origin`
  /// Whether the size of the grid is known. A file that has rows for some beams alone and states no grid may belong to
  /// a sensor with more beams than its rows name.
  bool statesGrid = true;
  Origin origin = {};
  double floatStep = 0;  ///< CloudTable::floatStep() at the origin
};

/// Does the work of readCloud(); the origin is that of the frame.
CloudFile readCloudFile(const std::filesystem::path& file);

/// Reads two clouds to compare, with points from a common origin near the first point of the reference. A range that a
/// file lacks is the distance of the point from there. The function throws what readCloud() throws.
std::pair<CloudFile, CloudFile> readCloudFiles(const std::filesystem::path& reference,
                                               const std::filesystem::path& other);

/// Returns the point whose distance from a coordinate tells how far the coordinate may be rounded: the common origin of
/// both files, or that of the frame if one of them has rounded its coordinates to floats.
Origin roundingCentre(const CloudFile& reference, const CloudFile& other);

/// A comparison of files, and the number of returns that its range errors cover: those that both files have with the
/// same owner, without ties.
struct FileComparison : Comparison {
  uint64_t sameOwner = 0;
};

/// Does the work of compare(), but beams that a file without a grid does not name have no return in it.
FileComparison compareFiles(const CloudFile& reference, const CloudFile& other, double tolerance);

/// Returns the fields of either cloud that compare() ignores, without those that follow from the number of an entry.
std::vector<Field> fieldsNotCompared(const Scan& reference, const Scan& other);

}  // namespace gnosphere
