// SPDX-License-Identifier: Apache-2.0
// A beam of a sensor, its sub-rays and the echoes they make, in double.
#pragma once

#include "reference/receiver.hpp"

namespace gnosphere::reference {

/// One line of a footprint: tangents of its angles to the beam's axis, to the left and up.
struct FootprintRay {
  double left = 0, up = 0;
  double weight = 1;  ///< share of the beam's energy
};

/// What the request means for one sensor.
struct BeamEffects {
  SensorPlan plan;
  std::vector<Optics> optics;  ///< per material
  std::vector<FootprintRay> footprint;
};

BeamEffects beamEffects(const SensorPlan& plan, const Scene& scene, const MaterialTable& materials);

struct Beam {
  Line axis;
  Vec3 origin;    ///< of the laser, in the sensor's frame
  Vec3 left, up;  ///< across the axis, in that frame
  Pose pose;      ///< of the sensor as the beam is fired
};

Beam beamOf(const Sensor& sensor, const Shot& shot, bool sensorMoves, size_t index);

/// What single precision may see otherwise.
struct BeamDoubt {
  bool tie = false;
  double tolerance = 0;
};

/// In order of range, at most six.
std::vector<Echo> echoesOf(const View& view, const Beam& beam, const BeamEffects& effects, const Receiver& receiver,
                           size_t index, BeamDoubt& doubt);

}  // namespace gnosphere::reference
