// SPDX-License-Identifier: Apache-2.0
// Functions of a SPIR-V module in the place of their only call.
#pragma once

#include <set>
#include <stdexcept>

#include "vulkan/live_branches.hpp"

namespace gnosphere::vulkan {

/// Moves each function that only one instruction calls into its caller, if its last instruction is its only return and
/// none of its parameters is `decorated`. Drivers inline all functions, but first into functions that they inline
/// elsewhere, too: the innermost ones as often as calls are nested. Throws std::logic_error for a module that glslang
/// does not make.
void inlineSingleCalls(std::vector<LiveFunction>& functions, const std::set<uint32_t>& decorated);

}  // namespace gnosphere::vulkan
