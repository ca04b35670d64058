// SPDX-License-Identifier: Apache-2.0
#include "vulkan/compiling_machine.hpp"

#include <stdexcept>

#include "pipeline/host_memory.hpp"
#include "vulkan/kernel.hpp"

namespace gnosphere::vulkan {
namespace {

class CompilingMachine final : public Machine {
 public:
  explicit CompilingMachine(const SimulatorOptions& options)
      : device_(options.device, options.validation, true), cache_(device_, "off"), kernels_(device_, cache_) {
    traits_ = traitsOf(device_.capabilities(), options.tuning);
    // A driver that only compiles may have no memory at all.
    if (traits_.info.maxBufferBytes == 0) traits_.info.maxBufferBytes = uint64_t{4} << 30;
  }

  const Traits& traits() const override { return traits_; }
  std::unique_ptr<DeviceMemory> allocate(const char* name, uint64_t bytes, MemoryKind) override {
    return std::make_unique<HostMemory>(name, bytes);
  }
  void prepare(std::span<const Variant> variants) override { kernels_.prepare(variants); }
  void describe(const Variant& variant, Plan::Pipeline& pipeline) const override {
    kernels_.describe(variant, pipeline);
  }
  size_t slots() const override { return 1; }
  void submit(size_t, std::span<const Step>, const BoundArrays&) override {
    throw std::logic_error("a simulator that only compiles was asked to scan");
  }
  void wait(size_t) override {}
  void readTimings(size_t, Timings&) override {}
  void throwOnMessages() override { device_.throwOnMessages(); }

 private:
  Device device_;
  PipelineCache cache_;
  Kernels kernels_;
  Traits traits_;
};

}  // namespace

std::unique_ptr<Machine> makeCompilingMachine(const SimulatorOptions& options) {
  return std::make_unique<CompilingMachine>(options);
}

}  // namespace gnosphere::vulkan
