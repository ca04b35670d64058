// SPDX-License-Identifier: Apache-2.0
// A Machine that runs nothing and holds no memory of a device: it tells what a sensor's arrays and steps would be.
#pragma once

#include <vector>

#include "pipeline/machine.hpp"

namespace gnosphere {

class DryMemory final : public DeviceMemory {
 public:
  DryMemory(uint64_t bytes, MemoryKind kind) : bytes_(bytes), host_(kind == MemoryKind::device ? 0 : bytes) {}
  uint64_t bytes() const override { return bytes_; }
  uint64_t address() const override { return 0; }
  void* host() override { return host_.data(); }
  void flush() override {}
  void invalidate() override {}
  void write(uint64_t, std::span<const std::byte>) override {}
  void read(uint64_t, std::span<std::byte>) const override {}

 private:
  uint64_t bytes_;
  std::vector<std::byte> host_;
};

class DryMachine final : public Machine {
 public:
  explicit DryMachine(const Machine& machine) : machine_(machine) {}
  const Traits& traits() const override { return machine_.traits(); }
  std::unique_ptr<DeviceMemory> allocate(const char*, uint64_t bytes, MemoryKind kind) override {
    return std::make_unique<DryMemory>(bytes, kind);
  }
  void prepare(const Variant&) override {}
  size_t framesInFlight() const override { return machine_.framesInFlight(); }
  void submit(size_t, std::span<const Step>, const BoundArrays&) override {}
  void wait(size_t) override {}
  void readTimings(size_t, Timings&) override {}
  bool recordsOnly() const override { return machine_.recordsOnly(); }

 private:
  const Machine& machine_;
};

}  // namespace gnosphere
