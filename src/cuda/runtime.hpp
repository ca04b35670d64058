// SPDX-License-Identifier: Apache-2.0
// The functions of the CUDA runtime that the backend uses: devices, memory, timing. Tests replace them on the host.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "cuda/kernels.hpp"
#include "gnosphere/simulator.hpp"

namespace gnosphere::cuda {

using Launch = void (*)(Kernel kernel, const Job& job, uint32_t workgroupsX, uint32_t workgroupsY);

struct Device {
  DeviceInfo info;
  int index = 0;
  /// Number of workgroups that fills the device; most kernels loop over their items, so any number of workgroups will
  /// do.
  uint32_t workgroups = 0;
  bool spreadsRays = false;  ///< Traits::spreadsRays
  Launch launch = nullptr;
};

/// Chooses a device by its UUID or its number; DeviceChoice::Kind selects the `parity` or the `fast` kernels.
Device chooseDevice(const DeviceChoice& choice);
/// Makes the device current for later calls of this thread.
void use(const Device& device);

// All of these throw Error(device) if they fail, or Error(outOfMemory) with the name of the allocation. Copies between
// host and device wait for the kernels.
std::byte* allocate(const char* name, uint64_t bytes);
void release(void* memory);
void copyToDevice(void* to, const void* from, uint64_t bytes);
void copyToHost(void* to, const void* from, uint64_t bytes);
/// Sets every byte to `value`, after the kernels launched before.
void fill(void* memory, uint8_t value, uint64_t bytes);
/// Copies within the device, after the kernels launched before.
void copy(void* to, const void* from, uint64_t bytes);

/// Measures the device times of a scan's stages. On the host it measures nothing.
class Stopwatch {
 public:
  Stopwatch();
  ~Stopwatch();
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

  void start();
  /// Attributes the launches since the last call to the stage.
  void finished(const char* stage);
  /// Waits for the device, then adds the times.
  void read(Timings& timings);

 private:
  std::vector<void*> events_;
  std::vector<const char*> stages_;
};

}  // namespace gnosphere::cuda
