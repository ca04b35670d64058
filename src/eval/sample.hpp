// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "gnosphere/scan.hpp"
#include "gnosphere/sensor.hpp"

namespace gnosphere {

/// Some beams of a sensor, so that the reference traces only these.
struct BeamSample {
  /// The whole sensor, of which only the sampled beams fire: they keep their numbers, and so their random draws.
  Sensor sensor;
  /// The beams' numbers in ascending order; empty: the sample is the whole sensor.
  std::vector<size_t> beams;

  size_t size() const { return beams.empty() ? sensor.beamCount() : beams.size(); }
  /// Selects the sampled beams from a scan of the whole sensor, with the reference's ties and tolerances.
  Scan of(Scan scan) const;
};

/// Samples `count` beams, one at a random place in each of `count` equal runs of beams. Takes all beams if `count` is 0
/// or not less than their number.
BeamSample sampleOf(const Sensor& sensor, uint64_t count, uint32_t seed);

}  // namespace gnosphere
