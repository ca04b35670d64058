// SPDX-License-Identifier: Apache-2.0
// A device's functions, which a test may replace.
#pragma once

#include "vulkan/device.hpp"

namespace gnosphere::test {

/// Returns the table of the device's functions, writable.
inline vulkan::DeviceFunctions& functionsOf(vulkan::Device& device) {
  return const_cast<vulkan::DeviceFunctions&>(device.vk());
}

}  // namespace gnosphere::test
