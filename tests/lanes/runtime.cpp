// SPDX-License-Identifier: Apache-2.0
// CUDA's runtime functions over watched memory on the host.
#include "cuda/runtime.hpp"

#include <cstring>

#include "lanes/accesses.hpp"
#include "lanes/schedule.hpp"

namespace gnosphere::cuda {
namespace {

void launchNamed(Kernel kernel, const Job& job, uint32_t workgroupsX, uint32_t workgroupsY) {
  lanes::setKernel(nameOf(kernel));
  parity::launch(kernel, job, workgroupsX, workgroupsY);
}

}  // namespace

Device chooseDevice(const DeviceChoice&) {
  Device device;
  device.info.name = "lanes on the host";
  device.info.maxBufferBytes = uint64_t{1} << 32;
  device.info.usable = true;
  device.workgroups = 3;
  device.launch = launchNamed;
  return device;
}

void use(const Device&) {}

std::byte* allocate(const char* name, uint64_t bytes) {
  return lanes::allocate(name, bytes);
}
void release(void* memory) {
  lanes::release(memory);
}
void copyToDevice(void* to, const void* from, uint64_t bytes) {
  if (bytes > 0) std::memcpy(to, from, bytes);
}
void copyToHost(void* to, const void* from, uint64_t bytes) {
  if (bytes > 0) std::memcpy(to, from, bytes);
}
void fill(void* memory, uint8_t value, uint64_t bytes) {
  if (bytes > 0) std::memset(memory, value, bytes);
}
void copy(void* to, const void* from, uint64_t bytes) {
  if (bytes > 0) std::memcpy(to, from, bytes);
}

Stopwatch::Stopwatch() = default;
Stopwatch::~Stopwatch() = default;
void Stopwatch::start() {}
void Stopwatch::finished(const char*) {}
void Stopwatch::read(Timings&) {}

}  // namespace gnosphere::cuda
