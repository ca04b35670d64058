// SPDX-License-Identifier: Apache-2.0
#include "effect_options.hpp"

#include <algorithm>

#include "base/path.hpp"
#include "console.hpp"
#include "scanning.hpp"

namespace gnosphere::cli {
namespace {

/// Returns text such as "'asphalt', 'brick', 'glass' and 12 more".
std::string quoted(const std::vector<std::string>& names) {
  constexpr size_t kShown = 3;
  std::string list;
  for (size_t i = 0; i < std::min(kShown, names.size()); ++i) list += (i ? ", '" : "'") + names[i] + "'";
  return names.size() > kShown ? list + " and " + grouped(names.size() - kShown) + " more" : list;
}

}  // namespace

void addEffectOptions(CLI::App& app, EffectOptions& options) {
  std::string presets;
  for (const std::string& name : effectPresets()) presets += (presets.empty() ? "" : ", ") + name;
  app.add_option("--effects", options.effects, "Effects to simulate besides geometry: " + presets + " or a JSON file")
      ->capture_default_str();
  app.add_option("--effect", options.assignments,
                 "Change --effects by NAME=VALUE, as fog.visibility=200 or divergence=off; may be given more than once")
      ->allow_extra_args(false);
  app.add_option("--seed", options.seed, "Seed of all random numbers: the same seed gives the same scan");
  app.add_option("--materials", options.materials,
                 "A JSON file of reflectances by material, or ASAM OpenMATERIAL 3D (.xoma, .xomm, .xomp)");
}

Effects presetOrFile(const std::string& nameOrFile) {
  return namedOrLoaded(nameOrFile, effectPreset, loadEffects);
}

Effects effectsOf(const EffectOptions& options) {
  Effects effects = presetOrFile(options.effects);
  const auto set = [&](const char* option, const std::string& assignment) {
    try {
      assign(effects, assignment);
    } catch (const Error& error) {
      throw Error(error.code(), std::string(option) + ": " + error.what());
    }
  };
  for (const std::string& assignment : options.assignments) set("--effect", assignment);
  if (!options.seed.empty()) set("--seed", "seed=" + options.seed);
  return effects;
}

MaterialTable materialsOf(const EffectOptions& options) {
  return options.materials.empty() ? MaterialTable() : loadMaterialTable(pathOf(options.materials));
}

void warnAboutMaterials(const EffectOptions& options, const Scene& scene, const MaterialTable& table) {
  std::vector<std::string> unused, empty;
  opticsOf(scene, table, 905, &unused);
  for (const MaterialTable::Row& row : table.rows) {
    const float stated =
        std::max({row.reflectance905, row.reflectance1550, row.roughness, row.retro, row.transmission});
    if (stated < 0) empty.push_back(row.name);
  }
  if (!unused.empty()) {
    complain("warning: " + options.materials + " has " + quoted(unused) +
             ", but the scene has no material of that name");
  }
  if (!empty.empty()) complain("warning: " + options.materials + " gives no values for " + quoted(empty));
}

}  // namespace gnosphere::cli
