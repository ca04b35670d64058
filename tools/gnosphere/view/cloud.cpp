// SPDX-License-Identifier: Apache-2.0
#include "view/cloud.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>
#include <system_error>

#include "base/file.hpp"
#include "base/json_text.hpp"
#include "base/text.hpp"
#include "output/cloud_table.hpp"

namespace gnosphere::cli {
namespace {

namespace fs = std::filesystem;

/// Rows of 32-bit floats without a head, as KITTI and nuScenes have them.
CloudTable readFloats(std::string bytes, const std::string& source, const std::vector<const char*>& names) {
  CloudTable table;
  table.source = source;
  table.bytes = std::move(bytes);
  for (const char* name : names) table.columns.push_back({name});
  const size_t stride = names.size() * sizeof(float);
  if (table.bytes.size() % stride != 0)
    table.refuse("its " + std::to_string(table.bytes.size()) + " bytes are not rows of " + std::to_string(stride) +
                 " bytes");
  table.rows = table.bytes.size() / stride;
  table.layRows(0);
  return table;
}

CloudTable readTable(const fs::path& file) {
  const std::string name = file.string();
  const CloudFormat& format = cloudFormat(file);
  std::string bytes = readWholeFile(file);
  if (lower(name).ends_with(".pcd.bin"))
    return readFloats(std::move(bytes), name, {"x", "y", "z", "intensity", "ring"});
  if (lower(name).ends_with(".bin")) return readFloats(std::move(bytes), name, {"x", "y", "z", "intensity"});
  return readCloudTable(format, std::move(bytes), name);
}

/// Fields that we do not know have no more numbers of things than this: what has more is a quantity, as times and
/// reflectivities are.
constexpr size_t kMostIds = 100;

/// Whether the values of a column are numbers of things: whole, from 0 on, and of at most 32 bits. The type of the
/// fields that we know counts, because some formats hold rings as floats.
bool holdsIds(const CloudTable& table, const CloudColumn& column) {
  const ColumnInfo* known = findColumn(column.name);
  if (known ? known->type == ValueType::f32 : column.type == 'F') return false;
  std::set<double> found;
  for (size_t row = 0; row < table.rows; ++row) {
    const double value = table.value(column, row);
    if (!(value >= 0 && value <= UINT32_MAX && value == std::floor(value))) return false;
    if (!known && found.insert(value).second && found.size() > kMostIds) return false;
  }
  return true;
}

/// The numbers of the beams and returns of rows; nothing if the table does not tell the beams.
std::optional<std::vector<uint64_t>> returnsOf(const CloudTable& table, const std::vector<size_t>& rows) {
  const CloudColumn *beam = table.find("beam"), *number = table.find("return");
  if (!beam || !holdsIds(table, *beam) || (number && !holdsIds(table, *number))) return {};
  const std::vector<uint32_t> numbers = numberReturns(table);
  std::vector<uint64_t> returns;
  returns.reserve(rows.size());
  for (const size_t row : rows)
    returns.push_back(static_cast<uint64_t>(table.value(*beam, row)) << 32 | (numbers.empty() ? 1 : numbers[row]));
  return returns;
}

ValueNames namesOf(const std::string& column, const fs::path& file) {
  if (column == "class") return classNames(file.parent_path());
  if (column == "label") return {{0, "no return"}, {1, "surface"}, {2, "fog, rain, snow or dust"}};
  return {};
}

/// Appends the class and the instance of SemanticKITTI's labels, if the cloud has any.
void addLabels(const fs::path& file, const std::vector<size_t>& rows, size_t rowCount, ViewCloud& cloud) {
  const fs::path labels = file.parent_path().parent_path() / "labels" / file.filename().replace_extension(".label");
  std::error_code absent;
  if (!fs::exists(labels, absent)) return;
  const std::string bytes = readWholeFile(labels);
  if (bytes.size() != rowCount * sizeof(uint32_t))
    throw Error(ErrorCode::format, labels.string() + ": has " + std::to_string(bytes.size() / sizeof(uint32_t)) +
                                       " labels, the cloud has " + std::to_string(rowCount) + " points");
  ViewColumn category{"class", true, {}, namesOf("class", file)}, instance{"instance", true, {}, {}};
  category.names.try_emplace(1, "outlier");
  for (size_t row : rows) {
    uint32_t label;
    std::memcpy(&label, bytes.data() + row * sizeof(label), sizeof(label));
    category.values.push_back(label & 0xffff);
    instance.values.push_back(label >> 16 ? static_cast<double>(label >> 16) : NAN);
  }
  cloud.columns.push_back(std::move(category));
  cloud.columns.push_back(std::move(instance));
}

}  // namespace

const ViewColumn* ViewCloud::find(const std::string& name) const {
  const auto found = std::find_if(columns.begin(), columns.end(), [&](const auto& c) { return c.name == name; });
  return found == columns.end() ? nullptr : &*found;
}

nlohmann::json readJson(const fs::path& file) {
  nlohmann::json json = parseJson(readWholeFile(file), false);
  if (json.is_discarded()) throw Error(ErrorCode::format, file.string() + ": is no JSON");
  return json;
}

ValueNames classNames(const fs::path& folder) {
  ValueNames names;
  const fs::path file = folder / "classes.json";
  std::error_code absent;
  if (!fs::exists(file, absent)) return names;
  const nlohmann::json classes = readJson(file);
  for (const auto& [name, id] : classes.items()) {
    if (!classes.is_object() || !id.is_number_unsigned() || id.get<uint64_t>() > UINT32_MAX)
      throw Error(ErrorCode::format, file.string() + ": is no object of names with the numbers of classes");
    names[id.get<uint32_t>()] = name;
  }
  return names;
}

ViewCloud readViewCloud(const fs::path& file, const std::optional<Origin>& origin) {
  const CloudTable table = readTable(file);
  const auto axes = table.axes();
  if (!axes[0] || !axes[1] || !axes[2])
    table.refuse("has no x, y and z, so it cannot be shown; scan with these fields");
  ViewCloud cloud;
  cloud.origin = origin ? *origin : table.originNearby();
  cloud.floatStep = table.floatStep(cloud.origin);
  std::vector<size_t> rows;
  for (size_t row = 0; row < table.rows; ++row) {
    float point[3];
    for (size_t axis = 0; axis < 3; ++axis)
      point[axis] = static_cast<float>(table.value(*axes[axis], row) - cloud.origin[axis]);
    if (!std::isfinite(point[0]) || !std::isfinite(point[1]) || !std::isfinite(point[2])) continue;
    rows.push_back(row);
    cloud.points.insert(cloud.points.end(), point, point + 3);
  }
  cloud.misses = table.rows - rows.size();
  cloud.returns = returnsOf(table, rows);
  for (const CloudColumn& column : table.columns) {
    // Histograms have many values per point.
    const bool isAxis = std::find(axes.begin(), axes.end(), &column) != axes.end();
    if (isAxis || column.count != 1 || column.name == kGapName) continue;
    ViewColumn& out = cloud.columns.emplace_back(ViewColumn{column.name, holdsIds(table, column), {}, {}});
    if (out.isId) out.names = namesOf(out.name, file);
    out.values.reserve(rows.size());
    for (size_t row : rows) {
      const double value = table.value(column, row);
      out.values.push_back(std::isfinite(value) && !(out.isId && value == UINT32_MAX) ? value : NAN);
    }
  }
  if (!cloudFormat(file).read) addLabels(file, rows, table.rows, cloud);
  return cloud;
}

ViewCloud everyNth(const ViewCloud& cloud, size_t n) {
  ViewCloud some;
  some.misses = cloud.misses;
  some.origin = cloud.origin;
  for (size_t i = 0; i < cloud.size(); i += n)
    some.points.insert(some.points.end(), &cloud.points[3 * i], &cloud.points[3 * i] + 3);
  for (const ViewColumn& column : cloud.columns) {
    ViewColumn& out = some.columns.emplace_back(ViewColumn{column.name, column.isId, {}, column.names});
    for (size_t i = 0; i < cloud.size(); i += n) out.values.push_back(column.values[i]);
  }
  return some;
}

}  // namespace gnosphere::cli
