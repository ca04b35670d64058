// SPDX-License-Identifier: Apache-2.0
// Divides the beams of a sensor by the places that they leave from.
#pragma once

#include <vector>

#include "sensor/beams.hpp"

namespace gnosphere {

/// Beams that leave from places so close together that they are projected at once, seen from a place between them.
struct OriginGroup {
  OriginBounds lasers;
  std::vector<uint32_t> beams, silent;  ///< numbers in ascending order: of those that fire, and of masked ones
};

/// Divides the beams that scan number `frame` fires. A grid, and a list whose lasers are all near the sensor's origin,
/// is one group, seen from the sensor's origin; a list with all lasers at one point is seen from there. The groups do
/// not depend on the order of the beams.
std::vector<OriginGroup> originGroups(const Sensor& sensor, uint64_t frame);

}  // namespace gnosphere
