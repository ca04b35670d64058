// SPDX-License-Identifier: Apache-2.0
// Clouds of files, and their comparison.
#pragma once

#include <filesystem>

#include "gnosphere/output.hpp"

namespace gnosphere {

/// A cloud and whether the size of its grid is known. A file that has rows for some beams alone and states no grid may
/// belong to a sensor with more beams than its rows name.
struct CloudFile {
  Scan scan;
  bool statesGrid = true;
};

/// Does the work of readCloud().
CloudFile readCloudFile(const std::filesystem::path& file);

/// A comparison of files, and how many returns its errors of ranges are of: those of both with the same owner, without
/// ties.
struct FileComparison : Comparison {
  uint64_t sameOwner = 0;
};

/// Does the work of compare(), but beams that a file without a grid does not name have no return in it.
FileComparison compareFiles(const CloudFile& reference, const CloudFile& other, double tolerance);

/// Returns the fields of either cloud that compare() ignores, without those that follow from the number of an entry.
std::vector<Field> fieldsNotCompared(const Scan& reference, const Scan& other);

}  // namespace gnosphere
