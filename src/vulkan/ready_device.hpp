// SPDX-License-Identifier: Apache-2.0
// The devices of simulators, which simulators of one thread share.
#pragma once

#include <memory>

#include "gnosphere/simulator.hpp"
#include "vulkan/kernel.hpp"

namespace gnosphere::vulkan {

/// A device and the kernels that are compiled for it. Several simulators may use it at once.
struct ReadyDevice {
  explicit ReadyDevice(const SimulatorOptions& options)
      : device(options.device, options.validation), cache(device, options.cache), kernels(device, cache) {}

  Device device;
  PipelineCache cache;
  Kernels kernels;
};

/// Ends one use of the device. After the last use the device is kept for the next simulator, or destroyed.
struct GiveBack {
  void operator()(ReadyDevice* device) const noexcept;
};
using LentDevice = std::unique_ptr<ReadyDevice, GiveBack>;

/// Returns a device that was made with the same settings, has not failed, and keeps the kernels compiled so far: the
/// device of other simulators that this thread has made, or else a device that no simulator uses any more, or else a
/// new one.
/// Simulators of several threads have devices of their own, because CPU drivers work on one submission to a device at a
/// time. Simulators on a device of the caller share its kernels, whatever their threads, if they are made with copies
/// of one DeviceChoice.
LentDevice lendDevice(const SimulatorOptions& options);

/// Destroys the devices that no simulator uses, so that the next one begins as in a new process.
void destroyIdleDevices() noexcept;

}  // namespace gnosphere::vulkan
