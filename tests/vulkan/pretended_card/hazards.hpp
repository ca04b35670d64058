// SPDX-License-Identifier: Apache-2.0
// The writes of one command buffer that later commands may not see, because no barrier lies between them. Validation
// layers do not know of them: they do not see which memory a kernel reads and writes by addresses.
#pragma once
#include <vulkan/vulkan.h>

#include <array>

namespace gnosphere::test {

class Hazards {
 public:
  /// Notes that a kernel is dispatched. This function and the next ones return why a call is wrong, or nullptr.
  const char* dispatch() {
    if (unseenBy_[kKernel] & kKernels) return "a kernel is dispatched without a barrier after the kernel before it";
    if (unseenBy_[kTransfer] & kKernels) return "a kernel is dispatched without a barrier after a fill or a copy";
    unseenBy_[kKernel] = kAll;
    return nullptr;
  }
  /// Notes that a kernel is dispatched whose number of workgroups the device reads.
  const char* dispatchIndirect() {
    if ((unseenBy_[kKernel] | unseenBy_[kTransfer]) & kArguments)
      return "the size of a dispatch is read without a barrier after what may write it";
    return dispatch();
  }
  /// Notes a fill or a copy. Validation layers see which buffers fills and copies write, so these may follow each
  /// other.
  const char* transfer() {
    if (unseenBy_[kKernel] & kTransfers) return "a buffer is filled or copied without a barrier after a kernel";
    unseenBy_[kTransfer] = kAll;
    return nullptr;
  }
  /// Returns what is wrong with the end of the commands, or nullptr.
  const char* end() const {
    if ((unseenBy_[kKernel] | unseenBy_[kTransfer]) & kHost) return "commands end without a barrier before the host";
    return nullptr;
  }
  void barrier(VkPipelineStageFlags from, VkPipelineStageFlags to, const VkMemoryBarrier& memory) {
    constexpr VkPipelineStageFlags kAny = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    const auto writes = [&](VkPipelineStageFlags stage, VkAccessFlags access) {
      return (from & (stage | kAny)) && (memory.srcAccessMask & (access | VK_ACCESS_MEMORY_WRITE_BIT));
    };
    const auto reads = [&](VkPipelineStageFlags stage, VkAccessFlags access) {
      return (to & (stage | kAny)) &&
             ((memory.dstAccessMask & access) == access || (memory.dstAccessMask & VK_ACCESS_MEMORY_READ_BIT));
    };
    unsigned seers = 0;
    if (reads(VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_READ_BIT)) seers |= kKernels;
    if (reads(VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT, VK_ACCESS_INDIRECT_COMMAND_READ_BIT)) seers |= kArguments;
    if (reads(VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT)) seers |= kTransfers;
    if (reads(VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT)) seers |= kHost;
    if (writes(VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT)) unseenBy_[kKernel] &= ~seers;
    if (writes(VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT)) unseenBy_[kTransfer] &= ~seers;
  }

 private:
  enum Writer { kKernel, kTransfer, kWriters };
  static constexpr unsigned kKernels = 1, kArguments = 2, kTransfers = 4, kHost = 8, kAll = 15;
  std::array<unsigned, kWriters> unseenBy_ = {};
};

}  // namespace gnosphere::test
