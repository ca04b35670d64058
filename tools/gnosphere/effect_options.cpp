// SPDX-License-Identifier: Apache-2.0
#include "effect_options.hpp"

#include "base/path.hpp"
#include "effects/effect_table.hpp"
#include "effects/parameter_text.hpp"
#include "scanning.hpp"

namespace gnosphere::cli {

void addEffectOptions(CLI::App& app, EffectOptions& options) {
  std::string presets;
  for (const std::string& name : effectPresets()) presets += (presets.empty() ? "" : ", ") + name;
  app.add_option("--effects", options.effects,
                 "Effects to simulate besides geometry: " + presets + " or a JSON file, also one of CARLA's lidars")
      ->capture_default_str();
  app.add_option("--effect", options.assignments,
                 "Change --effects by NAME=VALUE, as fog.visibility=200 or divergence=off; may be given more than once")
      ->allow_extra_args(false);
  app.add_option("--seed", options.seed,
                 "Seed of all random numbers: the same seed gives the same scan (default: " +
                     defaultText(seedParameter()) + ", unless a file of --effects states one)");
  app.add_option("--materials", options.materials,
                 "A JSON file of reflectances by material, or ASAM OpenMATERIAL 3D (.xoma, .xomm, .xomp)");
}

Effects presetOrFile(const std::string& nameOrFile) {
  return namedOrLoaded<Effects>(nameOrFile, effectPreset,
                                [](const std::filesystem::path& file) { return loadEffects(file); });
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

}  // namespace gnosphere::cli
