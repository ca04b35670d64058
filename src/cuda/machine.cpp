// SPDX-License-Identifier: Apache-2.0
// A CUDA device as the pipeline sees it: memory, and scans launched from lists of steps.
#include "pipeline/machine.hpp"

#include <algorithm>

#include "cuda/runtime.hpp"
#include "pipeline/backend.hpp"
#include "pipeline/device_backend.hpp"

namespace gnosphere::cuda {
namespace {

class CudaMemory final : public DeviceMemory {
 public:
  CudaMemory(const char* name, uint64_t bytes, MemoryKind kind)
      : bytes_(bytes),
        host_(kind == MemoryKind::device ? 0 : bytes),
        data_(allocate(name, std::max<uint64_t>(bytes, 1))) {}
  ~CudaMemory() override { release(data_); }

  uint64_t bytes() const override { return bytes_; }
  uint64_t address() const override { return reinterpret_cast<uint64_t>(data_); }
  void* host() override { return host_.data(); }
  void flush() override { copyToDevice(data_, host_.data(), host_.size()); }
  void invalidate() override { copyToHost(host_.data(), data_, host_.size()); }
  void write(uint64_t place, std::span<const std::byte> data) override {
    copyToDevice(data_ + place, data.data(), data.size());
  }
  void read(uint64_t place, std::span<std::byte> data) const override {
    copyToHost(data.data(), data_ + place, data.size());
  }

 private:
  uint64_t bytes_;
  std::vector<std::byte> host_;  // empty for memory of the kind `device`
  std::byte* data_;              // made last: its allocation may fail
};

// Runs one scan at a time: reading the results waits for the device.
class CudaMachine final : public Machine {
 public:
  explicit CudaMachine(const SimulatorOptions& options) : device_(chooseDevice(options.device)) {
    use(device_);
    traits_.info = device_.info;
    if (options.tuning.maxBufferBytes > 0) traits_.info.maxBufferBytes = options.tuning.maxBufferBytes;
    traits_.int64Atomics = traits_.float64 = true;
    traits_.workgroups = device_.workgroups;
    traits_.spreadsRays = device_.spreadsRays;
  }

  const Traits& traits() const override { return traits_; }
  std::unique_ptr<DeviceMemory> allocate(const char* name, uint64_t bytes, MemoryKind kind) override {
    use(device_);
    return std::make_unique<CudaMemory>(name, bytes, kind);
  }
  void prepare(std::span<const Variant>) override {}
  size_t slots() const override { return 1; }
  void wait(size_t) override {}
  void readTimings(size_t, Timings& timings) override { stopwatch_.read(timings); }

  void submit(size_t, std::span<const Step> steps, const BoundArrays& arrays) override {
    use(device_);
    Job job = {addressesOf(arrays), {}, {}};
    for (const Step& step : steps) run(step, arrays, job);
  }

 private:
  void run(const Step& step, const BoundArrays& arrays, Job& job) {
    const DeviceMemory* to = arrays[static_cast<size_t>(step.array)];
    switch (step.kind) {
      case Step::Kind::fill:  // the pattern is 0 or kNone, so all its bytes are equal
        return fill(reinterpret_cast<std::byte*>(to->address()) + step.first, static_cast<uint8_t>(step.value),
                    step.bytes > 0 ? step.bytes : to->bytes());
      case Step::Kind::copy: {
        const DeviceMemory* from = arrays[static_cast<size_t>(step.from)];
        return copy(reinterpret_cast<void*>(to->address()), reinterpret_cast<const void*>(from->address()),
                    std::min(from->bytes(), to->bytes()));
      }
      case Step::Kind::start: return stopwatch_.start();
      case Step::Kind::finish: return stopwatch_.finished(step.stage);
      case Step::Kind::cut: return;
      case Step::Kind::dispatch:
        job.pass = step.pass;
        job.options = step.variant.options;
        return device_.launch(step.variant.kernel, job, step.workgroupsX, step.workgroupsY);
    }
  }

  Device device_;
  Traits traits_;
  Stopwatch stopwatch_;
};

}  // namespace

std::unique_ptr<Machine> makeMachine(const SimulatorOptions& options) {
  return std::make_unique<CudaMachine>(options);
}

std::unique_ptr<Backend> makeBackend(const Scene& scene, const SensorPlans& sensors, const SimulatorOptions& options) {
  return makeDeviceBackend(makeMachine(options), scene, sensors, options);
}

}  // namespace gnosphere::cuda
