// SPDX-License-Identifier: Apache-2.0
#include "vulkan/memory_blocks.hpp"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <utility>

#include "vulkan/capabilities.hpp"

namespace gnosphere::vulkan {
namespace {

// Blocks of one type begin small, so that a small simulator takes little, and double. A larger piece has a block of
// its own.
constexpr VkDeviceSize kFirstBlock = 1 << 20, kLargestBlock = 32 << 20, kLargestShared = 4 << 20;

// Inserts a node of a map as a run; needs no memory.
template <typename Runs>
void insertRun(Runs& runs, typename Runs::node_type node, VkDeviceSize offset, VkDeviceSize size) {
  node.key() = offset;
  node.mapped() = size;
  runs.insert(std::move(node));
}

VkDeviceSize roundedUp(VkDeviceSize value, VkDeviceSize to) {
  return (value + to - 1) / to * to;
}

}  // namespace

VkResult MemoryBlocks::take(const VkMemoryRequirements& requirements, uint32_t type, bool visible, Piece& piece) {
  const VkDeviceSize size = roundedUp(requirements.size, kAlignment);
  const VkDeviceSize alignment = std::max(requirements.alignment, kAlignment);
  const bool shared = size <= kLargestShared;
  const std::lock_guard lock(mutex_);
  if (shared)
    for (const auto& block : blocks_)
      if (block->type == type && takeFrom(*block, size, alignment, piece)) return VK_SUCCESS;
  VkResult result = VK_ERROR_OUT_OF_DEVICE_MEMORY;
  if (shared) result = makeBlock(std::max(nextBlockSize(type), size), type, visible);
  if (result != VK_SUCCESS) result = makeBlock(size, type, visible);
  if (result == VK_SUCCESS) takeFrom(*blocks_.back(), size, alignment, piece);
  return result;
}

VkResult MemoryBlocks::takeExported(const VkMemoryRequirements& requirements, uint32_t type, bool visible,
                                    Piece& piece) {
  const VkDeviceSize size = roundedUp(requirements.size, kAlignment);
  const std::lock_guard lock(mutex_);
  const VkResult result = makeBlock(size, type, visible, true);
  if (result == VK_SUCCESS) takeFrom(*blocks_.back(), size, kAlignment, piece);
  return result;
}

void MemoryBlocks::giveBack(const Piece& piece) noexcept {
  const std::lock_guard lock(mutex_);
  const auto found = std::find_if(blocks_.begin(), blocks_.end(),
                                  [&](const auto& block) { return block->memory.get() == piece.memory; });
  if (found == blocks_.end()) return;
  Runs& free = (*found)->free;
  Runs::node_type run = (*found)->taken.extract(piece.offset);
  if (piece.size == (*found)->size) {
    blocks_.erase(found);
    return;
  }
  // Joins the run with the free ones before and behind it.
  VkDeviceSize offset = piece.offset, end = offset + piece.size;
  auto next = free.lower_bound(offset);
  if (next != free.end() && next->first == end) {
    end += next->second;
    next = free.erase(next);
  }
  if (next != free.begin()) {
    const auto before = std::prev(next);
    if (before->first + before->second == offset) {
      offset = before->first;
      free.erase(before);
    }
  }
  if (end - offset == (*found)->size)
    blocks_.erase(found);
  else
    insertRun(free, std::move(run), offset, end - offset);
}

VkResult MemoryBlocks::makeBlock(VkDeviceSize size, uint32_t type, bool visible, bool exported) {
  if (blocks_.size() >= most_) return VK_ERROR_TOO_MANY_OBJECTS;  // drivers need not notice
  const VkExportMemoryAllocateInfo exporting = {VK_STRUCTURE_TYPE_EXPORT_MEMORY_ALLOCATE_INFO, nullptr, kExportedAs};
  VkMemoryAllocateFlagsInfo flags = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO, exported ? &exporting : nullptr};
  flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
  VkMemoryAllocateInfo allocate = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, &flags};
  allocate.allocationSize = size;
  allocate.memoryTypeIndex = type;
  VkDeviceMemory memory = VK_NULL_HANDLE;
  VkResult result = vk_.vkAllocateMemory(device_, &allocate, nullptr, &memory);
  if (result != VK_SUCCESS) return result;
  auto block =
      std::make_unique<Block>(Block{{memory, vk_.vkFreeMemory, device_, &hangs_}, type, size, nullptr, {{0, size}}});
  if (visible) {
    void* mapped = nullptr;
    result = vk_.vkMapMemory(device_, memory, 0, VK_WHOLE_SIZE, 0, &mapped);
    // If the host has no memory left, Mesa's lavapipe reports success and maps to null or to MAP_FAILED (-1). Vulkan
    // guarantees that the address of mapped memory is a multiple of 64.
    if (result != VK_SUCCESS || !mapped || reinterpret_cast<uintptr_t>(mapped) % 64 != 0)
      return VK_ERROR_OUT_OF_HOST_MEMORY;
    block->mapped = static_cast<std::byte*>(mapped);
  }
  blocks_.push_back(std::move(block));
  return VK_SUCCESS;
}

bool MemoryBlocks::takeFrom(Block& block, VkDeviceSize size, VkDeviceSize alignment, Piece& piece) {
  for (auto run = block.free.begin(); run != block.free.end(); ++run) {
    const VkDeviceSize first = run->first, end = first + run->second, offset = roundedUp(first, alignment);
    if (offset + size > end) continue;
    const bool before = offset > first, behind = offset + size < end;
    Runs taken = {{offset, size}}, more;
    if (before && behind) more.emplace(0, 0);
    block.taken.insert(taken.extract(taken.begin()));
    Runs::node_type node = block.free.extract(run);
    if (before) {
      insertRun(block.free, std::move(node), first, offset - first);
      if (behind) node = more.extract(more.begin());
    }
    if (behind) insertRun(block.free, std::move(node), offset + size, end - offset - size);
    piece = {block.memory.get(), offset, size, block.mapped ? block.mapped + offset : nullptr};
    return true;
  }
  return false;
}

VkDeviceSize MemoryBlocks::nextBlockSize(uint32_t type) const {
  VkDeviceSize size = kFirstBlock;
  for (const auto& block : blocks_)
    if (block->type == type && size < kLargestBlock) size *= 2;
  return size;
}

}  // namespace gnosphere::vulkan
