// SPDX-License-Identifier: Apache-2.0
// The least work that any program must do for a scan, and the time in which this machine could do it. The model is in
// docs/bench.md.
#pragma once

#include <cstdint>
#include <string>

#include "gnosphere/simulator.hpp"

namespace gnosphere::bench {

/// Rates measured on this machine.
struct Rates {
  double bytesPerMs = 0;       ///< read and written, by copies of arrays larger than any cache
  double operationsPerMs = 0;  ///< additions and multiplications in single precision; 0: not known
  bool known() const { return bytesPerMs > 0; }
};

/// Measures the host's memory and cores if the device is a CPU, else the device's memory. `name` is a value for
/// SimulatorOptions::device.
Rates ratesOf(const DeviceInfo& device, const std::string& name);

struct Floor {
  double bytes = 0, operations = 0;
  double ms = 0;  ///< the longer of the two times, as far as the rates are known; 0 if none is
};

/// `uniqueTriangles` are those of the scene.
Floor floorOf(const Counters& counters, const MemoryUse& memory, uint64_t uniqueTriangles, const Rates& rates);

}  // namespace gnosphere::bench
