// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "base/os.hpp"

namespace gnosphere::vulkan {

/// Advice on how to get a Vulkan driver. A package that has a way of its own to bring one says so before anything else
/// calls the library.
inline const char* driverAdvice = os::vulkanAdvice();

/// The end of messages that no Vulkan driver is there: the advice, or the variable that names other drivers.
std::string driverRemedy();

}  // namespace gnosphere::vulkan
