// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "gnosphere/effects.hpp"

namespace gnosphere {

/// Throws Error(invalidArgument) that names the material if a value is NaN or too large; a negative value is not
/// stated. The function also throws if two names differ in case alone, because such names mean the same material.
void validate(const MaterialTable& table);

/// Returns sentences about rows without effect: those whose name no material of the scene has, and those without any
/// value.
std::vector<std::string> warningsOf(const MaterialTable& table, const Scene& scene);

}  // namespace gnosphere
