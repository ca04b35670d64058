// SPDX-License-Identifier: Apache-2.0
// What the backend asks of the CUDA runtime: a device, its memory, its time. Tests stand in for it on the host.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "cuda/kernels.hpp"
#include "gnosphere/simulator.hpp"

namespace gnosphere::cuda {

using Launch = void (*)(Kernel kernel, const Job& job, uint32_t groupsX, uint32_t groupsY);

struct Device {
  DeviceInfo info;
  int index = 0;
  /// Workgroups that fill it: most kernels loop over however many items there are.
  uint32_t groups = 0;
  Launch launch = nullptr;
};

/// A device by its UUID or by its number; DeviceChoice::Kind says with which of the kernels of kernels.hpp.
Device chooseDevice(const DeviceChoice& choice);
/// Makes the device that of this thread's calls from here on.
void use(const Device& device);

// Failures throw Error(device), or Error(outOfMemory) with the name. Copies between host and device wait for the
// kernels.
std::byte* allocate(const char* name, uint64_t bytes);
void release(void* memory);
void copyToDevice(void* to, const void* from, uint64_t bytes);
void copyToHost(void* to, const void* from, uint64_t bytes);
/// Every byte becomes `value`, after the kernels launched before.
void fill(void* memory, uint8_t value, uint64_t bytes);
/// Within the device, after the kernels launched before.
void copy(void* to, const void* from, uint64_t bytes);

/// Device times of a scan's stages; none on the host.
class Stopwatch {
 public:
  Stopwatch();
  ~Stopwatch();
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

  void start();
  /// What was launched since the last call belongs to the stage.
  void finished(const char* stage);
  /// Waits for the device.
  void read(Timings& timings);

 private:
  std::vector<void*> events_;
  std::vector<const char*> stages_;
};

}  // namespace gnosphere::cuda
