// SPDX-License-Identifier: Apache-2.0
// CUDA's runtime functions, implemented on the host for tests without a CUDA device, except those that choose a device
// and allocate. One source of a library includes it.
#pragma once

#include <cstring>

#include "cuda/runtime.hpp"

namespace gnosphere::cuda {

inline Device hostDevice(const char* name) {
  Device device;
  device.info.name = name;
  device.info.maxBufferBytes = uint64_t{1} << 32;
  device.info.usable = true;
  return device;
}

void use(const Device&) {}

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
