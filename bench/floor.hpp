// SPDX-License-Identifier: Apache-2.0
// The least that any program has to do for a scan, and how fast this machine could do that. docs/bench.md has the
// model.
#pragma once

#include <cstdint>
#include <string>

#include "gnosphere/simulator.hpp"

namespace gnosphere::bench {

/// Measured on this machine.
struct Rates {
  double bytesPerMs = 0;       ///< read and written by copies of arrays too large for any cache
  double operationsPerMs = 0;  ///< additions and multiplications in single precision
  bool known() const { return bytesPerMs > 0; }
};

/// Of the host's memory and cores, which are the device's where its type is cpu; unknown for any other type.
Rates ratesOf(const DeviceInfo& device);

struct Floor {
  double bytes = 0, operations = 0;
  double ms = 0;  ///< the longer of the two; 0 if the rates are unknown
};

/// `uniqueTriangles`: of the scene.
Floor floorOf(const Counters& counters, const MemoryUse& memory, uint64_t uniqueTriangles, const Rates& rates);

}  // namespace gnosphere::bench
