// SPDX-License-Identifier: Apache-2.0
#include "output/rows.hpp"

#include <cstring>

#include "base/threads.hpp"
#include "gnosphere/error.hpp"
#include "scan/columns.hpp"
#include "scan/computed_columns.hpp"
#include "scan/fields.hpp"
#include "scan/layout.hpp"

namespace gnosphere {
namespace {

/// Fewer rows than this are not worth a thread.
constexpr uint64_t kRowsPerThread = 65536;

/// Calls `use` with a function that returns the value of an entry in the field's own type.
template <typename Use>
void withColumn(const Scan& scan, Field field, uint32_t component, const Use& use) {
  const size_t returns = scan.returns;
  switch (field) {
    case Field::ring:
      if (scan.has(field)) break;
      return use([&](size_t e) { return static_cast<uint16_t>(e / returns / scan.columns); });
    case Field::beam: return use([&](size_t e) { return static_cast<uint32_t>(e / returns); });
    case Field::returnNumber: return use([&](size_t e) { return returnNumberOf(scan, e); });
    case Field::returnCount: return use([&](size_t e) { return returnCountOf(scan, e); });
    default: break;
  }
  const auto from = [&](const auto& view) { use([&](size_t e) { return view[e]; }); };
  switch (fieldInfo(field).type) {
    case ValueType::f32: return from(scan.column<float>(field, component));
    case ValueType::u32: return from(scan.column<uint32_t>(field, component));
    case ValueType::u16: return from(scan.column<uint16_t>(field, component));
    case ValueType::u8: return from(scan.column<uint8_t>(field, component));
    case ValueType::f64: break;  // no field has this type
  }
}

/// Calls `use` with a value of the C++ type that `type` stands for.
template <typename Use>
void withType(ValueType type, const Use& use) {
  switch (type) {
    case ValueType::f32: return use(float{});
    case ValueType::f64: return use(double{});
    case ValueType::u8: return use(uint8_t{});
    case ValueType::u16: return use(uint16_t{});
    case ValueType::u32: return use(uint32_t{});
  }
}

template <typename T>
constexpr ValueType typeOf() {
  if constexpr (std::is_same_v<T, double>)
    return ValueType::f64;
  else
    return valueTypeOf<T>();
}

}  // namespace

void checkFields(const Scan& scan, const std::vector<Field>& fields) {
  if (scan.returns == 0 || scan.returns > 255) {
    throw Error(ErrorCode::invalidArgument,
                "the scan has " + std::to_string(scan.returns) + " returns per beam; there must be 1 to 255");
  }
  if (scan.ranges.size() % scan.returns != 0 || size_t{scan.columns} * scan.channels != scan.beamCount()) {
    throw Error(ErrorCode::invalidArgument, "the scan has " + std::to_string(scan.ranges.size()) + " ranges for " +
                                                std::to_string(scan.columns) + " columns x " +
                                                std::to_string(scan.channels) + " channels x " +
                                                std::to_string(scan.returns) + " returns");
  }
  for (Field field : fields) {
    if (field == Field::ring && !scan.has(field)) checkRings(scan.channels);
    if (!followsFromIndex(field) && !scan.has(field)) refuseMissing(field);
  }
}

Rows::Rows(const Scan& scan, bool compact, bool ties) : scan_(scan), compact_(compact), count_(scan.ranges.size()) {
  if (!compact) return;
  const auto marked = ties ? scan.column<uint8_t>(Field::tie) : ColumnView<uint8_t>();
  for (size_t entry = 0; entry < scan.ranges.size(); ++entry) {
    const bool tie = ties && entry % scan.returns == 0 && marked[entry] != 0;
    if (scan.returned(entry) || tie) entries_.push_back(entry);
  }
  count_ = entries_.size();
}

// The outer loop runs over the values of the layout, so that the inner loop has no branch on the field.
void Rows::pack(const RecordLayout& layout, size_t first, size_t count, std::byte* out) const {
  for (const RecordLayout::Value& value : layout.values) {
    withColumn(scan_, value.field, value.component, [&](const auto& valueOf) {
      withType(value.type, [&](auto zero) {
        using From = decltype(valueOf(size_t{}));
        using To = decltype(zero);
        if constexpr (holds(typeOf<To>(), typeOf<From>())) {
          std::byte* to = out + value.offset;
          for (size_t row = first; row < first + count; ++row, to += layout.stride) {
            const To converted = static_cast<To>(valueOf(entryOf(row)));
            std::memcpy(to, &converted, sizeof(converted));
          }
        }
      });
    });
  }
}

RecordLayout layoutOf(const std::vector<Field>& fields) {
  RecordLayout layout;
  for (Field field : fields) {
    const FieldInfo info = fieldInfo(field);
    for (uint32_t component = 0; component < info.components; ++component) {
      layout.values.push_back({field, component, layout.stride, info.type});
      layout.stride += sizeOf(info.type);
    }
  }
  return layout;
}

size_t pack(const Scan& scan, const RecordLayout& layout, std::span<std::byte> out) {
  validate(layout);
  for (const RecordLayout::Value& value : layout.values)
    if (value.stride > 0)
      throw Error(ErrorCode::invalidArgument,
                  "the record layout: columns are for results that stay on a device; a Scan has Scan::column()");
  const std::vector<Field> fields = fieldsOf(layout);
  checkFields(scan, fields);
  const Rows rows(scan, layout.compact);
  if (rows.count() > out.size() / layout.stride) {
    throw Error(ErrorCode::invalidArgument, "the buffer has " + std::to_string(out.size()) + " bytes; " +
                                                std::to_string(rows.count()) + " rows of " +
                                                std::to_string(layout.stride) + " bytes need " +
                                                std::to_string(rows.count() * layout.stride));
  }
  inRuns(rows.count(), kRowsPerThread, threadCount(), [&](uint64_t first, uint64_t end) {
    rows.pack(layout, first, end - first, out.data() + first * layout.stride);
  });
  return rows.count();
}

}  // namespace gnosphere
