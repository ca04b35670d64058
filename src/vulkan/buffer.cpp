// SPDX-License-Identifier: Apache-2.0
#include "vulkan/buffer.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

namespace gnosphere::vulkan {
namespace {

constexpr uint64_t kMostStagingBytes = 16 << 20;

std::string mebibytes(uint64_t bytes) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f MiB", static_cast<double>(bytes) / (1 << 20));
  return text;
}

int chooseMemory(const Device& device, uint32_t bits, Memory memory) {
  constexpr VkMemoryPropertyFlags kLocal = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
  constexpr VkMemoryPropertyFlags kVisible = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT;
  constexpr VkMemoryPropertyFlags kCached = VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
  constexpr VkMemoryPropertyFlags kCoherent = VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  const VkMemoryPropertyFlags device0[] = {kLocal, 0};
  const VkMemoryPropertyFlags upload[] = {kLocal | kVisible | kCoherent, kVisible | kCoherent};
  const VkMemoryPropertyFlags readback[] = {kVisible | kCached, kVisible};
  const auto& order = memory == Memory::device ? device0 : memory == Memory::upload ? upload : readback;
  for (VkMemoryPropertyFlags wanted : order)
    if (const int type = device.memoryType(bits, wanted); type >= 0) return type;
  throw Error(ErrorCode::device, "the device '" + device.capabilities().info.name + "' has no suitable memory");
}

}  // namespace

Buffer::Buffer(const Device& device, const char* name, uint64_t bytes, Memory memory)
    : device_(device.handle()), bytes_(std::max<uint64_t>(bytes, 16)) {
  if (bytes_ > device.maxBufferBytes())
    throw Error(ErrorCode::outOfMemory, "'" + std::string(name) + "' needs one buffer of " + mebibytes(bytes_) +
                                            "; the device '" + device.capabilities().info.name + "' allows " +
                                            mebibytes(device.maxBufferBytes()));
  VkBufferCreateInfo create = {VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
  create.size = bytes_;
  create.usage =
      VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  VK(vkCreateBuffer(device_, &create, nullptr, &buffer_));
  VkMemoryRequirements requirements;
  vkGetBufferMemoryRequirements(device_, buffer_, &requirements);
  // On a device that shares the host's memory everything may be read in place.
  const Memory kind = device.unifiedMemory() && memory == Memory::device ? Memory::readback : memory;
  const int type = chooseMemory(device, requirements.memoryTypeBits, kind);
  VkMemoryAllocateInfo allocate = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
  allocate.allocationSize = requirements.size;
  allocate.memoryTypeIndex = static_cast<uint32_t>(type);
  const VkResult result = vkAllocateMemory(device_, &allocate, nullptr, &memory_);
  if (result != VK_SUCCESS) {
    destroy();
    throw Error(ErrorCode::outOfMemory, "cannot allocate " + mebibytes(bytes_) + " for '" + name + "'; the device '" +
                                            device.capabilities().info.name + "' has " + mebibytes(device.heapBytes()) +
                                            " in all");
  }
  VK(vkBindBufferMemory(device_, buffer_, memory_, 0));
  coherent_ = device.isCoherent(type);
  if (device.isHostVisible(type)) VK(vkMapMemory(device_, memory_, 0, VK_WHOLE_SIZE, 0, &mapped_));
}

void Buffer::swap(Buffer& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(buffer_, other.buffer_);
  std::swap(memory_, other.memory_);
  std::swap(mapped_, other.mapped_);
  std::swap(coherent_, other.coherent_);
  std::swap(bytes_, other.bytes_);
}

void Buffer::destroy() {
  if (buffer_) vkDestroyBuffer(device_, buffer_, nullptr);
  if (memory_) vkFreeMemory(device_, memory_, nullptr);
  buffer_ = VK_NULL_HANDLE;
  memory_ = VK_NULL_HANDLE;
}

void Buffer::invalidate() const {
  if (coherent_) return;
  VkMappedMemoryRange range = {VK_STRUCTURE_TYPE_MAPPED_MEMORY_RANGE};
  range.memory = memory_;
  range.size = VK_WHOLE_SIZE;
  VK(vkInvalidateMappedMemoryRanges(device_, 1, &range));
}

void Buffer::flush() const {
  if (coherent_) return;
  VkMappedMemoryRange range = {VK_STRUCTURE_TYPE_MAPPED_MEMORY_RANGE};
  range.memory = memory_;
  range.size = VK_WHOLE_SIZE;
  VK(vkFlushMappedMemoryRanges(device_, 1, &range));
}

Uploader::Uploader(const Device& device) : device_(device) {
  VkCommandPoolCreateInfo create = {VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  create.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
  create.queueFamilyIndex = device.capabilities().queueFamily;
  VK(vkCreateCommandPool(device.handle(), &create, nullptr, &pool_));
}

Uploader::~Uploader() {
  vkDestroyCommandPool(device_.handle(), pool_, nullptr);
}

Buffer Uploader::uploadBytes(const char* name, const void* data, uint64_t bytes) {
  Buffer buffer(device_, name, bytes, Memory::device);
  if (bytes == 0) return buffer;
  if (buffer.mapped()) {
    std::memcpy(buffer.mapped(), data, bytes);
    buffer.flush();
    return buffer;
  }
  const uint64_t stagingBytes = std::min(kMostStagingBytes, device_.maxBufferBytes());
  if (!staging_.handle()) staging_ = Buffer(device_, "staging", stagingBytes, Memory::upload);
  for (uint64_t done = 0; done < bytes; done += stagingBytes) {
    const uint64_t size = std::min(bytes - done, stagingBytes);
    std::memcpy(staging_.mapped(), static_cast<const char*>(data) + done, size);
    VkCommandBufferAllocateInfo allocate = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
    allocate.commandPool = pool_;
    allocate.commandBufferCount = 1;
    VkCommandBuffer commands;
    VK(vkAllocateCommandBuffers(device_.handle(), &allocate, &commands));
    VkCommandBufferBeginInfo begin = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    VK(vkBeginCommandBuffer(commands, &begin));
    const VkBufferCopy copy = {0, done, size};
    vkCmdCopyBuffer(commands, staging_.handle(), buffer.handle(), 1, &copy);
    VK(vkEndCommandBuffer(commands));
    VkSubmitInfo submit = {VK_STRUCTURE_TYPE_SUBMIT_INFO};
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &commands;
    VK(vkQueueSubmit(device_.queue(), 1, &submit, VK_NULL_HANDLE));
    VK(vkQueueWaitIdle(device_.queue()));
    vkFreeCommandBuffers(device_.handle(), pool_, 1, &commands);
  }
  return buffer;
}

}  // namespace gnosphere::vulkan
