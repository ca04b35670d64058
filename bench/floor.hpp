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
  double operationsPerMs = 0;  ///< additions and multiplications in single precision; 0: not known
  bool known() const { return bytesPerMs > 0; }
};

/// Of the host's memory and cores where the device is a CPU, else of the device's own memory. `name`: as
/// SimulatorOptions::device.
Rates ratesOf(const DeviceInfo& device, const std::string& name);

struct Floor {
  double bytes = 0, operations = 0;
  double ms = 0;  ///< the longer of the two, as far as the rates are known; 0 if they are not
};

/// `uniqueTriangles`: of the scene.
Floor floorOf(const Counters& counters, const MemoryUse& memory, uint64_t uniqueTriangles, const Rates& rates);

}  // namespace gnosphere::bench
