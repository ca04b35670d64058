// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "gnosphere/export.hpp"
#include "gnosphere/scan.hpp"

namespace gnosphere {

/// "x,y,z,range" -> fields; a vector is one name, "normal", and a column per component, normal_x normal_y normal_z.
/// Throws Error(invalidArgument) that lists the names there are.
GNOSPHERE_API std::vector<Field> parseFields(const std::string& names);
GNOSPHERE_API const std::vector<Field>& defaultFields();  ///< x y z range ring beam triangle instance

/// How a row lies in memory: which values, and where.
struct RecordLayout {
  struct Value {
    Field field = Field::x;
    uint32_t component = 0;
    size_t offset = 0;  ///< bytes from the start of the row; no alignment is needed
    /// The field's own type, or one that holds each of its values: f64 holds all, f32 those of u8 and u16, and an
    /// unsigned integer those of a shorter one.
    ValueType type = ValueType::f32;
  };
  std::vector<Value> values;
  size_t stride = 0;  ///< bytes from row to row; what no value covers is left as it is
  /// A row per return that came back; otherwise a row per entry of the scan.
  bool compact = false;
};

/// The fields one after the other without a gap, each component in the field's own type.
GNOSPHERE_API RecordLayout layoutOf(const std::vector<Field>& fields);

/// Writes rows of the scan from the start of `out`, and returns how many; ranges.size() * stride bytes always suffice.
/// ring, beam, returnNumber and returnCount need not have been asked for. Throws Error(invalidArgument), before
/// anything is written, for a field that the scan does not have, a type that does not hold it, values that overlap or
/// reach beyond the stride, and for too small a buffer with the bytes that it needs.
GNOSPHERE_API size_t pack(const Scan& scan, const RecordLayout& layout, std::span<std::byte> out);

struct CloudOptions {
  std::vector<Field> fields;  ///< none: defaultFields(), and the return numbers and counts where beams have several
  /// What came back only; otherwise every beam, a miss being NaN (0xffffffff in ids). Where beams have several returns
  /// it is always so: a row per return, and no grid.
  bool compact = false;
  bool ascii = false;  ///< PCD and PLY; CSV always is
};

/// Writes .pcd, .ply, .bin (KITTI: x y z and the intensity, or 0; hits only), .npy or .csv; the ending decides. The
/// file is written beside and renamed, so no half-written file is left. Throws Error(invalidArgument) for an ending or
/// a field the scan does not have, Error(file) if it cannot be written.
GNOSPHERE_API void writeCloud(const Scan& scan, const std::filesystem::path& file, const CloudOptions& options = {});

/// Range image over the columns and channels above a bird's-eye view coloured by height, as PNG. Of several returns it
/// shows the first of each beam.
GNOSPHERE_API void writePicture(const Scan& scan, const std::filesystem::path& file);

/// Reads a PCD, PLY, NPY or CSV cloud with the fields that writeCloud() gave it, but for ring, beam, returnNumber and
/// returnCount, which follow from the index of an entry; organised by `beam`, and by `return` where beams have several,
/// where the file has those fields. Of several returns it leaves out `cause`, as such a file says nothing of beams
/// without any. Throws Error(file) or Error(format), Error(invalidArgument) for an ending it does not read.
GNOSPHERE_API Scan readCloud(const std::filesystem::path& file);

/// How two clouds of the same beams differ, beam by beam, and return by return where there are several; `reference` is
/// taken as the truth. Returns that the reference marks as ties are counted apart.
struct Comparison {
  uint64_t beams = 0;
  uint64_t hits = 0;            ///< of the reference
  uint64_t missed = 0;          ///< the reference hits, the other does not; outside ties
  uint64_t falseHits = 0;       ///< the other hits, the reference does not; outside ties
  uint64_t wrongOwner = 0;      ///< both hit, another triangle; outside ties
  uint64_t wrongRange = 0;      ///< both hit, further apart than the tolerance; outside ties
  uint64_t ties = 0;            ///< beams the reference marks
  uint64_t tieDifferences = 0;  ///< of those, how many differ in owner or hit
  uint64_t tieMissed = 0, tieFalseHits = 0, tieWrongOwner = 0;
  double tieErrorMax = 0;     ///< metres, over ties that both hit, whoever the owner
  double rangeErrorMax = 0;   ///< metres, over beams with the same owner, ties left out
  double rangeError9999 = 0;  ///< 99.99th percentile of |error|
  double rangeErrorRms = 0;
  double hitErrorMax = 0;  ///< metres, over beams that both hit, whoever the owner, ties left out
  bool same() const { return missed == 0 && falseHits == 0 && wrongOwner == 0 && wrongRange == 0; }
};

/// `tolerance` in metres is used for beams where the reference states none. Throws Error(invalidArgument) if the
/// clouds do not have the same beams.
GNOSPHERE_API Comparison compare(const Scan& reference, const Scan& other, double tolerance = 1e-3);

}  // namespace gnosphere
