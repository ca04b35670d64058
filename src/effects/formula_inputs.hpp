// SPDX-License-Identifier: Apache-2.0
// A request, as the numbers and tables that the formulas of shaders/effects read.
#pragma once

#include <cstdint>
#include <vector>

#include "effects/parameters.h"
#include "gnosphere/effects.hpp"
#include "gnosphere/scan.hpp"
#include "gnosphere/sensor.hpp"

namespace gnosphere {

/// Of the effects that `planned` (bits of effects/plan.h) names; both have been validated. `sensor` and
/// `frame` are left 0 for the backend.
gpu::EffectParameters effectParameters(const Effects& effects, const Sensor& sensor, uint32_t planned);

/// One line of a footprint: tangents of its angles to the beam's axis, `u` to the left and `v` up.
struct SubRay {
  float u = 0, v = 0;
  float weight = 1;  ///< share of the beam's energy
};

/// The footprint of every beam; weights add up to 1. One line along the axis where divergence is not planned.
std::vector<SubRay> subRays(const Effects& effects, const Sensor& sensor, uint32_t planned);

/// The boxes of dust in the frame of a sensor with that pose. A scan in motion has them in the frame of its middle.
std::vector<gpu::VolumeBox> volumeBoxes(const Effects& effects, const Pose& pose);

/// One bit per beam of the sensor, 32 beams a word; empty if no beam is dead. decide() has refused beams that there are
/// not.
std::vector<uint32_t> deadBeamBits(const Effects& effects, const Sensor& sensor);

}  // namespace gnosphere
