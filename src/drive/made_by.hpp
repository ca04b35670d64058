// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "drive/drive.hpp"

namespace gnosphere::drive {

/// Returns a text in JSON that says what makes frames: the version of GnoSphere, the device and its driver, the options
/// of the simulator, and which drive. Nothing in it depends on the time or the name of the machine, so runs that are
/// alike have the same text.
std::string madeByText(const Drive& drive, SimulatorOptions options, const DeviceInfo& device);

}  // namespace gnosphere::drive
