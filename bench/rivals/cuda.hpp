// SPDX-License-Identifier: Apache-2.0
// Finds the CUDA device that is the same card as a Vulkan device.
#pragma once

#include <string>
#include <vector>

#include "gnosphere/simulator.hpp"

namespace gnosphere::bench {

/// Returns the index of the CUDA device that is the card of a Vulkan device: by UUID if both drivers report one, else
/// the first with the same name. Throws Error(device) with the reason if there is none; `problem` is the reason if the
/// list is empty.
size_t sameCard(const DeviceInfo& vulkan, const std::vector<DeviceInfo>& cuda, const std::string& problem);

}  // namespace gnosphere::bench
