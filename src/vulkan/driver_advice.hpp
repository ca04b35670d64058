// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/os.hpp"

namespace gnosphere::vulkan {

/// The end of messages that no Vulkan driver is there. A package that has a way of its own to bring one says so before
/// anything else calls the library.
inline const char* driverAdvice = os::vulkanAdvice();

}  // namespace gnosphere::vulkan
