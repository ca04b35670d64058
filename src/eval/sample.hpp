// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "gnosphere/scan.hpp"
#include "gnosphere/sensor.hpp"

namespace gnosphere {

/// Some beams of a sensor, as a sensor of their own: the reference answers for these alone.
struct BeamSample {
  Sensor sensor;
  std::vector<size_t> beams;  ///< of the whole sensor, in the order of the sample's; empty: it is the whole sensor
  Scan of(Scan scan) const;   ///< what a scan of the whole sensor says of them
};

/// About `count` beams, one at a random place in each of as many equal runs of beams; all of them if 0 or so few.
BeamSample sampleOf(const Sensor& sensor, uint64_t count, uint32_t seed);

}  // namespace gnosphere
