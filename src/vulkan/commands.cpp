// SPDX-License-Identifier: Apache-2.0
#include "vulkan/commands.hpp"

#include <algorithm>

namespace gnosphere::vulkan {

Commands::Commands(const Device& device, uint32_t stamps) : device_(device), vk_(device.vk()), stampLimit_(stamps) {
  VkCommandPoolCreateInfo pool = {VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
  pool.queueFamilyIndex = device_.capabilities().queueFamily;
  pool_ = device.make(vk_.vkCreateCommandPool, vk_.vkDestroyCommandPool, pool);
  VkCommandBufferAllocateInfo allocate = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  allocate.commandPool = pool_.get();
  allocate.commandBufferCount = 1;
  VK(vk_.vkAllocateCommandBuffers(device_.handle(), &allocate, &commands_));
  VkQueryPoolCreateInfo queries = {VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
  queries.queryType = VK_QUERY_TYPE_TIMESTAMP;
  queries.queryCount = stamps;
  queries_ = device.make(vk_.vkCreateQueryPool, vk_.vkDestroyQueryPool, queries);
  const VkFenceCreateInfo fence = {VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  fence_ = device.make(vk_.vkCreateFence, vk_.vkDestroyFence, fence);
}

Commands::~Commands() {
  const VkFence fence = fence_.get();
  if (pending_) vk_.vkWaitForFences(device_.handle(), 1, &fence, VK_TRUE, UINT64_MAX);
}

void Commands::begin() {
  VkCommandBufferBeginInfo begin = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  VK(vk_.vkBeginCommandBuffer(commands_, &begin));
  vk_.vkCmdResetQueryPool(commands_, queries_.get(), 0, stampLimit_);
  stages_.clear();
}

void Commands::bind(VkPipeline kernel, VkPipelineLayout layout, const PushConstants& constants) {
  vk_.vkCmdBindPipeline(commands_, VK_PIPELINE_BIND_POINT_COMPUTE, kernel);
  vk_.vkCmdPushConstants(commands_, layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof constants, &constants);
}

void Commands::dispatch(VkPipeline kernel, VkPipelineLayout layout, const PushConstants& constants, uint32_t groupsX,
                        uint32_t groupsY) {
  bind(kernel, layout, constants);
  vk_.vkCmdDispatch(commands_, groupsX, groupsY, 1);
}

void Commands::dispatchIndirect(VkPipeline kernel, VkPipelineLayout layout, const PushConstants& constants,
                                const Buffer& arguments, VkDeviceSize offset) {
  bind(kernel, layout, constants);
  vk_.vkCmdDispatchIndirect(commands_, arguments.handle(), offset);
}

void Commands::fill(const Buffer& buffer, VkDeviceSize offset, VkDeviceSize size, uint32_t value) {
  vk_.vkCmdFillBuffer(commands_, buffer.handle(), offset, size, value);
}

void Commands::copy(const Buffer& from, const Buffer& to) {
  const VkBufferCopy region = {0, 0, std::min(from.bytes(), to.bytes())};
  vk_.vkCmdCopyBuffer(commands_, from.handle(), to.handle(), 1, &region);
}

void Commands::barrier() {
  constexpr VkPipelineStageFlags kDevice =
      VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT | VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT;
  VkMemoryBarrier memory = {VK_STRUCTURE_TYPE_MEMORY_BARRIER};
  memory.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
  memory.dstAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_READ_BIT |
                         VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_INDIRECT_COMMAND_READ_BIT | VK_ACCESS_HOST_READ_BIT;
  vk_.vkCmdPipelineBarrier(commands_, kDevice, kDevice | VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &memory, 0, nullptr, 0,
                           nullptr);
}

void Commands::stamp(const char* stage) {
  if (device_.capabilities().timestampBits == 0) return;
  vk_.vkCmdWriteTimestamp(commands_, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queries_.get(),
                          static_cast<uint32_t>(stages_.size()));
  stages_.push_back(stage);
}

void Commands::submit() {
  VK(vk_.vkEndCommandBuffer(commands_));
  VkSubmitInfo submit = {VK_STRUCTURE_TYPE_SUBMIT_INFO};
  submit.commandBufferCount = 1;
  submit.pCommandBuffers = &commands_;
  VK(vk_.vkQueueSubmit(device_.queue(), 1, &submit, fence_.get()));
  pending_ = true;
}

void Commands::wait() {
  if (!pending_) return;
  const VkFence fence = fence_.get();
  VK(vk_.vkWaitForFences(device_.handle(), 1, &fence, VK_TRUE, UINT64_MAX));
  VK(vk_.vkResetFences(device_.handle(), 1, &fence));
  pending_ = false;
}

void Commands::readTimings(Timings& timings) {
  if (stages_.empty()) return;
  std::vector<uint64_t> ticks(stages_.size());
  VK(vk_.vkGetQueryPoolResults(device_.handle(), queries_.get(), 0, static_cast<uint32_t>(ticks.size()),
                               ticks.size() * sizeof ticks[0], ticks.data(), sizeof ticks[0],
                               VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT));
  for (size_t i = 1; i < ticks.size(); ++i) {
    if (!stages_[i]) continue;
    const double ms = device_.capabilities().elapsedMs(ticks[i - 1], ticks[i]);
    timings.gpuMs += ms;
    timings.add(stages_[i], ms);
  }
}

}  // namespace gnosphere::vulkan
