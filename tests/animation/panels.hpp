// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace gnosphere::test {

/// A glTF file, z-up: two upright panels of 3 m in the plane x = 0, at y = 1 to 4 and y = -4 to -1. In one second of
/// its animation `push` they go to x = 1, the first by a morph target, the second as a whole.
std::string panels();

/// A glTF file with a blade, whose tips are 0.2 m from the axis about which the clip "spin" turns it a hundred times a
/// second. Its node turns, or, if it is skinned, the joint that its vertices follow.
std::string rotor(bool skinned = false);

/// A glTF file, z-up, with a cube of 1 m around the origin, whose clip "move" moves or scales its node linearly: `path`
/// is "translation" or "scale", with 3 values per time.
std::string movedCube(const char* path, const std::vector<float>& times, const std::vector<float>& values);

}  // namespace gnosphere::test
