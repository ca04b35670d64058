// SPDX-License-Identifier: Apache-2.0
// What is simulated beside geometry, as the command line says it.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "gnosphere/gnosphere.hpp"

namespace gnosphere::cli {

struct EffectOptions {
  std::string effects = "auto", seed, materials;
  std::vector<std::string> assignments;
};

/// --effects, --effect, --seed, --materials.
void addEffectOptions(CLI::App& app, EffectOptions& options);

/// The preset or file, then the assignments in their order, then the seed. Throws Error as findEffects() and assign().
Effects effectsOf(const EffectOptions& options);

/// Empty without --materials. Throws Error(file) or Error(format).
MaterialTable materialsOf(const EffectOptions& options);

/// On stderr: rows of the table that no material of the scene has the name of, and rows that state nothing.
void warnAboutMaterials(const EffectOptions& options, const Scene& scene, const MaterialTable& table);

}  // namespace gnosphere::cli
