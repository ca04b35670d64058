// SPDX-License-Identifier: Apache-2.0
// CUDA's runtime functions, implemented on the host for tests without a CUDA device.
#include "cuda/runtime.hpp"

#include <cstring>
#include <new>

namespace gnosphere::cuda {

Device chooseDevice(const DeviceChoice&) {
  Device device;
  device.info.name = "CUDA's kernels on the host";
  device.info.maxBufferBytes = uint64_t{1} << 32;
  device.info.usable = true;
  device.workgroups = 7;
  device.launch = parity::launch;
  return device;
}

void use(const Device&) {}

std::byte* allocate(const char*, uint64_t bytes) {
  return static_cast<std::byte*>(::operator new(bytes));
}

void release(void* memory) {
  ::operator delete(memory);
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
