// SPDX-License-Identifier: Apache-2.0
// The same card by CUDA.
#pragma once

#include <string>
#include <vector>

#include "gnosphere/simulator.hpp"

namespace gnosphere::bench {

/// Which of the CUDA devices is the card of a Vulkan one: by its UUID where the drivers tell one, else the first of its
/// name. Throws Error(device) that says why there is none; `problem` is what it says where the list is empty.
size_t sameCard(const DeviceInfo& vulkan, const std::vector<DeviceInfo>& cuda, const std::string& problem);

}  // namespace gnosphere::bench
