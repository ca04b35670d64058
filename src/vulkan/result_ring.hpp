// SPDX-License-Identifier: Apache-2.0
// Buffers for the results of batches on our own device.
#pragma once

#include <deque>
#include <memory>

#include "pipeline/result_ring.hpp"
#include "vulkan/commands.hpp"
#include "vulkan/cuda_memory.hpp"

namespace gnosphere::vulkan {

inline constexpr const char* kResultsName = "results of batches";

class VulkanRing final : public ResultRing {
 public:
  /// Makes `buffers` buffers of `bytes` bytes each. The host gets the first `hostBytes` of each, or all of them if it
  /// shares the memory.
  VulkanRing(const Device& device, size_t buffers, uint64_t bytes, uint64_t hostBytes);

  void begin(size_t buffer) override;
  /// The commands that are being recorded.
  Commands& commands(size_t buffer) { return slots_[buffer].commands; }
  void submit(size_t buffer, uint64_t bytes) override;
  void wait(size_t buffer) override;
  uint64_t address(size_t buffer) const override { return slots_[buffer].results.address(); }
  const std::byte* host(size_t buffer) const override;
  bool hostHasAll(size_t buffer) const override;
  uint64_t bytes() const override;
  std::pair<int, uint64_t> fd(size_t buffer) const override;
  std::pair<uint64_t, int> cudaAddress(size_t buffer) override;
  const Buffer& results(size_t buffer) const { return slots_[buffer].results; }

 private:
  struct Slot {
    Slot(const Device& device, uint64_t bytes, uint64_t hostBytes);
    const Buffer& onHost() const { return copy.handle() ? copy : results; }

    bool givenAway = false;            // the results belong to those outside who read them
    Buffer results, copy;              // `copy` is without a handle if the host sees the results themselves
    std::unique_ptr<CudaMemory> cuda;  // null until it is asked for
    Commands commands;                 // last member, destroyed first: its destructor waits for the device
  };

  const Device& device_;
  uint64_t hostBytes_;
  std::deque<Slot> slots_;
};

}  // namespace gnosphere::vulkan
