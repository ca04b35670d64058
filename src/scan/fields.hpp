// SPDX-License-Identifier: Apache-2.0
// The fields of scans and cloud files, and the types of their values.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "gnosphere/output.hpp"

namespace gnosphere {

constexpr size_t sizeOf(ValueType type) {
  constexpr size_t kSizes[] = {4, 8, 1, 2, 4};
  return kSizes[static_cast<size_t>(type)];
}
/// Returns the name of the type, such as "f32".
const char* nameOf(ValueType type);
/// Returns the C++ name of the type, such as "float".
const char* cppNameOf(ValueType type);
/// Returns the letter of the type in PCD: F for a float, U for an unsigned integer.
char letterOf(ValueType type);

/// Returns whether every scan has the field, in a public array and not as a column.
bool isOfEveryScan(Field field);
/// Returns whether the field follows from the index of an entry, so that no column is needed.
bool followsFromIndex(Field field);

/// One column of a cloud file. A scalar field has one column, a vector has one per component.
struct ColumnInfo {
  Field field;
  const char* name;
  ValueType type;
  uint32_t component = 0;
  const char* fieldName = name;  ///< name by which the field is requested
};

/// Returns all columns in the order of Field.
std::span<const ColumnInfo> allColumns();
std::vector<ColumnInfo> columnsOf(const std::vector<Field>& fields);
/// Finds a field by its name, or by that of its enumerator as Python spells it, which differs for `return_number`,
/// `return_count` and `class_id`. The name must be in lower case.
std::optional<Field> findField(std::string_view name);
/// Throws Error(invalidArgument) if a field stands in the list twice.
void checkOnce(std::span<const Field> fields);
/// Finds a column by name, ignoring case; null if the name is unknown.
const ColumnInfo* findColumn(std::string_view name);

}  // namespace gnosphere
