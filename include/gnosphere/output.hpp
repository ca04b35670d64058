// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gnosphere/export.hpp"
#include "gnosphere/layout.hpp"
#include "gnosphere/scan.hpp"

namespace gnosphere {

/// Parses a list such as "x,y,z,range". A vector is given by one name ("normal") and becomes one column per component
/// (normal_x normal_y normal_z). `return_number`, `return_count` and `class_id` are taken for `return`, `returns` and
/// `class`. Throws Error(invalidArgument) with the nearest names.
GNOSPHERE_API std::vector<Field> parseFields(const std::string& names);
GNOSPHERE_API const std::vector<Field>& defaultFields();  ///< x y z range ring beam triangle instance

/// Returns a layout with the fields one after the other without gaps, each component in the field's own type.
GNOSPHERE_API RecordLayout layoutOf(const std::vector<Field>& fields);

/// Writes the rows of the scan to the start of `out` and returns their number; ranges.size() * stride bytes always
/// suffice. The bytes of a row that no value has stay as they are. ring, beam, returnNumber and returnCount are
/// available even if they were not requested for the scan. Throws Error(invalidArgument), before anything is written,
/// for a field that the scan does not have, a type that does not hold the field, values that overlap or reach beyond
/// the stride, and a buffer that is too small (the message states the bytes needed).
GNOSPHERE_API size_t pack(const Scan& scan, const RecordLayout& layout, std::span<std::byte> out);

/// The options of a cloud file.
struct CloudOptions {
  std::vector<Field>
      fields;  ///< if empty: defaultFields(), plus returnNumber and returnCount if beams have several returns
  /// If true, only returns are written, one row each; with Field::tie and several returns per beam also one row for
  /// each beam without a return that is a tie. If false, every entry is written, as a grid of channels x columns (x
  /// returns); an entry without a return has NaN, and 0xffffffff as indices. By default a file is compact if beams have
  /// several returns.
  std::optional<bool> compact;
  bool ascii = false;  ///< writes PCD and PLY as text; CSV always is text
};

/// Writes .pcd, .ply, .bin (KITTI: x y z and the intensity, or 0; returns only), .npy or .csv; the file's extension
/// decides. PCD states the pose of the scan as its VIEWPOINT. A temporary file is written and then renamed, so no
/// half-written file is left. Throws Error(invalidArgument) for an unknown extension, a field that stands twice, or one
/// that the scan or KITTI's files do not have, and Error(file) if the file cannot be written. Links are followed, and
/// pipes and devices are written directly.
GNOSPHERE_API void writeCloud(const Scan& scan, const std::filesystem::path& file, const CloudOptions& options = {});

/// Writes a PNG: a range image over columns and channels as the sensor sees it (upper channels on top, beams to the
/// left on the left), and below it a bird's-eye view coloured by height, with the x axis upwards. If beams have several
/// returns, the first of each is shown. Throws Error(invalidArgument) if the scan lacks points or ranges or the
/// name does not end in .png, and Error(file) if the file cannot be written.
GNOSPHERE_API void writePicture(const Scan& scan, const std::filesystem::path& file);

/// Reads a PCD, PLY, NPY or CSV cloud that writeCloud() wrote. The scan gets the fields of the file except ring, beam,
/// returnNumber and returnCount, which follow from the index of an entry. If the file has the field `beam`, entries are
/// placed by it, and by `return` if beams have several returns; without `return` the rows of a beam are its returns in
/// their order, unless the file states that beams have one; without `beam` they are points of one beam each, unless
/// there is one for every entry of the grid that the file states. A compact file of several returns does not contain
/// beams without returns, so its `cause` is left out; if it is NPY or CSV, it does not tell of those behind the last
/// one with a return. PCD states the sensor's pose, and PCD and PLY state Scan::skewed; other files leave the pose
/// unknown (Scan::poseKnown). Throws Error(file), Error(format), or Error(invalidArgument) for an extension that cannot
/// be read.
GNOSPHERE_API Scan readCloud(const std::filesystem::path& file);

/// The differences between two clouds of the same beams, counted per beam, or per return if beams have several;
/// `reference` is taken as the truth. Returns that the reference marks as ties are counted separately.
struct Comparison {
  uint64_t beams = 0;
  uint64_t hits = 0;            ///< returns of the reference, not beams
  uint64_t missed = 0;          ///< returns of the reference that the other does not have, without ties
  uint64_t falseHits = 0;       ///< returns of the other that the reference does not have, without ties
  uint64_t wrongOwner = 0;      ///< both hit, but different triangles, without ties
  uint64_t wrongRange = 0;      ///< both hit, but the ranges differ by more than the tolerance, without ties
  uint64_t ties = 0;            ///< returns of either cloud, or beams without any, that the reference marks as ties
  uint64_t tieDifferences = 0;  ///< ties in which the two differ in owner or hit
  uint64_t tieMissed = 0, tieFalseHits = 0, tieWrongOwner = 0;
  double tieErrorMax = 0;     ///< metres, over ties that both hit, whatever the owner
  double rangeErrorMax = 0;   ///< metres, over beams with the same owner, without ties
  double rangeError9999 = 0;  ///< 99.99th percentile of |error|, in metres
  double rangeErrorRms = 0;   ///< root mean square, in metres
  double hitErrorMax = 0;     ///< metres, over beams that both hit, whatever the owner, without ties
  uint64_t wrongPoint = 0;    ///< both hit, but their points are further apart than the tolerance, without ties
  double pointErrorMax = 0;   ///< metres between points, over beams that both hit, whatever the owner, without ties
  bool same() const { return missed == 0 && falseHits == 0 && wrongOwner == 0 && wrongRange == 0 && wrongPoint == 0; }
};

/// Compares two clouds beam by beam. `tolerance`, in metres, applies to beams for which the reference states no
/// tolerance of its own. If both clouds have points, these may be apart by the tolerance and the rounding of
/// coordinates: a millionth of the range, or 2^-22 of the distance from the frame's origin if that is more. Throws
/// Error(invalidArgument) if the clouds do not have the same beams, in the same grid where both know theirs, or for a
/// tolerance that is not a number from 0 on.
GNOSPHERE_API Comparison compare(const Scan& reference, const Scan& other, double tolerance = 1e-3);

}  // namespace gnosphere
