// SPDX-License-Identifier: Apache-2.0
// Checks of the layouts of rows.
#pragma once

#include <vector>

#include "gnosphere/layout.hpp"

namespace gnosphere {

/// Returns whether the type `to` can represent every value of the type `from`.
constexpr bool holds(ValueType to, ValueType from) {
  if (to == from || to == ValueType::f64) return true;
  if (from == ValueType::f32) return false;
  if (to == ValueType::f32) return from != ValueType::u32;
  return from == ValueType::u8 || (from == ValueType::u16 && to == ValueType::u32);
}

/// Throws Error(invalidArgument) unless all values lie within the row or are columns, do not overlap, and have types
/// that can hold them.
void validate(const RecordLayout& layout);

/// Returns the values that are parts of the row, in the order of their offsets.
std::vector<RecordLayout::Value> valuesOfRow(const RecordLayout& layout);

/// Returns the fields that the layout needs, each once.
std::vector<Field> fieldsOf(const RecordLayout& layout);

/// Returns the layout in which so many values of each field follow one another, fields in the order given, each once;
/// vectors have their components side by side, and x, y and z are one vector.
RecordLayout columnLayout(const std::vector<Field>& fields, uint64_t rows);

/// Returns how many rows fit into so many bytes of a device.
uint64_t rowsIn(const RecordLayout& layout, uint64_t bytes);

}  // namespace gnosphere
