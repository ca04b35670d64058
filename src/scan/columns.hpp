// SPDX-License-Identifier: Apache-2.0
// Write access to the columns of a scan.
#pragma once

#include <algorithm>
#include <cassert>

#include "gnosphere/scan.hpp"

namespace gnosphere {

/// Write access to the columns of a scan, with one value per entry of Scan::ranges, which must have its final size.
class ScanColumns {
 public:
  explicit ScanColumns(Scan& scan) : scan_(scan) {}

  /// Makes a column without setting its values, or removes it if not `wanted`. Memory that exists is reused.
  void make(Field field, bool wanted = true);

  /// Makes a column in which all values are the same, or removes it.
  template <typename T>
  void fill(Field field, T value, bool wanted = true) {
    make(field, wanted);
    if (wanted) std::fill_n(data<T>(field), scan_.ranges.size() * fieldInfo(field).components, value);
  }

  /// Says whether a field with a public array is unknown, which Scan::has() then denies: `triangle` or `instance`, as
  /// in a cloud without such a column, whose array has kNoTriangle in every entry; and x, which stands for the points
  /// of a batch that was not asked for them, and of a cloud without them.
  void setUnknown(Field field, bool unknown) { scan_.columns_[static_cast<size_t>(field)].resize(unknown ? 1 : 0); }

  /// Returns the memory of the values; null if the scan does not have the column, or has no entries.
  std::byte* bytes(Field field) const {
    auto& values = scan_.columns_[static_cast<size_t>(field)];
    return values.empty() || scan_.ranges.empty() ? nullptr : values.data();
  }

  /// Returns the values, with the components of an entry side by side; null if the scan does not have the column.
  template <typename T>
  T* data(Field field) const {
    assert(fieldInfo(field).type == valueTypeOf<T>());
    return reinterpret_cast<T*>(bytes(field));
  }

 private:
  Scan& scan_;
};

/// Throws Error(invalidArgument) that names the field and says how a scan gets it.
[[noreturn]] void refuseMissing(Field field);

}  // namespace gnosphere
