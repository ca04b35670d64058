// SPDX-License-Identifier: Apache-2.0
// A beam of a sensor, its sub-rays and the echoes they make, in double.
#pragma once

#include "effects/beam_signal.hpp"
#include "effects/sensor_plan.hpp"
#include "reference/trace.hpp"

namespace gnosphere::reference {

/// What is planned for one sensor.
struct BeamEffects {
  SensorPlan plan;
  std::vector<gpu::Optics4> optics;  ///< per material
};

std::vector<BeamEffects> beamEffects(const SimulatorOptions& options, const Scene& scene,
                                     const std::vector<Sensor>& sensors);

struct Beam {
  Line axis;
  Vec3 origin;    ///< of the laser, in the sensor's frame
  Vec3 left, up;  ///< across the axis, in that frame
  Pose pose;      ///< of the sensor as the beam is fired
};

Beam beamOf(const Sensor& sensor, const Shot& shot, bool sensorMoves, size_t index);

/// What comes back from one depth: the strongest of its hits stands for it.
struct BeamEcho {
  double range = 0, energy = 1, width = 0;
  Hit hit;
};

/// What single precision may see otherwise.
struct BeamDoubt {
  bool tie = false;
  double tolerance = 0;
};

/// In order of range, at most gpu::kMaxEchoes.
std::vector<BeamEcho> echoesOf(const View& view, const Beam& beam, const BeamEffects& effects,
                               const gpu::EffectParameters& parameters, size_t index, BeamDoubt& doubt);

}  // namespace gnosphere::reference
