// SPDX-License-Identifier: Apache-2.0
// Families of cases that grow harder in one thing. In each, the beams meet one continuous surface and every beam hits
// it, so that a beam that is lost is lost, and the true range does not depend on who owns a shared edge.
#pragma once

#include <string>
#include <vector>

#include "gnosphere/gnosphere.hpp"

namespace gnosphere::bench {

struct HardCase {
  double hardness = 1;  ///< what the family's `unit` counts
  Scene scene;
  Sensor sensor;
  Pose pose;
};

struct Family {
  const char* name;   ///< for programs
  const char* title;  ///< for people
  const char* unit;
  std::vector<double> hardness;  ///< from easy to hard
  HardCase (*make)(double hardness);
};

const std::vector<Family>& families();

}  // namespace gnosphere::bench
