// SPDX-License-Identifier: Apache-2.0
#include "scan/layout.hpp"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <string>

#include "gnosphere/error.hpp"
#include "scan/fields.hpp"

namespace gnosphere {
namespace {

// Kernels find bytes by 32 bits.
constexpr uint64_t kMostBytes = 0xfffffffcu;

[[noreturn]] void refuse(const std::string& why) {
  throw Error(ErrorCode::invalidArgument, "the record layout: " + why);
}

std::string quoted(Field field) {
  return std::string("'").append(fieldInfo(field).name).append("'");
}

std::string placeOf(const RecordLayout::Value& value) {
  return quoted(value.field).append(" at bytes ") + std::to_string(value.offset) + " to " +
         std::to_string(value.offset + sizeOf(value.type) - 1);
}

void checkColumn(const RecordLayout::Value& value) {
  const std::string name = "the column " + quoted(value.field);
  const size_t size = sizeOf(value.type);
  if (value.offset % 4 != 0)
    refuse(name + " begins at byte " + std::to_string(value.offset) + ", which is not a multiple of 4");
  if (value.stride != size && (value.stride < size || value.stride % 4 != 0))
    refuse(name + " has a stride of " + std::to_string(value.stride) + "; it must be " + std::to_string(size) +
           " or a larger multiple of 4");
}

uint64_t roundedToWords(uint64_t bytes) {
  return (bytes + 3) / 4 * 4;
}

}  // namespace

void validate(const RecordLayout& layout) {
  if (layout.empty()) refuse("has no values");
  for (const RecordLayout::Value& value : layout.values) {
    const FieldInfo info = fieldInfo(value.field);
    const std::string name = quoted(value.field);
    if (value.component >= info.components)
      refuse(name + " has no component " + std::to_string(value.component) + "; it has " +
             std::to_string(info.components) + ", counted from 0");
    if (!holds(value.type, info.type))
      refuse(nameOf(value.type) + std::string(" does not hold every value of ") + name + "; " + nameOf(info.type) +
             " does");
    if (value.stride > 0)
      checkColumn(value);
    else if (layout.stride < sizeOf(value.type) || value.offset > layout.stride - sizeOf(value.type))
      refuse(placeOf(value) + " reaches beyond the stride of " + std::to_string(layout.stride) + " bytes");
  }
  const std::vector<RecordLayout::Value> values = valuesOfRow(layout);
  for (size_t i = 1; i < values.size(); ++i)
    if (values[i - 1].offset + sizeOf(values[i - 1].type) > values[i].offset)
      refuse(placeOf(values[i]) + " overlaps " + placeOf(values[i - 1]));
}

std::vector<RecordLayout::Value> valuesOfRow(const RecordLayout& layout) {
  std::vector<RecordLayout::Value> values;
  std::copy_if(layout.values.begin(), layout.values.end(), std::back_inserter(values),
               [](const RecordLayout::Value& value) { return value.stride == 0; });
  std::stable_sort(values.begin(), values.end(), [](const auto& a, const auto& b) { return a.offset < b.offset; });
  return values;
}

std::vector<Field> fieldsOf(const RecordLayout& layout) {
  std::vector<Field> fields;
  for (const RecordLayout::Value& value : layout.values)
    if (std::find(fields.begin(), fields.end(), value.field) == fields.end()) fields.push_back(value.field);
  return fields;
}

RecordLayout columnLayout(const std::vector<Field>& fields, uint64_t rows) {
  RecordLayout layout;
  const auto has = [&](Field field) {
    return std::ranges::any_of(layout.values, [&](const auto& value) { return value.field == field; });
  };
  for (const Field field : fields) {
    if (has(field)) continue;
    constexpr Field kPoint[] = {Field::x, Field::y, Field::z};
    const bool point = std::ranges::count(kPoint, field) > 0;
    const FieldInfo info = fieldInfo(field);
    const uint32_t components = point ? 3 : info.components;
    const size_t size = sizeOf(info.type), start = layout.bytesFor(rows);
    for (uint32_t i = 0; i < components; ++i)
      layout.values.push_back(
          {point ? kPoint[i] : field, point ? 0 : i, start + i * size, info.type, components * size});
  }
  return layout;
}

uint64_t RecordLayout::bytesFor(uint64_t rows) const {
  uint64_t widest = stride;
  for (const Value& value : values) widest = std::max<uint64_t>(widest, value.stride);
  constexpr uint64_t kMost = static_cast<uint64_t>(INT64_MAX) / 2;
  if (widest > 0 && rows > kMost / widest)
    throw Error(ErrorCode::invalidArgument,
                std::to_string(rows) + " rows of " + std::to_string(widest) + " bytes have no size in 64 bits");
  for (const Value& value : values)
    if (value.stride > 0 && value.offset > kMost) refuse(placeOf(value) + " has no place in 64 bits");
  uint64_t bytes = roundedToWords(rows * stride);
  for (const Value& value : values)
    if (value.stride > 0 && rows > 0)
      bytes = std::max(bytes, value.offset + roundedToWords((rows - 1) * value.stride + sizeOf(value.type)));
  return bytes;
}

uint64_t rowsIn(const RecordLayout& layout, uint64_t bytes) {
  bytes = std::min(bytes, kMostBytes);
  uint64_t least = 0, most = bytes;  // the answer is in least..most, because a row has at least one byte
  while (least < most) {
    const uint64_t middle = (least + most + 1) / 2;
    if (layout.bytesFor(middle) <= bytes)
      least = middle;
    else
      most = middle - 1;
  }
  return least;
}

}  // namespace gnosphere
