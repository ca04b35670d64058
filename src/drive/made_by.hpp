// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "drive/scanner.hpp"

namespace gnosphere::drive {

/// Returns a text in JSON that says what makes frames: the version of GnoSphere, the device and its driver, the options
/// of the simulator, which drive, the effects that scans of each sensor simulate, the files that were read with their
/// SHA-256, and the warnings of the drive file. Nothing in it depends on the time or the name of the machine, so runs
/// that are alike have the same text. Throws Error(file) if one of the files can no longer be read.
std::string madeByText(const Drive& drive, SimulatorOptions options, const Scanner& scanner);

}  // namespace gnosphere::drive
