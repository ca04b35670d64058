// SPDX-License-Identifier: Apache-2.0
#include "vulkan/commands.hpp"

namespace gnosphere::vulkan {

Commands::Commands(const Device& device, uint32_t stamps) : device_(device), vk_(device.vk()), stampLimit_(stamps) {
  VkCommandPoolCreateInfo pool = {VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
  pool.queueFamilyIndex = device_.capabilities().queueFamily;
  pool_ = device.make(vk_.vkCreateCommandPool, vk_.vkDestroyCommandPool, pool);
  VkCommandBufferAllocateInfo allocate = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  allocate.commandPool = pool_.get();
  allocate.commandBufferCount = 1;
  VkCommandBuffer commands = VK_NULL_HANDLE;
  VK(vk_.vkAllocateCommandBuffers(device_.handle(), &allocate, &commands));
  commands_ = {device, commands};
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
  VK(vk_.vkBeginCommandBuffer(commands_.handle(), &begin));
  vk_.vkCmdResetQueryPool(commands_.handle(), queries_.get(), 0, stampLimit_);
  stages_.clear();
}

void Commands::stamp(const char* stage) {
  if (device_.capabilities().timestampBits == 0) return;
  vk_.vkCmdWriteTimestamp(commands_.handle(), VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queries_.get(),
                          static_cast<uint32_t>(stages_.size()));
  stages_.push_back(stage);
}

void Commands::submit() {
  VK(vk_.vkEndCommandBuffer(commands_.handle()));
  const VkCommandBuffer commands = commands_.handle();
  VkSubmitInfo submit = {VK_STRUCTURE_TYPE_SUBMIT_INFO};
  submit.commandBufferCount = 1;
  submit.pCommandBuffers = &commands;
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
