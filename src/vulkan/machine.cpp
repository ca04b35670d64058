// SPDX-License-Identifier: Apache-2.0
// The Machine for Vulkan: memory, and scans recorded from lists of steps.
#include <algorithm>
#include <cstring>
#include <deque>
#include <string>

#include "base/clock.hpp"
#include "pipeline/backend.hpp"
#include "pipeline/device_backend.hpp"
#include "vulkan/commands.hpp"
#include "vulkan/compiling_machine.hpp"
#include "vulkan/memory.hpp"
#include "vulkan/ready_device.hpp"
#include "vulkan/result_ring.hpp"

namespace gnosphere {
namespace vulkan {
namespace {

// Number of scans submitted at a time: the device works on one while the host receives the one before.
constexpr size_t kSlots = 2;

// Records the steps of scans.
class StepRecorder {
 public:
  StepRecorder(Kernels& kernels, CommandBuffer& commands, VkDeviceAddress addresses, const BoundArrays& arrays,
               std::span<const Step> steps)
      : kernels_(kernels), commands_(commands), addresses_(addresses), arrays_(arrays), steps_(steps) {}

  /// Calls done(step) for the steps that are timestamps or cuts, and after every other step. Returns how long kernels
  /// were compiled.
  template <typename Done>
  Clock::duration record(const Done& done) {
    const char* stage = nullptr;  // whose label is open
    const auto label = [&](const char* next) {
      if (stage == next) return;
      if (stage) commands_.endLabel();
      if (next) commands_.beginLabel(next);
      stage = next;
    };
    for (size_t i = 0; i < steps_.size(); ++i) {
      if (steps_[i].kind == Step::Kind::dispatch) label(steps_[i].stage);
      if (steps_[i].kind == Step::Kind::cut) label(nullptr);
      record(steps_[i]);
      if (needsBarrier(steps_, i)) commands_.barrier();
      done(steps_[i]);
    }
    label(nullptr);
    for (const DeviceMemory* memory : arrays_)
      if (const auto* own = dynamic_cast<const VulkanMemory*>(memory); own && own->copy().handle())
        commands_.copy(own->buffer(), own->copy());
    commands_.barrier();
    return compiling_;
  }

 private:
  const Buffer& bufferOf(gpu::Array array) const {
    return static_cast<const VulkanMemory*>(arrays_[static_cast<size_t>(array)])->buffer();
  }

  // Compiles all kernels of the steps together, on all threads of the host.
  KernelHandle kernelOf(const Variant& variant) {
    if (const KernelHandle kernel = kernels_.of(variant)) return kernel;
    const Clock::time_point start = Clock::now();
    std::vector<Variant> variants;
    for (const Step& step : steps_)
      if (step.kind == Step::Kind::dispatch) variants.push_back(step.variant);
    kernels_.prepare(variants);
    compiling_ += Clock::now() - start;
    return kernels_.of(variant);
  }

  void record(const Step& step) {
    switch (step.kind) {
      case Step::Kind::fill:
        return commands_.fill(bufferOf(step.array), step.first, step.bytes > 0 ? step.bytes : VK_WHOLE_SIZE,
                              step.value);
      case Step::Kind::copy: return commands_.copy(bufferOf(step.from), bufferOf(step.array));
      case Step::Kind::dispatch:
        if (step.arguments)
          return commands_.dispatchIndirect(kernelOf(step.variant), kernels_.layout(), {addresses_, step.pass},
                                            bufferOf(gpu::Array::shells), *step.arguments);
        return commands_.dispatch(kernelOf(step.variant), kernels_.layout(), {addresses_, step.pass}, step.workgroupsX,
                                  step.workgroupsY);
      case Step::Kind::start:
      case Step::Kind::finish:
      case Step::Kind::cut: return;
    }
  }

  Kernels& kernels_;
  CommandBuffer& commands_;
  VkDeviceAddress addresses_;
  const BoundArrays& arrays_;
  std::span<const Step> steps_;
  Clock::duration compiling_ = {};
};

bool isStamp(const Step& step) {
  return step.kind == Step::Kind::start || step.kind == Step::Kind::finish;
}

// Describes a step for SimulatorOptions::trace.
std::string textOf(const Step& step) {
  if (step.kind == Step::Kind::cut) return "the next submission";
  const std::string array = gpu::nameOf(step.array);
  if (step.kind == Step::Kind::fill)
    return "fill " + array + (step.bytes > 0 ? ", " + std::to_string(step.bytes) + " bytes" : "");
  if (step.kind == Step::Kind::copy) return "copy " + std::string(gpu::nameOf(step.from)) + " to " + array;
  std::string text = std::string(step.stage) + ": " + nameOf(step.variant.kernel);
  if (step.variant.options.PASS > 0) text += ", pass " + std::to_string(step.variant.options.PASS);
  if (step.arguments) text += ", shell " + std::to_string(step.pass.shell);
  return text + (step.arguments ? ", at most " : ", ") + std::to_string(step.workgroupsX) +
         (step.workgroupsY > 1 ? " x " + std::to_string(step.workgroupsY) : "") + " workgroups";
}

void writeAddresses(const BoundArrays& arrays, void* to) {
  const gpu::Addresses addresses = addressesOf(arrays);
  std::memcpy(to, &addresses, sizeof addresses);
}

class VulkanMachine final : public Machine {
 public:
  explicit VulkanMachine(const SimulatorOptions& options)
      : lent_(lendDevice(options)),
        warn_(options.warn),
        trace_(options.trace),
        traits_(traitsOf(device_.capabilities(), options.tuning)),
        timesStages_(!traits_.cpu || options.tuning.stageTimes || trace_),
        recordsOnly_(device_.adopted() || options.resultsOnDevice) {}

  const Traits& traits() const override { return traits_; }
  std::unique_ptr<DeviceMemory> allocate(const char* name, uint64_t bytes, MemoryKind kind) override {
    refuseLarger(device_, name, bytes, traits_.info.maxBufferBytes);
    if (recordsOnly()) return std::make_unique<RecordedMemory>(device_, recordings_, name, bytes, kind);
    return std::make_unique<OwnMemory>(device_, transfer_, name, bytes, kind);
  }
  // Drivers of CPUs compile a kernel when it first runs, so a pipeline that is made earlier spares no scan a wait.
  void prepare(std::span<const Variant> variants) override {
    if (!traits_.cpu) kernels_.prepare(variants);
  }
  void prepared() override { lent_->cache.save(warn_); }
  Clock::duration compiling() const override { return compiling_; }
  size_t slots() const override { return kSlots; }
  void wait(size_t slot) override {
    if (slot < slots_.size()) slots_[slot].commands.wait();
  }
  void readTimings(size_t slot, Timings& timings) override {
    slots_[slot].commands.readTimings(timings);
    if (trace_) slots_[slot].commands.readTrace(trace_);
  }
  void timeWork(bool on) override { timesWork_ = on; }
  double workMs(size_t slot) override { return timesWork_ ? slots_[slot].commands.workMs() : 0; }
  void throwOnMessages() override { device_.throwOnMessages(); }

  void submit(size_t index, std::span<const Step> steps, const BoundArrays& arrays) override {
    while (slots_.size() <= index) slots_.emplace_back(device_);
    Slot& slot = slots_[index];
    writeAddresses(arrays, slot.addresses.mapped());
    slot.addresses.flush();
    Commands& commands = slot.commands;
    const auto stamps = std::ranges::count_if(steps, isStamp);
    std::ptrdiff_t stamped = 0;
    commands.begin(static_cast<uint32_t>(trace_ ? steps.size() : stamps));
    StepRecorder recorder(kernels_, commands.buffer(), slot.addresses.address(), arrays, steps);
    noteCompiling(recorder.record([&](const Step& step) {
      if (isStamp(step) && !timesStages_) {
        ++stamped;
        if (timesWork_ && (stamped == 1 || stamped == stamps)) commands.start();
        return;
      }
      if (step.kind == Step::Kind::start) return commands.start();
      if (step.kind == Step::Kind::finish) return commands.finished(step.stage);
      if (step.kind == Step::Kind::cut) commands.cut();
      if (trace_) commands.traced(textOf(step));
    }));
    commands.submit();
  }

  bool recordsOnly() const override { return recordsOnly_; }
  bool submits() const override { return !device_.adopted(); }

  void beginRecording(void* commands, ResultRing* ring, size_t frame) override {
    streamed_ = ring ? &static_cast<VulkanRing*>(ring)->commands(frame) : nullptr;
    recorded_ = streamed_ ? streamed_->buffer() : CommandBuffer(device_, static_cast<VkCommandBuffer>(commands));
    recordings_.begin(recorded_, frame);
  }

  void record(DeviceMemory& addresses, std::span<const Step> steps, const BoundArrays& arrays) override {
    writeAddresses(arrays, addresses.host());
    addresses.flush();
    StepRecorder recorder(kernels_, recorded_, addresses.address(), arrays, steps);
    noteCompiling(recorder.record([&](const Step& step) {
      if (step.kind != Step::Kind::cut) return;
      streamed_->cut();
      recorded_ = streamed_->buffer();
    }));
  }

  void endRecording() override { recorded_.fullBarrier(); }

  void abandonRecording(size_t frame) noexcept override { recordings_.abandon(frame); }

  std::unique_ptr<ResultRing> makeRing(size_t buffers, uint64_t bytes, uint64_t hostBytes) override {
    refuseLarger(device_, kResultsName, bytes, traits_.info.maxBufferBytes);
    return std::make_unique<VulkanRing>(device_, buffers, bytes, hostBytes);
  }

 private:
  void noteCompiling(Clock::duration time) {
    if (time > Clock::duration::zero()) prepared();
    compiling_ += time;
  }

  struct Slot {
    explicit Slot(const Device& device)
        : addresses(device, "addresses", sizeof(gpu::Addresses), MemoryKind::upload), commands(device) {}
    Buffer addresses;
    Commands commands;  // last member, destroyed first: its destructor waits for the device
  };

  LentDevice lent_;
  Device& device_ = lent_->device;
  Kernels& kernels_ = lent_->kernels;
  std::function<void(const std::string&)> warn_, trace_;
  Traits traits_;
  bool timesStages_, recordsOnly_;
  bool timesWork_ = false;
  Clock::duration compiling_ = {};
  Transfer transfer_{device_, traits_.info.maxBufferBytes};
  Recordings recordings_{device_, traits_.info.maxBufferBytes};
  std::deque<Slot> slots_;
  // While a recording is under way: the command buffer, and the commands of a ring; null if the buffer is the caller's.
  CommandBuffer recorded_;
  Commands* streamed_ = nullptr;
};

}  // namespace
}  // namespace vulkan

std::unique_ptr<Backend> makeVulkanBackend(const Scene& scene, const SensorPlans& sensors,
                                           const SimulatorOptions& options) {
  if (options.compileOnly) return makeDeviceBackend(vulkan::makeCompilingMachine(options), scene, sensors, options);
  return makeDeviceBackend(std::make_unique<vulkan::VulkanMachine>(options), scene, sensors, options);
}

}  // namespace gnosphere
