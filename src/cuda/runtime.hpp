// SPDX-License-Identifier: Apache-2.0
// What the backend asks of the CUDA runtime: a device, its memory, its time. Tests stand in for it on the host.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
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

/// The device that "cuda:N" names, or "cuda-fast:N" with the kernels of the other namespace of kernels.hpp.
Device chooseDevice(const std::string& name);
/// Makes the device that of this thread's calls from here on.
void use(const Device& device);

// Failures throw Error(device), or Error(outOfMemory) with the name. Copies between host and device wait for the
// kernels.
void* allocate(const char* name, uint64_t bytes);
void release(void* memory);
void copyToDevice(void* to, const void* from, uint64_t bytes);
void copyToHost(void* to, const void* from, uint64_t bytes);
/// Every byte becomes `value`, after the kernels launched before.
void fill(void* memory, uint8_t value, uint64_t bytes);

/// Device memory.
class Array {
 public:
  Array() = default;
  /// `name` must outlive it; it is for plans and messages: "cannot allocate 96.0 MiB for 'points'".
  Array(const char* name, uint64_t bytes)
      : name_(name), data_(bytes > 0 ? allocate(name, bytes) : nullptr), bytes_(bytes) {}
  template <typename T>
  Array(const char* name, const std::vector<T>& values) : Array(name, values.size() * sizeof(T)) {
    write<T>(values);
  }
  ~Array() {
    if (data_) release(data_);
  }
  Array(Array&& other) noexcept { swap(other); }
  Array& operator=(Array&& other) noexcept {
    swap(other);
    return *this;
  }

  const char* name() const { return name_; }
  void* data() const { return data_; }
  uint64_t bytes() const { return bytes_; }
  /// From the `first`-th element on.
  template <typename T>
  void write(std::span<const T> values, size_t first = 0) {
    copyToDevice(static_cast<T*>(data_) + first, values.data(), values.size_bytes());
  }
  template <typename T>
  std::vector<T> read(size_t first, size_t count) const {
    std::vector<T> values(count);
    copyToHost(values.data(), static_cast<const T*>(data_) + first, count * sizeof(T));
    return values;
  }

 private:
  void swap(Array& other) noexcept {
    std::swap(name_, other.name_);
    std::swap(data_, other.data_);
    std::swap(bytes_, other.bytes_);
  }

  const char* name_ = "";
  void* data_ = nullptr;
  uint64_t bytes_ = 0;
};

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
