// SPDX-License-Identifier: Apache-2.0
// A place in the towns that tests of effects scan.
#pragma once

#include "gnosphere/gnosphere.hpp"
#include "town/town.hpp"

namespace gnosphere::test {

inline const Pose kPose = {{1.3, 0.4, 1.8}, {0.01, -0.02, 0.3, 0.95}};

inline const Scene& smallTown() {
  static const Scene scene = makeTown({.triangles = 20'000});
  return scene;
}

/// A shot from there of a sensor that stands still.
inline Shot standing(uint64_t frame = 0, size_t sensor = 0) {
  Shot shot;
  shot.pose = kPose;
  shot.frame = frame;
  shot.sensor = sensor;
  return shot;
}

}  // namespace gnosphere::test
