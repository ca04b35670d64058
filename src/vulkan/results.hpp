// SPDX-License-Identifier: Apache-2.0
// What a frame in flight leaves -> Scan.
#pragma once

#include "vulkan/sensor_state.hpp"

namespace gnosphere::vulkan {

/// What does not come from the device, and room for what does. Arrays keep theirs.
void clearResult(std::span<const SensorState> parts, const Instances& instances, Scan& scan);

/// Arrays and counters of one part of a shot's sensor, whose beams begin at `firstBeam`.
void readResults(const SensorState& part, const FrameInFlight& frame, const Instances& instances, const Shot& shot,
                 uint64_t firstBeam, Scan& scan);

}  // namespace gnosphere::vulkan
