// SPDX-License-Identifier: Apache-2.0
// Functions of a SPIR-V module that take values in place of pointers to variables.
#pragma once

#include <set>
#include <vector>

#include "vulkan/live_branches.hpp"
#include "vulkan/types.hpp"

namespace gnosphere::vulkan {

/// Replaces each parameter that is a pointer to a variable by the value of the variable, if the function only reads the
/// value, with constant indices, and the parameter is not `decorated`. glslang passes all parameters as pointers to
/// copies, which drivers split into their scalars, once for each copy of the function.
void passValues(std::vector<LiveFunction>& functions, Types& types, const KnownValues& values,
                const std::set<uint32_t>& decorated);

}  // namespace gnosphere::vulkan
