// SPDX-License-Identifier: Apache-2.0
// ASAM OpenMATERIAL 3D 1.0: an asset (.xoma) names a mapping (.xomm), which names a material (.xomp) per material of
// the geometry, which names its property tables (.xompt). Two kinds of table give the reflectance:
// - a BRDF with rows [wavelength m, incidence, exit zenith, exit azimuth rad, value 1/sr]. The row nearest to normal
//   incidence and exit is used; a Lambertian surface with that value has a reflectance of pi times the value;
// - optical properties with rows [wavelength m, temperature K, n, k] of a conductor: its Fresnel reflectance at normal
//   incidence is taken as diffuse, as on a rough surface. Dielectrics are skipped, because most of their reflected
//   light comes from inside, and n does not tell how much.
#include "effects/openmaterial.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <system_error>
#include <utility>

#include "base/json_text.hpp"
#include "base/path.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere {
namespace {

using nlohmann::json;
using std::filesystem::path;

constexpr double kNearWavelength = 60e-9;  // m: lasers sold as 905 nm span 850 to 940
constexpr double kNearNormal = 0.175;      // rad, 10 degrees: cos is 1 within 2 %
constexpr double kConductor = 1;           // extinction coefficient k; glass has 1e-6, aluminium 8

[[noreturn]] void refuseMapping(const path& file, const std::string& why) {
  throw Error(ErrorCode::format, file.string() + ": " + why);
}

const json& member(const path& file, const json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end()) refuseMapping(file, "'" + std::string(key) + "' is missing");
  return *found;
}

path besides(const path& file, const json& uri) {
  if (!uri.is_string()) refuseMapping(file, "the name of a file is not a text but " + shown(uri));
  return file.parent_path() / pathOf(uri.get<std::string>());
}

/// Returns the first kCount numbers of a row; nothing if one of them is null or missing.
template <size_t kCount>
std::optional<std::array<double, kCount>> numbers(const json& row) {
  if (!row.is_array() || row.size() < kCount) return {};
  std::array<double, kCount> values;
  for (size_t i = 0; i < kCount; ++i) {
    if (!row[i].is_number()) return {};
    values[i] = row[i].get<double>();
  }
  return values;
}

/// Returns the row with the smallest `distance`; nothing if it is infinite for all rows.
template <size_t kColumns, class Distance>
std::optional<std::array<double, kColumns>> nearestRow(const json& table, Distance distance) {
  std::optional<std::array<double, kColumns>> nearest;
  double least = INFINITY;
  for (const json& row : table) {
    const auto values = numbers<kColumns>(row);
    const double now = values ? distance(*values) : INFINITY;
    if (!(now < least)) continue;
    least = now;
    nearest = values;
  }
  return nearest;
}

/// Returns the reflectance of the equivalent Lambertian surface; negative if the table has no suitable row.
float brdfReflectance(const json& table, double wavelength) {
  const auto row = nearestRow<5>(table, [&](const auto& r) -> double {
    const double off = std::abs(r[0] - wavelength);
    if (off > kNearWavelength || r[1] > kNearNormal || r[2] > 2 * kNearNormal) return INFINITY;
    return r[1] + std::abs(r[2] - r[1]) + (1 - std::cos(r[3])) * r[2] + off / kNearWavelength;
  });
  return row ? static_cast<float>(std::clamp(std::numbers::pi * (*row)[4], 0.0, 1.0)) : -1.0f;
}

float conductorReflectance(const json& table, double wavelength) {
  const auto row = nearestRow<4>(table, [&](const auto& r) -> double {
    const double off = std::abs(r[0] - wavelength);
    return off > kNearWavelength ? INFINITY : off;
  });
  if (!row || (*row)[3] < kConductor) return -1;
  const double n = (*row)[2], k2 = (*row)[3] * (*row)[3];
  return static_cast<float>(((n - 1) * (n - 1) + k2) / ((n + 1) * (n + 1) + k2));
}

/// The key of a file, whatever links and dots are in its path.
path keyOf(const path& file) {
  std::error_code failed;
  const path key = std::filesystem::weakly_canonical(file, failed);
  return failed ? file : key;
}

/// Reads materials and their tables, each file once.
class MaterialReader {
 public:
  MaterialTable::Row read(const path& file, std::string name) {
    const auto [found, isNew] = materials_.try_emplace(keyOf(file));
    if (isNew) found->second = read(readMaterialJson(file), file, "");
    MaterialTable::Row row = found->second;
    row.name = std::move(name);
    return row;
  }

  MaterialTable::Row read(const json& root, const path& file, std::string name) {
    const json& properties = member(file, root, "materialProperties");
    MaterialTable::Row row;
    row.name = std::move(name);
    if (properties.contains("brdfUris"))
      for (const json& uri : properties["brdfUris"]) complete(row, ofBrdf(besides(file, uri)));
    if (properties.contains("opticalPropertiesUri"))
      complete(row, ofConductor(besides(file, properties["opticalPropertiesUri"])));
    return row;
  }

 private:
  /// At 905 and 1550 nm; negative where a table has no suitable row.
  using Reflectances = std::array<float, 2>;

  static Reflectances reflectances(const json& table, float (*reflectance)(const json&, double)) {
    return {reflectance(table, 905e-9), reflectance(table, 1550e-9)};
  }

  const Reflectances& ofBrdf(const path& file) {
    const auto [found, isNew] = brdfs_.try_emplace(keyOf(file));
    if (isNew) {
      const json table = readMaterialJson(file);
      found->second = reflectances(member(file, member(file, table, "brdf"), "lookupTable"), brdfReflectance);
    }
    return found->second;
  }

  const Reflectances& ofConductor(const path& file) {
    const auto [found, isNew] = conductors_.try_emplace(keyOf(file));
    if (isNew) {
      const json table = readMaterialJson(file);
      found->second = reflectances(member(file, table, "opticalProperties"), conductorReflectance);
    }
    return found->second;
  }

  /// Sets the reflectances that the row does not state yet.
  static void complete(MaterialTable::Row& row, const Reflectances& stated) {
    if (row.reflectance905 < 0) row.reflectance905 = stated[0];
    if (row.reflectance1550 < 0) row.reflectance1550 = stated[1];
  }

  std::map<path, MaterialTable::Row> materials_;
  std::map<path, Reflectances> brdfs_, conductors_;
};

bool states(const MaterialTable::Row& row) {
  return row.reflectance905 >= 0 || row.reflectance1550 >= 0;
}

}  // namespace

bool isOpenMaterial(const json& root) {
  return root.is_object() && (root.contains("materialMappingUri") || root.contains("materialMapping") ||
                              root.contains("materialProperties"));
}

std::vector<MaterialTable::Row> readOpenMaterial(const json& root, const path& file) {
  if (root.contains("materialMappingUri")) {
    const path mapping = besides(file, root["materialMappingUri"]);
    const json table = readMaterialJson(mapping);
    if (!table.is_object() || !table.contains("materialMapping") || table.contains("materialMappingUri")) {
      refuseMapping(mapping, "is not a mapping of ASAM OpenMATERIAL 3D");
    }
    return readOpenMaterial(table, mapping);
  }
  std::vector<MaterialTable::Row> rows;
  MaterialReader reader;
  if (root.contains("materialMapping")) {
    for (const json& entry : root["materialMapping"]) {
      if (!entry.is_array() || entry.size() < 2 || !entry[0].is_string()) {
        refuseMapping(file, "an entry of 'materialMapping' is not [name, file, ...] but " + shown(entry));
      }
      rows.push_back(reader.read(besides(file, entry[1]), entry[0].get<std::string>()));
    }
  } else {
    const json& name = member(file, member(file, root, "metadata"), "name");
    if (!name.is_string()) refuseMapping(file, "the material's name is not a text but " + shown(name));
    rows.push_back(reader.read(root, file, name.get<std::string>()));
  }
  if (std::none_of(rows.begin(), rows.end(), states)) {
    refuseMapping(
        file,
        "states no reflectance for a laser: it takes a BRDF within 10 degrees of the normal, or a conductor's "
        "optical properties, at 905 or 1550 nm");
  }
  return rows;
}

}  // namespace gnosphere
