// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "gnosphere/effects.hpp"

namespace gnosphere {

/// Throws Error(invalidArgument) that names the material if a value is NaN or too large; negative ones are not stated.
/// So does a table with names that differ in case alone, because they mean the same materials.
void validate(const MaterialTable& table);

/// Returns sentences about rows without effect: those whose name no material of the scene has, and those without any
/// value.
std::vector<std::string> warningsOf(const MaterialTable& table, const Scene& scene);

}  // namespace gnosphere
