// SPDX-License-Identifier: Apache-2.0
// {"materials": [{"name": "asphalt", "reflectance_905": 0.17, "reflectance_1550": 0.2, "roughness": 1, "retro": 0,
// "transmission": 0}]}; a value that a row omits stays as in the scene.
#include "effects/material_table.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "base/file.hpp"
#include "base/json_text.hpp"
#include "base/nearest_text.hpp"
#include "base/text.hpp"
#include "effects/openmaterial.hpp"
#include "effects/parameter_text.hpp"

namespace gnosphere {
namespace {

using nlohmann::json;
using Row = MaterialTable::Row;

struct Column {
  const char* name;
  float Row::*member;
  float max;
};

constexpr Column kColumns[] = {{"reflectance_905", &Row::reflectance905, 1},
                               {"reflectance_1550", &Row::reflectance1550, 1},
                               {"roughness", &Row::roughness, 1},
                               {"retro", &Row::retro, Material::kMostRetro},
                               {"transmission", &Row::transmission, 1}};

constexpr size_t kMaxTableBytes = size_t{256} << 20;  // a BRDF table of a million rows takes about 50 MB

[[noreturn]] void refuseTable(const std::filesystem::path& file, const std::string& why) {
  throw Error(ErrorCode::format, file.string() + ": " + why);
}

std::string rangeOf(const Column& column) {
  return "0.." + std::to_string(static_cast<int>(column.max));
}

void readColumn(const std::filesystem::path& file, const std::string& key, const json& value, Row& row) {
  const auto column =
      std::find_if(std::begin(kColumns), std::end(kColumns), [&](const Column& c) { return key == c.name; });
  if (column == std::end(kColumns)) {
    std::vector<std::string> names = {"name"};
    for (const Column& c : kColumns) names.push_back(c.name);
    refuseTable(file, "material '" + row.name + "' has an unknown key '" + key + "'; " + nearestText(key, names));
  }
  const double number = value.is_number() ? value.get<double>() : -1.0;
  if (!(number >= 0 && number <= static_cast<double>(column->max))) {
    refuseTable(file, "material '" + row.name + "': " + key + " must be " + rangeOf(*column) + ", is " + shown(value));
  }
  row.*column->member = static_cast<float>(number);
}

/// Returns what is wrong with the names of a table; empty if nothing is. Names that are equal are rows that complete
/// one another.
std::string wrongNames(const MaterialTable& table) {
  std::map<std::string, const std::string*> known;
  for (const Row& row : table.rows) {
    const std::string& first = *known.emplace(lower(row.name), &row.name).first->second;
    if (first != row.name)
      return "has the materials '" + first + "' and '" + row.name +
             "', which are one, because case does not matter; keep one of them";
  }
  return "";
}

/// Returns text such as "'asphalt', 'brick', 'glass' and 12 more".
std::string shortList(const std::vector<std::string>& names) {
  constexpr size_t kShown = 3;
  std::string list;
  for (size_t i = 0; i < std::min(kShown, names.size()); ++i) list += (i ? ", '" : "'") + names[i] + "'";
  return names.size() > kShown ? list + " and " + std::to_string(names.size() - kShown) + " more" : list;
}

Row readRow(const std::filesystem::path& file, const json& entry) {
  if (!entry.is_object()) refuseTable(file, "a material must be an object, is " + shown(entry));
  const auto name = entry.find("name");
  if (name == entry.end() || !name->is_string()) refuseTable(file, "a material has no 'name': " + shown(entry));
  Row row;
  row.name = name->get<std::string>();
  for (const auto& [key, value] : entry.items()) {
    if (key != "name") readColumn(file, key, value, row);
  }
  return row;
}

}  // namespace

void validate(const MaterialTable& table) {
  for (const Row& row : table.rows)
    for (const Column& column : kColumns) {
      const float value = row.*column.member;
      if (value <= column.max) continue;
      throw Error(ErrorCode::invalidArgument, "material table, material '" + row.name + "': " + column.name +
                                                  " must be " + rangeOf(column) + ", or negative if not stated, is " +
                                                  numberText(double{value}));
    }
  const std::string wrong = wrongNames(table);
  if (!wrong.empty()) throw Error(ErrorCode::invalidArgument, "the material table " + wrong);
}

std::vector<std::string> warningsOf(const MaterialTable& table, const Scene& scene) {
  constexpr float kAll = 1.0001f;  // the sum of two shares as files round them
  std::vector<std::string> unused, empty, glowing, warnings;
  opticsOf(scene, table, 905, &unused);
  for (const Row& row : table.rows)
    if (std::ranges::none_of(kColumns, [&](const Column& column) { return row.*column.member >= 0; }))
      empty.push_back(row.name);
  if (!unused.empty())
    warnings.push_back("the material table has " + shortList(unused) + ", but the scene has no material of that name");
  std::map<std::string, Row> wholes;  // rows of one name complete one another
  for (const Row& row : table.rows) {
    Row& whole = wholes.try_emplace(lower(row.name), Row{row.name}).first->second;
    for (const Column& column : kColumns)
      if (row.*column.member >= 0) whole.*column.member = row.*column.member;
  }
  for (const auto& [name, row] : wholes)
    if (row.transmission > 0 && std::max(row.reflectance905, row.reflectance1550) + row.transmission > kAll)
      glowing.push_back(row.name);
  if (!glowing.empty())
    warnings.push_back(
        "the material table lets " + shortList(glowing) +
        " reflect and transmit more light than comes; reflectance and transmission together are 1 at most");
  if (!empty.empty()) warnings.push_back("the material table gives no values for " + shortList(empty));
  return warnings;
}

std::string warningOf(const MaterialTable& table, double wavelength) {
  std::map<std::string, const Row*> guessed;
  std::set<std::string> measured;
  for (const Row& row : table.rows) {
    const float here = wavelength == 1550 ? row.reflectance1550 : row.reflectance905;
    const float there = wavelength == 1550 ? row.reflectance905 : row.reflectance1550;
    if (here >= 0) measured.insert(lower(row.name));
    if (there >= 0) guessed.emplace(lower(row.name), &row);
  }
  std::vector<std::string> names;
  for (const auto& [name, row] : guessed)
    if (!measured.contains(name)) names.push_back(row->name);
  if (names.empty()) return "";
  const bool at1550 = wavelength == 1550;
  return "the material table has the reflectances of " + shortList(names) + " at " + (at1550 ? "905" : "1550") +
         " nm alone, so colours decide whether they are detected at " + (at1550 ? "1550" : "905") +
         " nm; give them, or another intensity.wavelength";
}

json readMaterialJson(const std::filesystem::path& file) {
  return parseStrict(readWholeFile(file, kMaxTableBytes), file.string());
}

MaterialTable loadMaterialTable(const std::filesystem::path& file) {
  const json root = readMaterialJson(file);
  MaterialTable table;
  const auto checked = [&] {
    const std::string wrong = wrongNames(table);
    if (!wrong.empty()) refuseTable(file, wrong);
    return std::move(table);
  };
  if (isOpenMaterial(root)) {
    table.rows = readOpenMaterial(root, file);
    return checked();
  }
  if (!root.is_object() || !root.contains("materials") || !root["materials"].is_array()) {
    if (lower(file.extension().string()) == ".xoma")
      refuseTable(file,
                  "is an asset of ASAM OpenMATERIAL 3D without 'materialMappingUri', which names the mapping of its "
                  "materials; add it, or give the mapping (.xomm) itself");
    refuseTable(
        file,
        "is neither {\"materials\": [{\"name\": ...}, ...]} nor an asset, mapping or material of ASAM OpenMATERIAL "
        "3D");
  }
  if (root.size() > 1) refuseTable(file, "holds more than 'materials'; take it out");
  for (const json& entry : root["materials"]) table.rows.push_back(readRow(file, entry));
  return checked();
}

}  // namespace gnosphere
