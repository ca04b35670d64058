// SPDX-License-Identifier: Apache-2.0
// The columns of a scan as vectors, to compare them and to make scans by hand.
#pragma once

#include <vector>

#include "scan/columns.hpp"

namespace gnosphere::test {

/// All values of a field, the components of an entry side by side; none where the scan does not have it.
template <typename T>
std::vector<T> valuesOf(const Scan& scan, Field field) {
  std::vector<T> values;
  if (!scan.has(field)) return values;
  for (size_t entry = 0; entry < scan.ranges.size(); ++entry)
    for (uint32_t c = 0; c < fieldInfo(field).components; ++c) values.push_back(scan.column<T>(field, c)[entry]);
  return values;
}

/// Makes the column of a field: all its values, the components of an entry side by side.
template <typename T>
void setColumn(Scan& scan, Field field, const std::vector<T>& values) {
  ScanColumns columns(scan);
  columns.make(field);
  std::copy(values.begin(), values.end(), columns.data<T>(field));
}

}  // namespace gnosphere::test
