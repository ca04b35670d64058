// SPDX-License-Identifier: Apache-2.0
// What a scan and a cloud file may hold, and how numbers are laid out.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "gnosphere/output.hpp"

namespace gnosphere {

constexpr size_t sizeOf(ValueType type) {
  constexpr size_t kSizes[] = {4, 8, 1, 2, 4};
  return kSizes[static_cast<size_t>(type)];
}
/// "f32" and so on.
const char* nameOf(ValueType type);
/// "float" and so on.
const char* cppNameOf(ValueType type);
/// PCD's letter: F for a float, U for an unsigned integer.
char letterOf(ValueType type);

/// One column of a cloud file. Most fields are one column, a vector is one per component.
struct ColumnInfo {
  Field field;
  const char* name;
  ValueType type;
  uint32_t component = 0;
  const char* fieldName = name;  ///< to ask for the field by
};

/// Every column there is, in the order of Field.
std::span<const ColumnInfo> allColumns();
std::vector<ColumnInfo> columnsOf(const std::vector<Field>& fields);
/// By name, whatever the case; null for a name that is not one of ours.
const ColumnInfo* findColumn(std::string_view name);

}  // namespace gnosphere
