// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "gnosphere/ros2.hpp"

namespace gnosphere::ros2 {

/// Throws Error(invalidArgument) if the sizes in a message contradict each other, or a text holds a zero.
void check(const Message& message);

}  // namespace gnosphere::ros2
