// SPDX-License-Identifier: Apache-2.0
// A sensor of few beams, which tests change.
#pragma once
#include "gnosphere/sensor.hpp"

namespace gnosphere::test {

/// Returns a sensor of 4 columns, 2 channels and 10 m.
inline Sensor small() {
  Sensor sensor;
  sensor.name = "small";
  sensor.columns = 4;
  sensor.rangeMax = 10;
  sensor.channels = {{-10, 0}, {10, 0}};
  return sensor;
}

}  // namespace gnosphere::test
