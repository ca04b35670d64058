// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gnosphere/gnosphere.hpp>
#include <string>
#include <vector>

namespace viewer {

/// A scene, and what moves in it: the sensor to and fro along the x axis, and some of the instances likewise.
struct World {
  struct Mover {
    size_t instance = 0;
    gnosphere::Transform start;
    double speed = 0;  ///< m/s along the x axis at first
    double way = 0;    ///< metres until it turns back

    gnosphere::Transform at(double time) const;
  };

  gnosphere::Scene scene;
  gnosphere::Vec3 start;  ///< of the sensor
  double speed = 5, way = 25;
  std::vector<Mover> movers;

  gnosphere::Pose sensorAt(double time) const;
};

/// A street with houses, trees, parked cars, and one that moves.
World street();

}  // namespace viewer
