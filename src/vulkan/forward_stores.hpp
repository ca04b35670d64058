// SPDX-License-Identifier: Apache-2.0
// Functions of a SPIR-V module without the variables that hold a single value.
#pragma once

#include <vector>

#include "vulkan/live_branches.hpp"

namespace gnosphere::vulkan {

/// Removes the variables whose single store dominates their loads, and that are indexed by constants alone: each load
/// becomes the stored value. Removes the variables that are only stored, and the values that are then unused. Drivers
/// do the same, but only after they have copied every function into its callers. `bound` is larger than every id of the
/// module.
void forwardStores(std::vector<LiveFunction>& functions, const KnownValues& values, uint32_t bound);

}  // namespace gnosphere::vulkan
