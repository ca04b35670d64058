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
    : device_(device.handle()), bytes_(std::max<uint64_t>(bytes, 16)), name_(name) {
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
  std::swap(name_, other.name_);
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

void Uploader::writeBytes(const void* data, Buffer& buffer, uint64_t offset, uint64_t bytes) {
  if (bytes == 0) return;
  if (buffer.mapped()) {
    std::memcpy(static_cast<char*>(buffer.mapped()) + offset, data, bytes);
    buffer.flush();
    return;
  }
  const uint64_t most = stage(Memory::upload);
  for (uint64_t done = 0; done < bytes; done += most) {
    const uint64_t size = std::min(bytes - done, most);
    std::memcpy(staging_.mapped(), static_cast<const char*>(data) + done, size);
    staging_.flush();
    copy(staging_.handle(), buffer.handle(), {0, offset + done, size});
  }
}

void Uploader::readBytes(const Buffer& buffer, uint64_t offset, uint64_t bytes, void* data) {
  if (bytes == 0) return;
  if (buffer.mapped()) {
    buffer.invalidate();
    std::memcpy(data, static_cast<const char*>(buffer.mapped()) + offset, bytes);
    return;
  }
  const uint64_t most = stage(Memory::readback);
  for (uint64_t done = 0; done < bytes; done += most) {
    const uint64_t size = std::min(bytes - done, most);
    copy(buffer.handle(), staging_.handle(), {offset + done, 0, size});
    staging_.invalidate();
    std::memcpy(static_cast<char*>(data) + done, staging_.mapped(), size);
  }
}

// Makes the staging buffer of that kind; its size.
uint64_t Uploader::stage(Memory memory) {
  const uint64_t bytes = std::min(kMostStagingBytes, device_.maxBufferBytes());
  if (!staging_.handle() || stagingKind_ != memory) staging_ = Buffer(device_, "staging", bytes, memory);
  stagingKind_ = memory;
  return bytes;
}

void Uploader::copy(VkBuffer from, VkBuffer to, const VkBufferCopy& region) {
  VkCommandBufferAllocateInfo allocate = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  allocate.commandPool = pool_;
  allocate.commandBufferCount = 1;
  VkCommandBuffer commands;
  VK(vkAllocateCommandBuffers(device_.handle(), &allocate, &commands));
  VkCommandBufferBeginInfo begin = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  VK(vkBeginCommandBuffer(commands, &begin));
  vkCmdCopyBuffer(commands, from, to, 1, &region);
  VK(vkEndCommandBuffer(commands));
  VkSubmitInfo submit = {VK_STRUCTURE_TYPE_SUBMIT_INFO};
  submit.commandBufferCount = 1;
  submit.pCommandBuffers = &commands;
  VK(vkQueueSubmit(device_.queue(), 1, &submit, VK_NULL_HANDLE));
  VK(vkQueueWaitIdle(device_.queue()));
  vkFreeCommandBuffers(device_.handle(), pool_, 1, &commands);
}

}  // namespace gnosphere::vulkan
