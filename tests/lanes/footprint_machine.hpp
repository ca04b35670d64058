// SPDX-License-Identifier: Apache-2.0
// The lanes as a device that looks into the arrays of footprints.
#pragma once

#include <algorithm>
#include <array>

#include "pipeline/device_backend.hpp"

namespace gnosphere::cuda_lanes {
std::unique_ptr<Machine> makeMachine(const SimulatorOptions& options);
}

namespace gnosphere::test {

/// Looks at the footprints of all beams when their triangles have been binned.
class FootprintMachine : public Machine {
 public:
  explicit FootprintMachine(const SimulatorOptions& options) : lanes_(cuda_lanes::makeMachine(options)) {}

  const Traits& traits() const override { return lanes_->traits(); }
  std::unique_ptr<DeviceMemory> allocate(const char* name, uint64_t bytes, MemoryKind kind) override {
    return lanes_->allocate(name, bytes, kind);
  }
  void prepare(std::span<const Variant> variants) override { lanes_->prepare(variants); }
  size_t slots() const override { return lanes_->slots(); }
  void wait(size_t slot) override { lanes_->wait(slot); }
  void readTimings(size_t slot, Timings& timings) override { lanes_->readTimings(slot, timings); }
  void submit(size_t slot, std::span<const Step> steps, const BoundArrays& arrays) override {
    const auto isLastBin = std::find_if(steps.rbegin(), steps.rend(), [](const Step& step) {
      return step.kind == Step::Kind::dispatch && step.variant.kernel == Kernel::bin;
    });
    const auto binned = static_cast<size_t>(steps.rend() - isLastBin);
    lanes_->submit(slot, steps.first(binned), arrays);
    look(arrays);
    lanes_->submit(slot, steps.subspan(binned), arrays);
  }

  size_t covered = 0;  ///< beams of which triangles stop all sub-rays
  size_t endless = 0;  ///< those of them for which no triangle has noticed it

 private:
  void look(const BoundArrays& arrays) {
    const auto covers = contentOf<gpu::Cover>(*arrays[static_cast<size_t>(gpu::Array::covers)]);
    const auto words = contentOf<std::array<uint32_t, 2>>(*arrays[static_cast<size_t>(gpu::Array::words)]);
    gpu::Cover all = {};  // some beam is stopped as a whole, and then has the bits of all sub-rays that carry energy
    for (const gpu::Cover& cover : covers) {
      all.lowRays |= cover.lowRays;
      all.highRays |= cover.highRays;
    }
    covered = endless = 0;
    for (size_t beam = 0; beam < std::min(words.size(), covers.size()); ++beam) {
      if (covers[beam].lowRays != all.lowRays || covers[beam].highRays != all.highRays) continue;
      ++covered;
      endless += words[beam][1] == gpu::kNone;
    }
  }

  template <typename T>
  static std::vector<T> contentOf(const DeviceMemory& memory) {
    std::vector<T> content(memory.bytes() / sizeof(T));
    memory.read(0, std::as_writable_bytes(std::span(content)));
    return content;
  }
  std::unique_ptr<Machine> lanes_;
};

}  // namespace gnosphere::test
