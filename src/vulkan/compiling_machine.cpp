// SPDX-License-Identifier: Apache-2.0
#include "vulkan/compiling_machine.hpp"

#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include "gnosphere/error.hpp"
#include "vulkan/kernel.hpp"

namespace gnosphere::vulkan {
namespace {

// Zeros that take no room until somebody writes to them.
class HostMemory final : public DeviceMemory {
 public:
  HostMemory(const char* name, uint64_t bytes)
      : bytes_(bytes), memory_(static_cast<std::byte*>(std::calloc(1, bytes > 0 ? bytes : 1)), std::free) {
    if (!memory_)
      throw Error(ErrorCode::outOfMemory, "the host has no " + std::to_string(bytes) + " bytes for '" + name + "'");
  }

  uint64_t bytes() const override { return bytes_; }
  uint64_t address() const override { return 0; }
  void* host() override { return memory_.get(); }
  void flush() override {}
  void invalidate() override {}
  void write(uint64_t place, std::span<const std::byte> data) override {
    if (!data.empty()) std::memcpy(memory_.get() + place, data.data(), data.size());
  }
  void read(uint64_t place, std::span<std::byte> data) const override {
    if (!data.empty()) std::memcpy(data.data(), memory_.get() + place, data.size());
  }

 private:
  uint64_t bytes_;
  std::unique_ptr<std::byte, decltype(&std::free)> memory_;
};

class CompilingMachine final : public Machine {
 public:
  explicit CompilingMachine(const SimulatorOptions& options)
      : device_(options.device, options.validation, options.tuning.maxBufferBytes, true),
        cache_(device_, "off"),
        kernels_(device_, cache_) {
    const Capabilities& capabilities = device_.capabilities();
    traits_ = {capabilities.info, capabilities.cpu, capabilities.int64Atomics, capabilities.float64};
    // A driver that only compiles may have no memory at all.
    if (traits_.info.maxBufferBytes == 0) traits_.info.maxBufferBytes = uint64_t{4} << 30;
  }

  const Traits& traits() const override { return traits_; }
  std::unique_ptr<DeviceMemory> allocate(const char* name, uint64_t bytes, MemoryKind) override {
    return std::make_unique<HostMemory>(name, bytes);
  }
  void prepare(const Variant& variant) override { kernels_.of(variant); }
  void describe(const Variant& variant, Plan::Pipeline& pipeline) const override {
    kernels_.describe(variant, pipeline);
  }
  size_t framesInFlight() const override { return 1; }
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
