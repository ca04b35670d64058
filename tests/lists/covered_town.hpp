// SPDX-License-Identifier: Apache-2.0
// The scene, the place and the options of scans by lists and sectors.
#pragma once

#include "support.hpp"
#include "town/town.hpp"

namespace gnosphere::test {

inline const Pose kPlace = {{1.3, 0.4, 1.8}, {0.01, -0.02, 0.3, 0.95}};

/// A town, with triangles of all sizes above, below and around the sensor, and a ball of triangles of 0.3 mm.
inline Scene coveredTown() {
  Scene scene = makeTown({.triangles = 6'000});
  scene.meshes.push_back(soup(9, 300, 20, 25));
  scene.instances.push_back({"", static_cast<uint32_t>(scene.meshes.size() - 1), {}});
  scene.meshes.push_back(ball(20, 20, 0.002));
  scene.instances.push_back({"", static_cast<uint32_t>(scene.meshes.size() - 1), translation(2, 1, 1.5)});
  return scene;
}

inline TestOptions optionsWith(Accuracy accuracy, Binning binning = Binning::automatic) {
  TestOptions options = vulkanOptions();
  options.accuracy = accuracy;
  options.tuning.binning = binning;
  return options;
}

}  // namespace gnosphere::test
