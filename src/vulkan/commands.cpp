// SPDX-License-Identifier: Apache-2.0
#include "vulkan/commands.hpp"

#include <algorithm>

namespace gnosphere::vulkan {

Commands::Commands(const Device& device, const Layout& layout, uint32_t stamps)
    : device_(device), layout_(layout), stampLimit_(stamps) {
  VkCommandPoolCreateInfo pool = {VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
  pool.queueFamilyIndex = device_.capabilities().queueFamily;
  VK(vkCreateCommandPool(device_.handle(), &pool, nullptr, &pool_));
  VkCommandBufferAllocateInfo allocate = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  allocate.commandPool = pool_;
  allocate.commandBufferCount = 1;
  VK(vkAllocateCommandBuffers(device_.handle(), &allocate, &commands_));
  VkQueryPoolCreateInfo queries = {VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
  queries.queryType = VK_QUERY_TYPE_TIMESTAMP;
  queries.queryCount = stamps;
  VK(vkCreateQueryPool(device_.handle(), &queries, nullptr, &queries_));
  const VkFenceCreateInfo fence = {VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  VK(vkCreateFence(device_.handle(), &fence, nullptr, &fence_));
}

Commands::~Commands() {
  if (pending_) vkWaitForFences(device_.handle(), 1, &fence_, VK_TRUE, UINT64_MAX);
  vkDestroyFence(device_.handle(), fence_, nullptr);
  vkDestroyQueryPool(device_.handle(), queries_, nullptr);
  vkDestroyCommandPool(device_.handle(), pool_, nullptr);
}

void Commands::begin() {
  VkCommandBufferBeginInfo begin = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  VK(vkBeginCommandBuffer(commands_, &begin));
  vkCmdResetQueryPool(commands_, queries_, 0, stampLimit_);
  stages_.clear();
}

void Commands::bindSet(uint32_t index, VkDescriptorSet set) {
  vkCmdBindDescriptorSets(commands_, VK_PIPELINE_BIND_POINT_COMPUTE, layout_.handle(), index, 1, &set, 0, nullptr);
}

void Commands::push(const gpu::Pass& pass) {
  vkCmdPushConstants(commands_, layout_.handle(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof pass, &pass);
}

void Commands::dispatch(const Kernel& kernel, uint32_t groupsX, uint32_t groupsY) {
  if (groupsX == 0 || groupsY == 0) return;
  vkCmdBindPipeline(commands_, VK_PIPELINE_BIND_POINT_COMPUTE, kernel.handle());
  vkCmdDispatch(commands_, groupsX, groupsY, 1);
  barrier();
}

void Commands::fill(const Buffer& buffer, VkDeviceSize offset, VkDeviceSize size, uint32_t value) {
  vkCmdFillBuffer(commands_, buffer.handle(), offset, size, value);
}

void Commands::copy(const Buffer& from, const Buffer& to) {
  const VkBufferCopy region = {0, 0, std::min(from.bytes(), to.bytes())};
  vkCmdCopyBuffer(commands_, from.handle(), to.handle(), 1, &region);
}

void Commands::barrier() {
  constexpr VkPipelineStageFlags kDevice = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT;
  VkMemoryBarrier memory = {VK_STRUCTURE_TYPE_MEMORY_BARRIER};
  memory.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
  memory.dstAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_READ_BIT |
                         VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_HOST_READ_BIT;
  vkCmdPipelineBarrier(commands_, kDevice, kDevice | VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &memory, 0, nullptr, 0, nullptr);
}

void Commands::stamp(const char* stage) {
  if (device_.capabilities().timestampBits == 0) return;
  vkCmdWriteTimestamp(commands_, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queries_, static_cast<uint32_t>(stages_.size()));
  stages_.push_back(stage);
}

void Commands::submit() {
  VK(vkEndCommandBuffer(commands_));
  VkSubmitInfo submit = {VK_STRUCTURE_TYPE_SUBMIT_INFO};
  submit.commandBufferCount = 1;
  submit.pCommandBuffers = &commands_;
  VK(vkQueueSubmit(device_.queue(), 1, &submit, fence_));
  pending_ = true;
}

void Commands::wait() {
  if (!pending_) return;
  VK(vkWaitForFences(device_.handle(), 1, &fence_, VK_TRUE, UINT64_MAX));
  VK(vkResetFences(device_.handle(), 1, &fence_));
  pending_ = false;
}

void Commands::readTimings(Timings& timings) {
  if (stages_.empty()) return;
  std::vector<uint64_t> ticks(stages_.size());
  VK(vkGetQueryPoolResults(device_.handle(), queries_, 0, static_cast<uint32_t>(ticks.size()),
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
