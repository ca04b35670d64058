// SPDX-License-Identifier: Apache-2.0
#include "vulkan/command_buffer.hpp"

#include <algorithm>

namespace gnosphere::vulkan {

void CommandBuffer::bind(const KernelHandle& kernel, VkPipelineLayout layout, const PushConstants& constants) {
  constexpr VkShaderStageFlagBits kStage = VK_SHADER_STAGE_COMPUTE_BIT;
  if (kernel.shader)
    vk_->vkCmdBindShadersEXT(commands_, 1, &kStage, &kernel.shader);
  else
    vk_->vkCmdBindPipeline(commands_, VK_PIPELINE_BIND_POINT_COMPUTE, kernel.pipeline);
  vk_->vkCmdPushConstants(commands_, layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof constants, &constants);
}

void CommandBuffer::dispatch(const KernelHandle& kernel, VkPipelineLayout layout, const PushConstants& constants,
                             uint32_t workgroupsX, uint32_t workgroupsY) {
  // A step of a kernel that cannot be divided never has more workgroups than a dispatch may have.
  const uint32_t most = constants.pass.groups > 0 ? mostGroups_ : workgroupsX;
  PushConstants part = constants;
  for (uint32_t first = 0; first < workgroupsX; first += std::min(most, workgroupsX - first)) {
    part.pass.firstGroup = constants.pass.firstGroup + first;
    bind(kernel, layout, part);
    vk_->vkCmdDispatch(commands_, std::min(most, workgroupsX - first), workgroupsY, 1);
  }
}

void CommandBuffer::dispatchIndirect(const KernelHandle& kernel, VkPipelineLayout layout,
                                     const PushConstants& constants, const Buffer& arguments, VkDeviceSize offset) {
  bind(kernel, layout, constants);
  vk_->vkCmdDispatchIndirect(commands_, arguments.handle(), offset);
}

void CommandBuffer::beginLabel(const char* name) {
  if (!vk_->vkCmdBeginDebugUtilsLabelEXT) return;
  VkDebugUtilsLabelEXT label = {VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT};
  label.pLabelName = name;
  vk_->vkCmdBeginDebugUtilsLabelEXT(commands_, &label);
}

void CommandBuffer::endLabel() {
  if (vk_->vkCmdEndDebugUtilsLabelEXT) vk_->vkCmdEndDebugUtilsLabelEXT(commands_);
}

void CommandBuffer::fill(const Buffer& buffer, VkDeviceSize offset, VkDeviceSize size, uint32_t value) {
  vk_->vkCmdFillBuffer(commands_, buffer.handle(), offset, size, value);
}

void CommandBuffer::copy(const Buffer& from, const Buffer& to) {
  copy(from, to, {0, 0, std::min(from.bytes(), to.bytes())});
}

void CommandBuffer::copy(const Buffer& from, const Buffer& to, const VkBufferCopy& region) {
  vk_->vkCmdCopyBuffer(commands_, from.handle(), to.handle(), 1, &region);
}

void CommandBuffer::barrier() {
  constexpr VkPipelineStageFlags kDevice =
      VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT | VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT;
  VkMemoryBarrier memory = {VK_STRUCTURE_TYPE_MEMORY_BARRIER};
  memory.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
  memory.dstAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_READ_BIT |
                         VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_INDIRECT_COMMAND_READ_BIT | VK_ACCESS_HOST_READ_BIT;
  vk_->vkCmdPipelineBarrier(commands_, kDevice, kDevice | VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &memory, 0, nullptr, 0,
                            nullptr);
}

void CommandBuffer::fullBarrier() {
  VkMemoryBarrier memory = {VK_STRUCTURE_TYPE_MEMORY_BARRIER};
  memory.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
  memory.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
  constexpr VkPipelineStageFlags kAll = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
  vk_->vkCmdPipelineBarrier(commands_, kAll, kAll | VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &memory, 0, nullptr, 0, nullptr);
}

void CommandBuffer::pass(const Buffer& buffer, uint32_t from, uint32_t to) {
  VkBufferMemoryBarrier barrier = {VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER};
  // Vulkan ignores the accesses of the side that is outside.
  barrier.srcAccessMask = from == queueFamily_ ? VK_ACCESS_MEMORY_WRITE_BIT : 0;
  barrier.dstAccessMask = to == queueFamily_ ? VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT : 0;
  barrier.srcQueueFamilyIndex = from;
  barrier.dstQueueFamilyIndex = to;
  barrier.buffer = buffer.handle();
  barrier.size = VK_WHOLE_SIZE;
  constexpr VkPipelineStageFlags kAll = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
  vk_->vkCmdPipelineBarrier(commands_, kAll, kAll, 0, 0, nullptr, 1, &barrier, 0, nullptr);
}

}  // namespace gnosphere::vulkan
