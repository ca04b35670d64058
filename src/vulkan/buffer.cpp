// SPDX-License-Identifier: Apache-2.0
#include "vulkan/buffer.hpp"

#include <algorithm>
#include <utility>

#include "base/text.hpp"

namespace gnosphere::vulkan {
namespace {

constexpr VkMemoryPropertyFlags kLocal = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
constexpr VkMemoryPropertyFlags kVisible = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT;
constexpr VkMemoryPropertyFlags kCached = VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
constexpr VkMemoryPropertyFlags kCoherent = VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;

// The properties of memory for each kind, best first. If one is used up, the next is taken.
using Wishes = std::span<const VkMemoryPropertyFlags>;
Wishes wishesFor(const Device& device, MemoryKind kind) {
  static constexpr VkMemoryPropertyFlags kDevice[] = {kLocal, 0};
  static constexpr VkMemoryPropertyFlags kUpload[] = {kLocal | kVisible | kCoherent, kVisible | kCoherent, kVisible};
  static constexpr VkMemoryPropertyFlags kReadback[] = {kVisible | kCached, kVisible};
  if (kind == MemoryKind::upload) return kUpload;
  // If device and host share their memory, the host may read everything in place.
  return kind == MemoryKind::readback || device.unifiedMemory() ? Wishes(kReadback) : Wishes(kDevice);
}

}  // namespace

void refuseLarger(const Device& device, const char* name, uint64_t bytes, uint64_t most) {
  if (bytes > most)
    throw Error(ErrorCode::outOfMemory, "'" + std::string(name) + "' needs one buffer of " + mebibytes(bytes) +
                                            "; the device '" + device.capabilities().info.name + "' allows " +
                                            mebibytes(most) +
                                            "; scan a sector of the sensor at a time, or a part of the scene");
}

Buffer::Buffer(const Device& device, const char* name, uint64_t bytes, MemoryKind kind)
    : Buffer(device, name, bytes, wishesFor(device, kind), Place::any) {}

Buffer Buffer::staging(const Device& device, uint64_t bytes, bool read) {
  static constexpr VkMemoryPropertyFlags kWritten[] = {kVisible | kCoherent, kVisible};
  static constexpr VkMemoryPropertyFlags kRead[] = {kVisible | kCached, kVisible};
  return Buffer(device, "staging", bytes, read ? Wishes(kRead) : Wishes(kWritten), Place::host);
}

Buffer Buffer::exported(const Device& device, const char* name, uint64_t bytes) {
  const Place place = device.capabilities().exportsMemory ? Place::exported : Place::any;
  return Buffer(device, name, bytes, wishesFor(device, MemoryKind::device), place);
}

Buffer::Buffer(const Device& device, const char* name, uint64_t bytes, Wishes wanted, Place place)
    : device_(&device), bytes_(std::max<uint64_t>(bytes, 16)), name_(name) {
  refuseLarger(device, name, bytes_, device.maxBufferBytes());
  const bool exported = place == Place::exported;
  const VkExternalMemoryBufferCreateInfo external = {VK_STRUCTURE_TYPE_EXTERNAL_MEMORY_BUFFER_CREATE_INFO, nullptr,
                                                     kExportedAs};
  VkBufferCreateInfo create = {VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, exported ? &external : nullptr};
  create.size = bytes_;
  create.usage = kBufferUsage;
  const DeviceFunctions& vk = device.vk();
  DeviceHandle<VkBuffer> buffer = device.make(vk.vkCreateBuffer, vk.vkDestroyBuffer, create);
  VkMemoryRequirements requirements;
  vk.vkGetBufferMemoryRequirements(device.handle(), buffer.get(), &requirements);
  // Ranges of memory that is flushed consist of whole atoms.
  requirements.size =
      (requirements.size + MemoryBlocks::kAlignment - 1) / MemoryBlocks::kAlignment * MemoryBlocks::kAlignment;
  requirements.alignment = std::max(requirements.alignment, MemoryBlocks::kAlignment);
  std::vector<uint32_t> types = device.memoryTypes(requirements.memoryTypeBits, wanted);
  if (types.empty())
    throw Error(ErrorCode::device, "the device '" + device.capabilities().info.name + "' has no suitable memory");
  if (place == Place::host)
    std::stable_partition(types.begin(), types.end(), [&](uint32_t type) { return !device.isLocal(type); });
  VkResult result = VK_ERROR_OUT_OF_DEVICE_MEMORY;
  for (size_t i = 0; i < types.size() && result != VK_SUCCESS; ++i) {
    result = take(requirements, types[i], exported);
    coherent_ = device.isCoherent(types[i]);
  }
  need(result);
  buffer_ = std::move(buffer);
  VK(vk.vkBindBufferMemory(device.handle(), buffer_.get(), memory_.memory(), memory_.offset()));
  VkBufferDeviceAddressInfo where = {VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO};
  where.buffer = buffer_.get();
  address_ = vk.vkGetBufferDeviceAddress(device.handle(), &where);
  device.name(VK_OBJECT_TYPE_BUFFER, reinterpret_cast<uint64_t>(buffer_.get()), name);
}

std::pair<int, uint64_t> Buffer::fd() const {
  VkMemoryGetFdInfoKHR info = {VK_STRUCTURE_TYPE_MEMORY_GET_FD_INFO_KHR};
  info.memory = memory_.memory();
  info.handleType = kExportedAs;
  int fd = -1;
  VK(device_->vk().vkGetMemoryFdKHR(device_->handle(), &info, &fd));
  return {fd, memory_.size()};
}

VkResult Buffer::take(const VkMemoryRequirements& requirements, uint32_t type, bool exported) {
  const bool visible = device_->isHostVisible(type);
  const AdoptedDevice* const adopted = device_->adopted();
  if (adopted && adopted->allocator.allocate) {
    const Allocation allocation = adopted->allocator.allocate(requirements, type);
    if (allocation.memory == VK_NULL_HANDLE) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
    memory_ = {adopted->allocator, allocation, requirements.size};
    if (visible && !allocation.mapped) return VK_ERROR_MEMORY_MAP_FAILED;
  } else {
    MemoryBlocks::Piece piece;
    MemoryBlocks& blocks = device_->blocks();
    const VkResult result = exported ? blocks.takeExported(requirements, type, visible, piece)
                                     : blocks.take(requirements, type, visible, piece);
    if (result != VK_SUCCESS) return result;
    memory_ = {blocks, piece};
  }
  mapped_ = visible ? memory_.mapped() : nullptr;
  return VK_SUCCESS;
}

void Buffer::need(VkResult result) const {
  if (result == VK_SUCCESS) return;
  const std::string text = "cannot allocate " + mebibytes(bytes_) + " for '" + name_ + "'; the device '" +
                           device_->capabilities().info.name + "' ";
  if (result == VK_ERROR_TOO_MANY_OBJECTS)
    throw Error(ErrorCode::outOfMemory, text + "allows " + std::to_string(device_->capabilities().mostAllocations) +
                                            " allocations, of which the simulators on it have " +
                                            std::to_string(device_->blocks().count()) + ", and others the rest");
  throw Error(ErrorCode::outOfMemory, text + "has " + mebibytes(device_->heapBytes()) + " in all");
}

VkMappedMemoryRange Buffer::mappedRange() const {
  VkMappedMemoryRange range = {VK_STRUCTURE_TYPE_MAPPED_MEMORY_RANGE};
  range.memory = memory_.memory();
  range.offset = memory_.offset();
  range.size = memory_.size();
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

}  // namespace gnosphere::vulkan
