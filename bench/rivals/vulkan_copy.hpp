// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace gnosphere::bench {

/// Bytes read and written per millisecond by copies within the device's memory, by its own clock, at best; 0 for a
/// device that has none or does not trace rays. `device`: as SimulatorOptions::device.
double vulkanCopyRate(const std::string& device);

}  // namespace gnosphere::bench
