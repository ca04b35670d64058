// SPDX-License-Identifier: Apache-2.0
// The command line's options for effects and materials.
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

/// Adds --effects, --effect, --seed and --materials.
void addEffectOptions(CLI::App& app, EffectOptions& options);

/// The effects that --effects names: those of a preset or of a JSON file.
Effects presetOrFile(const std::string& nameOrFile);

/// Combines the preset or file, the assignments in their order, and the seed. Throws Error as presetOrFile() and
/// assign() do.
Effects effectsOf(const EffectOptions& options);

/// Reads --materials; empty without it. Throws Error(file) or Error(format) if the file cannot be read or is invalid.
MaterialTable materialsOf(const EffectOptions& options);

}  // namespace gnosphere::cli
