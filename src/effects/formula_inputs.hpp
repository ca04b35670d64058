// SPDX-License-Identifier: Apache-2.0
// Converts a request into the numbers and tables that the formulas of common/effects read.
#pragma once

#include <cstdint>
#include <vector>

#include "common/effects/parameters.h"
#include "gnosphere/effects.hpp"
#include "gnosphere/scan.hpp"
#include "gnosphere/sensor.hpp"

namespace gnosphere {

/// Returns the parameters of the effects in `planned` (bits of effects/bits.h). `effects` and `sensor` must be valid.
/// The members `sensor` and `frame` stay 0; the backend sets them.
gpu::EffectParameters effectParameters(const Effects& effects, const Sensor& sensor, uint32_t planned);

/// The weakest target that is detected: its reflectance, its range in metres, and whether the sensor states them.
struct WeakestTarget {
  double reflectance, range;
  bool stated;
};
WeakestTarget weakestTarget(const Effects::Detection& detection, const Sensor& sensor);

/// Return the full angles of a footprint in radians, each from the request or else from the sensor.
double horizontalSpread(const Effects& effects, const Sensor& sensor);
double verticalSpread(const Effects& effects, const Sensor& sensor);

/// Returns the part of the key of the random numbers that the number of a scan gives: the number itself up to 32
/// bits. Longer numbers share their keys with others, but not with those that differ in a single bit.
uint32_t keyOfFrame(uint64_t frame);

/// One sub-ray of a footprint: the tangents of its angles to the beam's axis, `u` to the left and `v` up.
struct SubRay {
  float u = 0, v = 0;
  float weight = 1;  ///< share of the beam's energy
};

/// Returns the footprint that all beams share; its weights add up to 1. Without divergence it is one ray along the
/// axis.
std::vector<SubRay> subRays(const Effects& effects, const Sensor& sensor, uint32_t planned);

/// Returns the dust boxes in the frame of a sensor at `pose`. For a scan with motion that is the pose at its middle.
std::vector<gpu::VolumeBox> volumeBoxes(const Effects& effects, const Pose& pose);

/// Returns one bit per beam of the sensor, 32 per word; empty if no beam is dead. The indices are in range, because
/// decide() has checked them.
std::vector<uint32_t> deadBeamBits(const Effects& effects, const Sensor& sensor);

}  // namespace gnosphere
