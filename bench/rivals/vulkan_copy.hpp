// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace gnosphere::bench {

/// Returns the highest rate of copies within the device's memory, in bytes read and written per millisecond by its own
/// clock; 0 if it has no clock or does not trace rays. `device` is a value for SimulatorOptions::device.
double vulkanCopyRate(const std::string& device);

}  // namespace gnosphere::bench
