// SPDX-License-Identifier: Apache-2.0
// The lanes as a device of the caller: what is recorded runs at once.
#pragma once

#include <cstring>

#include "lanes/accesses.hpp"
#include "pipeline/device_backend.hpp"
#include "pipeline/recording.hpp"

namespace gnosphere::cuda_lanes {
std::unique_ptr<Machine> makeMachine(const SimulatorOptions& options);
}

namespace gnosphere::test {

class RecordingMachine : public Machine {
 public:
  explicit RecordingMachine(const SimulatorOptions& options) : lanes_(cuda_lanes::makeMachine(options)) {}

  const Traits& traits() const override { return lanes_->traits(); }
  std::unique_ptr<DeviceMemory> allocate(const char* name, uint64_t bytes, MemoryKind kind) override {
    return lanes_->allocate(name, bytes, kind);
  }
  void prepare(std::span<const Variant> variants) override { lanes_->prepare(variants); }
  size_t slots() const override { return 1; }
  void wait(size_t) override {}
  void readTimings(size_t, Timings&) override {}
  void submit(size_t, std::span<const Step>, const BoundArrays&) override {}
  bool recordsOnly() const override { return true; }
  void record(DeviceMemory&, std::span<const Step> steps, const BoundArrays& arrays) override {
    lanes_->submit(0, steps, arrays);
  }

 private:
  std::unique_ptr<Machine> lanes_;
};

/// Watched memory of the caller.
class CallerBuffer {
 public:
  CallerBuffer(const char* name, uint64_t bytes) : bytes_(bytes), data_(lanes::allocate(name, bytes)) {
    std::memset(data_, 0, bytes);
  }
  template <typename T>
  CallerBuffer(const char* name, const std::vector<T>& content) : CallerBuffer(name, content.size() * sizeof(T)) {
    std::memcpy(data_, content.data(), bytes_);
  }
  CallerBuffer(const CallerBuffer&) = delete;
  CallerBuffer& operator=(const CallerBuffer&) = delete;
  ~CallerBuffer() { lanes::release(data_); }

  uint64_t address() const { return reinterpret_cast<uint64_t>(data_); }
  Recording::Range range() const { return {address(), bytes_}; }
  std::span<const std::byte> bytes() const { return {data_, bytes_}; }
  std::byte* data() const { return data_; }

 private:
  uint64_t bytes_;
  std::byte* data_;
};

}  // namespace gnosphere::test
