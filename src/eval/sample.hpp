// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "gnosphere/scan.hpp"
#include "gnosphere/sensor.hpp"

namespace gnosphere {

/// Some beams of a sensor as a sensor of their own, so that the reference traces only these.
struct BeamSample {
  Sensor sensor;
  /// The beams' numbers in the whole sensor, in the sample's order; empty: the sample is the whole sensor.
  std::vector<size_t> beams;
  /// Selects the sampled beams from a scan of the whole sensor.
  Scan of(Scan scan) const;
};

/// Samples about `count` beams, one at a random place in each of `count` equal runs of beams. Takes all beams if
/// `count` is 0 or not less than their number.
BeamSample sampleOf(const Sensor& sensor, uint64_t count, uint32_t seed);

}  // namespace gnosphere
