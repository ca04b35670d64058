// SPDX-License-Identifier: Apache-2.0
#include "output/fields.hpp"

#include <algorithm>
#include <cctype>
#include <string>

#include "base/text.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere {
namespace {

std::string trimmed(const std::string& text) {
  const size_t first = text.find_first_not_of(" \t");
  return first == text.npos ? "" : text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

}  // namespace

std::span<const ColumnInfo> allColumns() {
  static constexpr ColumnInfo kColumns[] = {
      {Field::x, "x", 'F', 4, 0, 3},
      {Field::y, "y", 'F', 4, 1, 3},
      {Field::z, "z", 'F', 4, 2, 3},
      {Field::range, "range", 'F', 4},
      {Field::ring, "ring", 'U', 2},
      {Field::beam, "beam", 'U', 4},
      {Field::triangle, "triangle", 'U', 4},
      {Field::instance, "instance", 'U', 4},
      {Field::tie, "tie", 'U', 1},
      {Field::tolerance, "tolerance", 'F', 4},
      {Field::intensity, "intensity", 'F', 4},
      {Field::trueRange, "true_range", 'F', 4},
      {Field::cause, "cause", 'U', 1},
      {Field::label, "label", 'U', 1},
      {Field::returnNumber, "return", 'U', 1},
      {Field::returnCount, "returns", 'U', 1},
      {Field::width, "width", 'F', 4},
      {Field::normal, "normal_x", 'F', 4, 0, 3, "normal"},
      {Field::normal, "normal_y", 'F', 4, 1, 3, "normal"},
      {Field::normal, "normal_z", 'F', 4, 2, 3, "normal"},
      {Field::incidence, "incidence", 'F', 4},
      {Field::material, "material", 'U', 4},
      {Field::barycentrics, "u", 'F', 4, 0, 2, "barycentrics"},
      {Field::barycentrics, "v", 'F', 4, 1, 2, "barycentrics"},
      {Field::classId, "class", 'U', 2},
      {Field::velocity, "velocity_x", 'F', 4, 0, 3, "velocity"},
      {Field::velocity, "velocity_y", 'F', 4, 1, 3, "velocity"},
      {Field::velocity, "velocity_z", 'F', 4, 2, 3, "velocity"},
      {Field::radialSpeed, "radial_speed", 'F', 4},
      {Field::time, "time", 'F', 4},
      {Field::azimuth, "azimuth", 'F', 4},
      {Field::elevation, "elevation", 'F', 4},
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

const char* fieldName(Field field) {
  return columnsOf({field}).at(0).fieldName;
}

const ColumnInfo* findColumn(std::string_view name) {
  const std::string wanted = lower(name);
  for (const ColumnInfo& column : allColumns()) {
    if (wanted == column.name) return &column;
  }
  return nullptr;
}

bool isAskedFor(Field field) {
  switch (field) {
    case Field::intensity:
    case Field::trueRange:
    case Field::cause:
    case Field::label:
    case Field::width:
    case Field::normal:
    case Field::incidence:
    case Field::material:
    case Field::barycentrics:
    case Field::velocity:
    case Field::radialSpeed: return true;
    default: return false;
  }
}

const std::vector<Field>& defaultFields() {
  static const std::vector<Field> fields = {Field::x,    Field::y,    Field::z,        Field::range,
                                            Field::ring, Field::beam, Field::triangle, Field::instance};
  return fields;
}

std::vector<Field> parseFields(const std::string& names) {
  std::vector<Field> fields;
  for (size_t begin = 0; begin <= names.size();) {
    const size_t end = std::min(names.find(',', begin), names.size());
    const std::string name = lower(trimmed(names.substr(begin, end - begin)));
    const auto columns = allColumns();
    const auto known = std::find_if(columns.begin(), columns.end(),
                                    [&](const ColumnInfo& column) { return name == column.fieldName; });
    if (known == columns.end()) {
      std::string list;
      for (const ColumnInfo& column : columns) {
        if (column.component == 0 || column.fieldName == column.name)
          list.append(list.empty() ? "" : ", ").append(column.fieldName);
      }
      throw Error(ErrorCode::invalidArgument, "no field is called '" + name + "'; known are " + list);
    }
    if (std::find(fields.begin(), fields.end(), known->field) != fields.end()) {
      throw Error(ErrorCode::invalidArgument, "field '" + name + "' is asked for twice");
    }
    fields.push_back(known->field);
    begin = end + 1;
  }
  return fields;
}

CloudFormat cloudFormat(const std::filesystem::path& file) {
  const std::string ending = lower(file.extension().string());
  if (ending == ".pcd") return CloudFormat::pcd;
  if (ending == ".ply") return CloudFormat::ply;
  if (ending == ".bin") return CloudFormat::kitti;
  if (ending == ".npy") return CloudFormat::npy;
  if (ending == ".csv") return CloudFormat::csv;
  throw Error(ErrorCode::invalidArgument, file.string() + ": the ending says which kind of cloud it is; known are " +
                                              ".pcd, .ply, .bin (KITTI), .npy and .csv");
}

}  // namespace gnosphere
