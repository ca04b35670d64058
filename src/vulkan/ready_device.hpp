// SPDX-License-Identifier: Apache-2.0
// Devices of our own, which simulators use one after the other.
#pragma once

#include <memory>

#include "gnosphere/simulator.hpp"
#include "vulkan/kernel.hpp"

namespace gnosphere::vulkan {

/// A device and the kernels that are compiled for it. One simulator uses it at a time.
struct ReadyDevice {
  explicit ReadyDevice(const SimulatorOptions& options)
      : device(options.device, options.validation, options.tuning.maxBufferBytes),
        cache(device, options.cache),
        kernels(device, cache) {}

  Device device;
  PipelineCache cache;
  Kernels kernels;
  bool failed = false;  ///< true if a scan has failed on it, so no other simulator may have it
};

/// Keeps the device for the next simulator, or destroys it.
struct GiveBack {
  void operator()(ReadyDevice* device) const noexcept;
};
using LentDevice = std::unique_ptr<ReadyDevice, GiveBack>;

/// Returns a device that a simulator with the same choice has given back in this process, with all kernels compiled so
/// far, or a new one.
LentDevice lendDevice(const SimulatorOptions& options);

/// Destroys the devices that no simulator uses, so that the next one begins as in a new process.
void destroyIdleDevices() noexcept;

}  // namespace gnosphere::vulkan
