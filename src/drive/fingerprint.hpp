// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "drive/drive.hpp"

namespace gnosphere::drive {

/// Returns a hash of everything that the frames of a drive depend on: the drive file's own text, and the triangles,
/// materials, trajectories, sensors and effects that it names.
std::string fingerprintOf(const Drive& drive, std::string_view driveFile);

}  // namespace gnosphere::drive
