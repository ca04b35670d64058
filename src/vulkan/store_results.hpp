// SPDX-License-Identifier: Apache-2.0
// Lets functions of a SPIR-V module store their results in variables of their callers.
#pragma once

#include <vector>

#include "vulkan/live_branches.hpp"
#include "vulkan/types.hpp"

namespace gnosphere::vulkan {

/// Gives each function that returns vectors or structures at several places a pointer to a variable of its caller
/// instead, so that splitVariables() finds the variable. Drivers make such a variable, too, but as a whole.
void storeResults(std::vector<LiveFunction>& functions, Types& types);

}  // namespace gnosphere::vulkan
