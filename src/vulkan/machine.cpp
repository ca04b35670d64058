// SPDX-License-Identifier: Apache-2.0
// The Machine for Vulkan: memory, and scans recorded from lists of steps.
#include <cstring>
#include <deque>

#include "pipeline/backend.hpp"
#include "pipeline/device_backend.hpp"
#include "vulkan/commands.hpp"

namespace gnosphere {
namespace vulkan {
namespace {

// Number of scans submitted at a time: the device works on one while the host receives the one before.
constexpr size_t kFramesInFlight = 2;
// Largest number of timestamps of a scan: the start, two for each shell and for moving instances, resolve, effects.
constexpr uint32_t kStamps = 3 + 2 * (gpu::kMostShells + 1);

class VulkanMemory final : public DeviceMemory {
 public:
  VulkanMemory(const Device& device, Transfer& transfer, const char* name, uint64_t bytes, MemoryKind kind)
      : transfer_(transfer) {
    const bool copied = kind == MemoryKind::readback && !device.unifiedMemory();
    buffer_ = Buffer(device, name, bytes, copied ? MemoryKind::device : kind);
    if (copied) copy_ = Buffer(device, name, bytes, kind);
  }

  uint64_t bytes() const override { return buffer_.bytes(); }
  uint64_t address() const override { return buffer_.address(); }
  void* host() override { return onHost().mapped(); }
  void flush() override { buffer_.flush(); }
  void invalidate() override { onHost().invalidate(); }
  void write(uint64_t place, std::span<const std::byte> data) override { transfer_.write(buffer_, place, data); }
  void read(uint64_t place, std::span<std::byte> data) const override { transfer_.read(buffer_, place, data); }

  const Buffer& buffer() const { return buffer_; }
  /// The buffer to which a scan copies its results for the host; without a handle if the host reads the buffer itself.
  const Buffer& copy() const { return copy_; }

 private:
  const Buffer& onHost() const { return copy_.handle() ? copy_ : buffer_; }

  Transfer& transfer_;
  Buffer buffer_, copy_;
};

class VulkanMachine final : public Machine {
 public:
  explicit VulkanMachine(const SimulatorOptions& options)
      : device_(options.device, options.validation, options.tuning.maxBufferBytes),
        cache_(device_, options.cache),
        warn_(options.warn),
        kernels_(device_, cache_),
        transfer_(device_) {
    const Capabilities& capabilities = device_.capabilities();
    traits_ = {capabilities.info, capabilities.cpu, capabilities.int64Atomics, capabilities.float64};
  }

  const Traits& traits() const override { return traits_; }
  std::unique_ptr<DeviceMemory> allocate(const char* name, uint64_t bytes, MemoryKind kind) override {
    return std::make_unique<VulkanMemory>(device_, transfer_, name, bytes, kind);
  }
  void prepare(const Variant& variant) override { kernels_.of(variant); }
  void prepared() override { cache_.save(warn_); }
  size_t framesInFlight() const override { return kFramesInFlight; }
  void wait(size_t frame) override {
    if (frame < frames_.size()) frames_[frame].commands.wait();
  }
  void readTimings(size_t frame, Timings& timings) override { frames_[frame].commands.readTimings(timings); }
  void throwOnMessages() override { device_.throwOnMessages(); }

  void submit(size_t index, std::span<const Step> steps, const BoundArrays& arrays) override {
    while (frames_.size() <= index) frames_.emplace_back(device_);
    Frame& frame = frames_[index];
    gpu::Addresses addresses = {};
    for (size_t i = 0; i < arrays.size(); ++i)
      if (arrays[i]) reinterpret_cast<uint64_t*>(&addresses)[i] = arrays[i]->address();
    std::memcpy(frame.addresses.mapped(), &addresses, sizeof addresses);
    frame.addresses.flush();
    frame.commands.begin();
    for (size_t i = 0; i < steps.size(); ++i) {
      record(frame, steps[i], arrays);
      // Consecutive fills write different bytes, so no barrier is needed between them.
      const bool alike =
          i + 1 < steps.size() && steps[i].kind == Step::Kind::fill && steps[i + 1].kind == steps[i].kind;
      if (!alike && steps[i].kind != Step::Kind::start && steps[i].kind != Step::Kind::finish) frame.commands.barrier();
    }
    for (const DeviceMemory* memory : arrays)
      if (const auto* own = static_cast<const VulkanMemory*>(memory); own && own->copy().handle())
        frame.commands.copy(own->buffer(), own->copy());
    frame.commands.barrier();
    frame.commands.submit();
  }

 private:
  struct Frame {
    explicit Frame(const Device& device)
        : addresses(device, "addresses", sizeof(gpu::Addresses), MemoryKind::upload), commands(device, kStamps) {}
    Buffer addresses;
    Commands commands;  // last member, destroyed first: its destructor waits for the device
  };

  void record(Frame& frame, const Step& step, const BoundArrays& arrays) {
    const auto bufferOf = [&](gpu::Array array) -> const Buffer& {
      return static_cast<const VulkanMemory*>(arrays[static_cast<size_t>(array)])->buffer();
    };
    Commands& commands = frame.commands;
    switch (step.kind) {
      case Step::Kind::fill:
        return commands.fill(bufferOf(step.array), step.first, step.bytes > 0 ? step.bytes : VK_WHOLE_SIZE, step.value);
      case Step::Kind::copy: return commands.copy(bufferOf(step.from), bufferOf(step.array));
      case Step::Kind::start: return commands.start();
      case Step::Kind::finish: return commands.finished(step.stage);
      case Step::Kind::dispatch:
        if (step.arguments)
          return commands.dispatchIndirect(kernels_.of(step.variant), kernels_.layout(),
                                           {frame.addresses.address(), step.pass}, bufferOf(gpu::Array::shells),
                                           *step.arguments);
        return commands.dispatch(kernels_.of(step.variant), kernels_.layout(), {frame.addresses.address(), step.pass},
                                 step.groupsX, step.groupsY);
    }
  }

  Device device_;
  PipelineCache cache_;
  std::function<void(const std::string&)> warn_;
  Kernels kernels_;
  Transfer transfer_;
  Traits traits_;
  std::deque<Frame> frames_;
};

}  // namespace
}  // namespace vulkan

std::unique_ptr<Backend> makeVulkanBackend(const Scene& scene, const SensorPlans& sensors,
                                           const SimulatorOptions& options) {
  return makeDeviceBackend(std::make_unique<vulkan::VulkanMachine>(options), scene, sensors, options);
}

}  // namespace gnosphere
