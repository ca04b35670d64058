// SPDX-License-Identifier: Apache-2.0
// Families of cases of growing difficulty. In each, the beams meet one continuous surface that every beam hits: a beam
// without a hit is therefore an error, and the true range does not depend on which triangle owns a shared edge.
#pragma once

#include <string>
#include <vector>

#include "gnosphere/gnosphere.hpp"

namespace gnosphere::bench {

struct HardCase {
  double hardness = 1;  ///< in the family's `unit`
  Scene scene;
  Sensor sensor;
  Pose pose;
};

struct Family {
  const char* name;   ///< for JSON
  const char* title;  ///< for tables and plots
  const char* unit;
  std::vector<double> hardness;  ///< from easy to hard
  HardCase (*make)(double hardness);
};

const std::vector<Family>& families();

}  // namespace gnosphere::bench
