// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "gnosphere/ros2.hpp"

namespace gnosphere::ros2 {

/// The largest value of Field::ring of any beam in any scan of a sensor; 0 without beams.
uint32_t lastRingOf(const Sensor& sensor);

/// Returns why the types of a driver do not hold all scans of a sensor; empty if they do. Without a driver the scans
/// are Livox's messages of its own.
std::string mistakeOfDriver(const Sensor& sensor, std::optional<Driver> driver);

}  // namespace gnosphere::ros2
