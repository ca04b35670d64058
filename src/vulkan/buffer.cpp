// SPDX-License-Identifier: Apache-2.0
#include "vulkan/buffer.hpp"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <utility>

namespace gnosphere::vulkan {
namespace {

constexpr uint64_t kMostStagingBytes = 16 << 20;

std::string mebibytes(uint64_t bytes) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f MiB", static_cast<double>(bytes) / (1 << 20));
  return text;
}

int chooseMemory(const Device& device, uint32_t bits, MemoryKind kind) {
  constexpr VkMemoryPropertyFlags kLocal = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
  constexpr VkMemoryPropertyFlags kVisible = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT;
  constexpr VkMemoryPropertyFlags kCached = VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
  constexpr VkMemoryPropertyFlags kCoherent = VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  const VkMemoryPropertyFlags device0[] = {kLocal, 0};
  const VkMemoryPropertyFlags upload[] = {kLocal | kVisible | kCoherent, kVisible | kCoherent};
  const VkMemoryPropertyFlags readback[] = {kVisible | kCached, kVisible};
  const auto& order = kind == MemoryKind::device ? device0 : kind == MemoryKind::upload ? upload : readback;
  for (VkMemoryPropertyFlags wanted : order)
    if (const int type = device.memoryType(bits, wanted); type >= 0) return type;
  throw Error(ErrorCode::device, "the device '" + device.capabilities().info.name + "' has no suitable memory");
}

}  // namespace

Buffer::Buffer(const Device& device, const char* name, uint64_t bytes, MemoryKind kind)
    : device_(&device), bytes_(std::max<uint64_t>(bytes, 16)), name_(name) {
  if (bytes_ > device.maxBufferBytes())
    throw Error(ErrorCode::outOfMemory, "'" + std::string(name) + "' needs one buffer of " + mebibytes(bytes_) +
                                            "; the device '" + device.capabilities().info.name + "' allows " +
                                            mebibytes(device.maxBufferBytes()));
  VkBufferCreateInfo create = {VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
  create.size = bytes_;
  create.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT |
                 VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |
                 VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
  const DeviceFunctions& vk = device.vk();
  DeviceHandle<VkBuffer> buffer = device.make(vk.vkCreateBuffer, vk.vkDestroyBuffer, create);
  VkMemoryRequirements requirements;
  vk.vkGetBufferMemoryRequirements(device.handle(), buffer.get(), &requirements);
  // If device and host share their memory, the host may read everything in place.
  const bool inPlace = device.unifiedMemory() && kind == MemoryKind::device;
  const int type = chooseMemory(device, requirements.memoryTypeBits, inPlace ? MemoryKind::readback : kind);
  const AdoptedDevice* const adopted = device.adopted();
  if (adopted && adopted->allocator.allocate)
    borrow(adopted->allocator, requirements, type);
  else
    allocate(requirements, type);
  buffer_ = std::move(buffer);
  VK(vk.vkBindBufferMemory(device.handle(), buffer_.get(), place_, offset_));
  VkBufferDeviceAddressInfo where = {VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO};
  where.buffer = buffer_.get();
  address_ = vk.vkGetBufferDeviceAddress(device.handle(), &where);
  coherent_ = device.isCoherent(type);
}

void Buffer::allocate(const VkMemoryRequirements& requirements, int type) {
  const DeviceFunctions& vk = device_->vk();
  VkMemoryAllocateFlagsInfo flags = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO};
  flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
  VkMemoryAllocateInfo allocate = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, &flags};
  allocate.allocationSize = requirements.size;
  allocate.memoryTypeIndex = static_cast<uint32_t>(type);
  VkDeviceMemory memory = VK_NULL_HANDLE;
  need(vk.vkAllocateMemory(device_->handle(), &allocate, nullptr, &memory) == VK_SUCCESS);
  memory_ = {memory, vk.vkFreeMemory, device_->handle()};
  place_ = memory;
  if (!device_->isHostVisible(type)) return;
  // If the host has no memory left, Mesa's lavapipe reports success and maps to null or to MAP_FAILED (-1). Valid
  // addresses are multiples of 64.
  const VkResult result = vk.vkMapMemory(device_->handle(), memory, 0, VK_WHOLE_SIZE, 0, &mapped_);
  need(result == VK_SUCCESS && mapped_ && reinterpret_cast<uintptr_t>(mapped_) % 64 == 0);
}

void Buffer::borrow(const Allocator& from, const VkMemoryRequirements& requirements, int type) {
  const Allocation allocation = from.allocate(requirements, static_cast<uint32_t>(type));
  need(allocation.memory != VK_NULL_HANDLE);
  borrowed_ = {from, allocation};
  place_ = allocation.memory;
  offset_ = allocation.offset;
  if (!device_->isHostVisible(type)) return;
  need(allocation.mapped != nullptr);
  mapped_ = allocation.mapped;
}

void Buffer::need(bool succeeded) const {
  if (!succeeded)
    throw Error(ErrorCode::outOfMemory, "cannot allocate " + mebibytes(bytes_) + " for '" + name_ + "'; the device '" +
                                            device_->capabilities().info.name + "' has " +
                                            mebibytes(device_->heapBytes()) + " in all");
}

// All of the memory that is ours alone. Of memory that others share, the range of the buffer: the caller's allocator
// aligns it to the size of the device's atoms, as the Vulkan Memory Allocator does.
VkMappedMemoryRange Buffer::mappedRange() const {
  VkMappedMemoryRange range = {VK_STRUCTURE_TYPE_MAPPED_MEMORY_RANGE};
  range.memory = place_;
  range.offset = offset_;
  range.size = memory_ ? VK_WHOLE_SIZE : bytes_;
  return range;
}

void Buffer::invalidate() const {
  if (coherent_) return;
  const VkMappedMemoryRange range = mappedRange();
  VK(device_->vk().vkInvalidateMappedMemoryRanges(device_->handle(), 1, &range));
}

void Buffer::flush() const {
  if (coherent_) return;
  const VkMappedMemoryRange range = mappedRange();
  VK(device_->vk().vkFlushMappedMemoryRanges(device_->handle(), 1, &range));
}

Transfer::Transfer(const Device& device) : device_(device) {
  VkCommandPoolCreateInfo create = {VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  create.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
  create.queueFamilyIndex = device.capabilities().queueFamily;
  pool_ = device.make(device.vk().vkCreateCommandPool, device.vk().vkDestroyCommandPool, create);
}

void Transfer::write(Buffer& buffer, uint64_t place, std::span<const std::byte> data) {
  if (data.empty()) return;
  if (buffer.mapped()) {
    std::memcpy(static_cast<std::byte*>(buffer.mapped()) + place, data.data(), data.size());
    buffer.flush();
    return;
  }
  const uint64_t most = stage(MemoryKind::upload);
  for (uint64_t done = 0; done < data.size(); done += most) {
    const uint64_t size = std::min(data.size() - done, most);
    std::memcpy(staging_.mapped(), data.data() + done, size);
    staging_.flush();
    copy(staging_.handle(), buffer.handle(), {0, place + done, size});
  }
}

void Transfer::read(const Buffer& buffer, uint64_t place, std::span<std::byte> data) {
  if (data.empty()) return;
  if (buffer.mapped()) {
    buffer.invalidate();
    std::memcpy(data.data(), static_cast<const std::byte*>(buffer.mapped()) + place, data.size());
    return;
  }
  const uint64_t most = stage(MemoryKind::readback);
  for (uint64_t done = 0; done < data.size(); done += most) {
    const uint64_t size = std::min(data.size() - done, most);
    copy(buffer.handle(), staging_.handle(), {place + done, 0, size});
    staging_.invalidate();
    std::memcpy(data.data() + done, staging_.mapped(), size);
  }
}

// Makes the staging buffer of the given kind if it does not exist; returns its size.
uint64_t Transfer::stage(MemoryKind kind) {
  const uint64_t bytes = std::min(kMostStagingBytes, device_.maxBufferBytes());
  if (!staging_.handle() || stagingKind_ != kind) staging_ = Buffer(device_, "staging", bytes, kind);
  stagingKind_ = kind;
  return bytes;
}

void Transfer::copy(VkBuffer from, VkBuffer to, const VkBufferCopy& region) {
  VkCommandBufferAllocateInfo allocate = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  allocate.commandPool = pool_.get();
  allocate.commandBufferCount = 1;
  VkCommandBuffer commands;
  const DeviceFunctions& vk = device_.vk();
  VK(vk.vkAllocateCommandBuffers(device_.handle(), &allocate, &commands));
  VkCommandBufferBeginInfo begin = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  VK(vk.vkBeginCommandBuffer(commands, &begin));
  vk.vkCmdCopyBuffer(commands, from, to, 1, &region);
  VK(vk.vkEndCommandBuffer(commands));
  VkSubmitInfo submit = {VK_STRUCTURE_TYPE_SUBMIT_INFO};
  submit.commandBufferCount = 1;
  submit.pCommandBuffers = &commands;
  VK(vk.vkQueueSubmit(device_.queue(), 1, &submit, VK_NULL_HANDLE));
  VK(vk.vkQueueWaitIdle(device_.queue()));
  vk.vkFreeCommandBuffers(device_.handle(), pool_.get(), 1, &commands);
}

}  // namespace gnosphere::vulkan
