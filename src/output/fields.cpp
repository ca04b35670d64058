// SPDX-License-Identifier: Apache-2.0
#include "output/fields.hpp"

#include <algorithm>
#include <cctype>
#include <string>

#include "gnosphere/error.hpp"

namespace gnosphere {
namespace {

std::string lower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

std::string trimmed(const std::string& text) {
  const size_t first = text.find_first_not_of(" \t");
  return first == text.npos ? "" : text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

}  // namespace

const std::array<FieldInfo, 10>& allFields() {
  static constexpr std::array<FieldInfo, 10> kFields = {{
      {Field::x, "x", 'F', 4},
      {Field::y, "y", 'F', 4},
      {Field::z, "z", 'F', 4},
      {Field::range, "range", 'F', 4},
      {Field::ring, "ring", 'U', 2},
      {Field::beam, "beam", 'U', 4},
      {Field::triangle, "triangle", 'U', 4},
      {Field::instance, "instance", 'U', 4},
      {Field::tie, "tie", 'U', 1},
      {Field::tolerance, "tolerance", 'F', 4},
  }};
  return kFields;
}

const FieldInfo& fieldInfo(Field field) {
  return allFields().at(static_cast<size_t>(field));
}

const FieldInfo* findField(std::string_view name) {
  const std::string wanted = lower(name);
  for (const FieldInfo& info : allFields()) {
    if (wanted == info.name) return &info;
  }
  return nullptr;
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
    const std::string name = trimmed(names.substr(begin, end - begin));
    const FieldInfo* info = findField(name);
    if (!info) {
      std::string list;
      for (const FieldInfo& known : allFields()) list += (list.empty() ? "" : ", ") + std::string(known.name);
      throw Error(ErrorCode::invalidArgument, "no field is called '" + name + "'; there are " + list);
    }
    if (std::find(fields.begin(), fields.end(), info->field) != fields.end()) {
      throw Error(ErrorCode::invalidArgument, "field '" + name + "' is asked for twice");
    }
    fields.push_back(info->field);
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
  throw Error(ErrorCode::invalidArgument, file.string() + ": the ending says which kind of cloud it is; there are " +
                                              ".pcd, .ply, .bin (KITTI), .npy and .csv");
}

}  // namespace gnosphere
