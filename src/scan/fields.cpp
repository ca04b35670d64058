// SPDX-License-Identifier: Apache-2.0
#include "scan/fields.hpp"

#include <algorithm>
#include <array>
#include <string>

#include "base/lasting.hpp"
#include "base/nearest_text.hpp"
#include "base/text.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere {

bool isOfEveryScan(Field field) {
  constexpr Field kOfEveryScan[] = {Field::x, Field::y, Field::z, Field::range, Field::triangle, Field::instance};
  return std::find(std::begin(kOfEveryScan), std::end(kOfEveryScan), field) != std::end(kOfEveryScan);
}

bool followsFromIndex(Field field) {
  return field == Field::ring || field == Field::beam || field == Field::returnNumber || field == Field::returnCount;
}

const char* nameOf(ValueType type) {
  constexpr const char* kNames[] = {"f32", "f64", "u8", "u16", "u32"};
  return kNames[static_cast<size_t>(type)];
}

const char* cppNameOf(ValueType type) {
  constexpr const char* kNames[] = {"float", "double", "uint8_t", "uint16_t", "uint32_t"};
  return kNames[static_cast<size_t>(type)];
}

char letterOf(ValueType type) {
  return type == ValueType::f32 || type == ValueType::f64 ? 'F' : 'U';
}

std::span<const ColumnInfo> allColumns() {
  static constexpr ColumnInfo kColumns[] = {
      {Field::x, "x", ValueType::f32},
      {Field::y, "y", ValueType::f32},
      {Field::z, "z", ValueType::f32},
      {Field::range, "range", ValueType::f32},
      {Field::ring, "ring", ValueType::u16},
      {Field::beam, "beam", ValueType::u32},
      {Field::triangle, "triangle", ValueType::u32},
      {Field::instance, "instance", ValueType::u32},
      {Field::tie, "tie", ValueType::u8},
      {Field::tolerance, "tolerance", ValueType::f32},
      {Field::intensity, "intensity", ValueType::f32},
      {Field::trueRange, "true_range", ValueType::f32},
      {Field::cause, "cause", ValueType::u8},
      {Field::label, "label", ValueType::u8},
      {Field::returnNumber, "return", ValueType::u8},
      {Field::returnCount, "returns", ValueType::u8},
      {Field::width, "width", ValueType::f32},
      {Field::normal, "normal_x", ValueType::f32, 0, "normal"},
      {Field::normal, "normal_y", ValueType::f32, 1, "normal"},
      {Field::normal, "normal_z", ValueType::f32, 2, "normal"},
      {Field::incidence, "incidence", ValueType::f32},
      {Field::material, "material", ValueType::u32},
      {Field::barycentrics, "u", ValueType::f32, 0, "barycentrics"},
      {Field::barycentrics, "v", ValueType::f32, 1, "barycentrics"},
      {Field::classId, "class", ValueType::u16},
      {Field::velocity, "velocity_x", ValueType::f32, 0, "velocity"},
      {Field::velocity, "velocity_y", ValueType::f32, 1, "velocity"},
      {Field::velocity, "velocity_z", ValueType::f32, 2, "velocity"},
      {Field::radialSpeed, "radial_speed", ValueType::f32},
      {Field::time, "time", ValueType::f32},
      {Field::azimuth, "azimuth", ValueType::f32},
      {Field::elevation, "elevation", ValueType::f32},
  };
  return kColumns;
}

std::vector<ColumnInfo> columnsOf(const std::vector<Field>& fields) {
  std::vector<ColumnInfo> columns;
  for (Field field : fields) {
    for (const ColumnInfo& column : allColumns()) {
      if (column.field == field) columns.push_back(column);
    }
  }
  return columns;
}

FieldInfo fieldInfo(Field field) {
  static const auto kInfos = [] {
    std::array<FieldInfo, kFieldCount> infos = {};
    for (const ColumnInfo& column : allColumns()) {
      FieldInfo& info = infos[static_cast<size_t>(column.field)];
      info = {column.fieldName, column.type, info.components + 1};
    }
    return infos;
  }();
  const auto index = static_cast<size_t>(field);
  if (index >= kInfos.size())
    throw Error(ErrorCode::invalidArgument, "there is no field number " + std::to_string(index));
  return kInfos[index];
}

const ColumnInfo* findColumn(std::string_view name) {
  const std::string wanted = lower(name);
  for (const ColumnInfo& column : allColumns()) {
    if (wanted == column.name) return &column;
  }
  return nullptr;
}

std::optional<Field> findField(std::string_view name) {
  if (name == "return_number") return Field::returnNumber;
  if (name == "return_count") return Field::returnCount;
  if (name == "class_id") return Field::classId;
  for (const ColumnInfo& column : allColumns())
    if (name == column.fieldName) return column.field;
  return std::nullopt;
}

const std::vector<Field>& defaultFields() {
  static const auto& fields = lasting(std::vector<Field>{Field::x, Field::y, Field::z, Field::range, Field::ring,
                                                         Field::beam, Field::triangle, Field::instance});
  return fields;
}

void checkOnce(std::span<const Field> fields) {
  for (auto field = fields.begin(); field != fields.end(); ++field)
    if (std::find(fields.begin(), field, *field) != field)
      throw Error(ErrorCode::invalidArgument, std::string("field '") + fieldInfo(*field).name + "' is asked for twice");
}

std::vector<Field> parseFields(const std::string& names) {
  std::vector<Field> fields;
  for (size_t begin = 0; begin <= names.size();) {
    const size_t end = std::min(names.find(',', begin), names.size());
    const std::string name = lower(trimmed(std::string_view(names).substr(begin, end - begin), " \t"));
    if (name.empty())
      throw Error(ErrorCode::invalidArgument,
                  "the fields '" + names + "' have '' where a name is wanted; give names as x,y,z");
    const auto columns = allColumns();
    const std::optional<Field> known = findField(name);
    if (!known) {
      if (const ColumnInfo* column = findColumn(name))
        throw Error(ErrorCode::invalidArgument,
                    "'" + name + "' is a column of the field " + column->fieldName + "; ask for " + column->fieldName);
      std::vector<std::string> all;
      for (const ColumnInfo& column : columns)
        if (column.component == 0) all.push_back(column.fieldName);
      const bool doppler = name.find("doppler") != name.npos;
      throw Error(ErrorCode::invalidArgument,
                  "no field is called '" + name + "'; " +
                      (doppler ? "the speed along the beam is radial_speed" : nearestText(name, all)) +
                      "; docs/api.md and gnosphere scan --help list all");
    }
    fields.push_back(*known);
    begin = end + 1;
  }
  checkOnce(fields);
  return fields;
}

}  // namespace gnosphere
