// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace gnosphere::test {

/// A glTF file, z-up: two upright panels of 3 m in the plane x = 0, at y = 1 to 4 and y = -4 to -1. In one second of
/// its animation `push` they go to x = 1, the first by a morph target, the second as a whole.
std::string panels();

}  // namespace gnosphere::test
