// SPDX-License-Identifier: Apache-2.0
// A beam of a sensor, its sub-rays and their echoes, in double.
#pragma once

#include <array>

#include "reference/receiver.hpp"

namespace gnosphere::reference {

/// One sub-ray: tangents of its angles to the beam's axis, to the left and up.
struct FootprintRay {
  double left = 0, up = 0;
  double weight = 1;  ///< share of the beam's energy
};

/// The requested effects, prepared for one sensor.
struct BeamEffects {
  SensorPlan plan;
  std::vector<Optics> optics;  ///< per material
  std::vector<FootprintRay> footprint;
  std::array<double, 2> cell = {};  ///< tangents of half axes: the part of the footprint that one sub-ray stands for
};

BeamEffects beamEffects(const SensorPlan& plan, const Scene& scene, const MaterialTable& materials);

struct Beam {
  Line axis;
  Vec3 origin;    ///< of the laser, in the sensor's frame
  Vec3 left, up;  ///< unit vectors across the axis, in the sensor's frame
  Pose pose;      ///< of the sensor when the beam is fired
  double least;   ///< metres: the range of a return is at least this
};

Beam beamOf(const Sensor& sensor, const Shot& shot, bool sensorMoves, size_t index);

/// The direction in the sensor's frame in which the light of a beam leaves, and by how much an error of rounding may
/// turn it, in radians.
struct Light {
  double left = 0, up = 0;  ///< tangents of its angles to the beam's axis
  double astray = 0;        ///< bound of the error of these
  Vec3 direction;           ///< unit vector
};
Light lightOf(const Beam& beam, const SensorPlan& plan, const Receiver& receiver, size_t index);

/// How a single-precision simulator may deviate on this beam.
struct BeamDoubt {
  bool tie = false;
  double tolerance = 0;
};

/// Returns at most 6 echoes, or 16 if a beam reports more than 3 returns, in order of range: the nearest, the farthest,
/// and the strongest of those between. Adds to `lost` the number of the others, and one for a beam whose
/// light goes on after four surfaces.
std::vector<Echo> echoesOf(const View& view, const Beam& beam, const Light& light, const BeamEffects& effects,
                           BeamDoubt& doubt, uint64_t& lost);

}  // namespace gnosphere::reference
