// SPDX-License-Identifier: Apache-2.0
// Sensor -> the tables that the stages read, made in double on the host.
#pragma once

#include <vector>

#include "gnosphere/sensor.hpp"
#include "shared.h"

namespace gnosphere {

struct BeamTables {
  std::vector<gpu::Row> rows;  ///< one per channel, in order of elevation
  std::vector<uint32_t>
      rowLookup;               ///< per cell of elevation keys: first row that may lie in or above it, first above it
  std::vector<float> columns;  ///< cos, sin of each column's azimuth
  gpu::Frame frame = {};       ///< capacities and instance count are the backend's to fill
  bool azimuthOffsets = false;
};

/// Throws Error(invalidArgument) for more than 65,535 channels: a box packs its rows into 16 bits.
BeamTables makeBeamTables(const Sensor& sensor);

}  // namespace gnosphere
