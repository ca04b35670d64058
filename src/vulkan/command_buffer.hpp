// SPDX-License-Identifier: Apache-2.0
// Writes commands into a command buffer in the recording state, ours or the caller's.
#pragma once

#include "vulkan/buffer.hpp"
#include "vulkan/kernel.hpp"

namespace gnosphere::vulkan {

class CommandBuffer {
 public:
  CommandBuffer() = default;
  CommandBuffer(const Device& device, VkCommandBuffer commands)
      : vk_(&device.vk()),
        commands_(commands),
        mostGroups_(device.capabilities().mostGroups),
        queueFamily_(device.capabilities().queueFamily) {}

  VkCommandBuffer handle() const { return commands_; }
  /// More workgroups than a dispatch may have become several dispatches, whose first workgroups their constants name,
  /// if the constants say that the kernel can be divided.
  void dispatch(const KernelHandle& kernel, VkPipelineLayout layout, const PushConstants& constants,
                uint32_t workgroupsX, uint32_t workgroupsY);
  /// Reads the number of workgroups from a buffer.
  void dispatchIndirect(const KernelHandle& kernel, VkPipelineLayout layout, const PushConstants& constants,
                        const Buffer& arguments, VkDeviceSize offset);
  /// Name what comes between them for tools such as RenderDoc, if the device has VK_EXT_debug_utils.
  void beginLabel(const char* name);
  void endLabel();
  void fill(const Buffer& buffer, VkDeviceSize offset, VkDeviceSize size, uint32_t value);
  void copy(const Buffer& from, const Buffer& to);
  void copy(const Buffer& from, const Buffer& to, const VkBufferCopy& region);
  /// Makes all earlier writes visible to all later commands. A scan has about ten barriers; finer ones would gain
  /// nothing, because each step depends on the one before.
  void barrier();
  /// Puts the commands before and after it in order, whatever they are: those of the caller and ours.
  void fullBarrier();
  /// Gives an exported buffer to whoever reads it outside this Vulkan device, and takes it back before it is written
  /// again: a buffer belongs to one family of queues at a time, and those outside count as a family.
  void giveAway(const Buffer& buffer) { pass(buffer, queueFamily_, VK_QUEUE_FAMILY_EXTERNAL); }
  void takeBack(const Buffer& buffer) { pass(buffer, VK_QUEUE_FAMILY_EXTERNAL, queueFamily_); }

 private:
  void pass(const Buffer& buffer, uint32_t from, uint32_t to);
  void bind(const KernelHandle& kernel, VkPipelineLayout layout, const PushConstants& constants);

  const DeviceFunctions* vk_ = nullptr;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  uint32_t mostGroups_ = 0, queueFamily_ = 0;
};

}  // namespace gnosphere::vulkan
