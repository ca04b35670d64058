// SPDX-License-Identifier: Apache-2.0
// A Machine that runs nothing and holds no memory of a device: it tells what a sensor's arrays and steps would be on
// another machine.
#pragma once

#include <memory>

#include "pipeline/host_memory.hpp"
#include "pipeline/machine.hpp"

namespace gnosphere {

class DryMachine final : public Machine {
 public:
  /// With `compiles` the other machine compiles the kernels, for what their compiler says of them.
  DryMachine(Machine& machine, bool compiles) : machine_(machine), compiles_(compiles) {}
  const Traits& traits() const override { return machine_.traits(); }
  std::unique_ptr<DeviceMemory> allocate(const char* name, uint64_t bytes, MemoryKind) override {
    return std::make_unique<HostMemory>(name, bytes);
  }
  void prepare(std::span<const Variant> variants) override {
    if (compiles_) machine_.prepare(variants);
  }
  void describe(const Variant& variant, Plan::Pipeline& pipeline) const override {
    machine_.describe(variant, pipeline);
  }
  size_t slots() const override { return machine_.slots(); }
  void submit(size_t, std::span<const Step>, const BoundArrays&) override {}
  void wait(size_t) override {}
  void readTimings(size_t, Timings&) override {}
  bool recordsOnly() const override { return machine_.recordsOnly(); }
  bool submits() const override { return machine_.submits(); }

 private:
  Machine& machine_;
  bool compiles_;
};

}  // namespace gnosphere
