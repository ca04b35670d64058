// SPDX-License-Identifier: Apache-2.0
// A Machine that runs nothing and holds no memory of a device: it tells what a sensor's arrays and steps would be.
#pragma once

#include <memory>

#include "pipeline/host_memory.hpp"
#include "pipeline/machine.hpp"

namespace gnosphere {

class DryMachine final : public Machine {
 public:
  explicit DryMachine(const Machine& machine) : machine_(machine) {}
  const Traits& traits() const override { return machine_.traits(); }
  std::unique_ptr<DeviceMemory> allocate(const char* name, uint64_t bytes, MemoryKind) override {
    return std::make_unique<HostMemory>(name, bytes);
  }
  void prepare(std::span<const Variant>) override {}
  size_t framesInFlight() const override { return machine_.framesInFlight(); }
  void submit(size_t, std::span<const Step>, const BoundArrays&) override {}
  void wait(size_t) override {}
  void readTimings(size_t, Timings&) override {}
  bool recordsOnly() const override { return machine_.recordsOnly(); }

 private:
  const Machine& machine_;
};

}  // namespace gnosphere
