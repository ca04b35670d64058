// SPDX-License-Identifier: Apache-2.0
// Splits the variables of a SPIR-V module's functions into a variable for each scalar.
#pragma once

#include <set>
#include <vector>

#include "vulkan/live_branches.hpp"
#include "vulkan/types.hpp"

namespace gnosphere::vulkan {

/// Replaces each variable of several scalars, such as a vector or a structure, by variables of its scalars, if it has
/// at most 64 and is only indexed by constants, and each pointer to such a variable that a function gets by pointers to
/// the scalars, unless the parameter is `decorated`. lavapipe keeps a vector that several stores may have written in
/// one place, and reads all of it wherever a shader uses one scalar.
void splitVariables(std::vector<LiveFunction>& functions, Types& types, const KnownValues& values,
                    const std::set<uint32_t>& decorated);

}  // namespace gnosphere::vulkan
