// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "gnosphere/effects.hpp"

namespace gnosphere {

/// Throws Error(invalidArgument) that names the material if a value is NaN or too large; a negative value is not
/// stated. The function also throws if two names differ in case alone, because such names mean the same material.
void validate(const MaterialTable& table);

/// Returns sentences about rows without effect, whose name no material of the scene has, or which have no value, and
/// about materials that reflect and transmit more light than comes.
std::vector<std::string> warningsOf(const MaterialTable& table, const Scene& scene);

/// Returns a sentence about materials whose reflectances the table has at the other wavelength alone; empty if there
/// are none.
std::string warningOf(const MaterialTable& table, double wavelength);

}  // namespace gnosphere
