// SPDX-License-Identifier: Apache-2.0
// Computes the beam tables that the stages read from a Sensor, in double precision on the host.
#pragma once

#include <vector>

#include "gnosphere/sensor.hpp"
#include "shared.h"

namespace gnosphere {

struct BeamTables {
  std::vector<gpu::Row> rows;  ///< one per channel, in order of elevation
  std::vector<uint32_t>
      rowLookup;  ///< per cell of elevation keys: first row in or above the cell | first row above it << 16
  std::vector<float> columns;   ///< cos, sin of each column's azimuth
  gpu::Frame frame = {};        ///< the backend fills in capacities and the instance count
  bool azimuthOffsets = false;  ///< true if any channel has an azimuth offset
};

/// Throws Error(invalidArgument) for more than 65,535 channels, because a box packs its rows into 16 bits each, and for
/// more than 2^25 columns.
BeamTables makeBeamTables(const Sensor& sensor);

}  // namespace gnosphere
