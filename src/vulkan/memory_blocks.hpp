// SPDX-License-Identifier: Apache-2.0
// Device memory in blocks that several buffers share: a device allows only some thousand allocations.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "vulkan/functions.hpp"
#include "vulkan/handle.hpp"

namespace gnosphere::vulkan {

/// Several threads may use it at once.
class MemoryBlocks {
 public:
  /// A part of a block. Its size is a multiple of kAlignment, and so is its offset.
  struct Piece {
    VkDeviceMemory memory = VK_NULL_HANDLE;
    VkDeviceSize offset = 0, size = 0;
    std::byte* mapped = nullptr;  ///< null if the host cannot access the memory
  };

  /// The alignment that kernels and copies need, and at least the largest size of atoms that a device may have.
  static constexpr VkDeviceSize kAlignment = 256;

  /// `vk` and `hangs` must outlive the blocks, of which there are at most `most`.
  MemoryBlocks(VkDevice device, const DeviceFunctions& vk, uint32_t most, const HangCount& hangs)
      : device_(device), vk_(vk), most_(most), hangs_(hangs) {}
  MemoryBlocks(const MemoryBlocks&) = delete;
  MemoryBlocks& operator=(const MemoryBlocks&) = delete;

  /// Takes memory of a type, which the host maps if `visible`. If there is none left, `piece` stays as it is, and the
  /// result is the driver's.
  VkResult take(const VkMemoryRequirements& requirements, uint32_t type, bool visible, Piece& piece);
  /// As take(), for a block of its own that can be handed out as a file descriptor.
  VkResult takeExported(const VkMemoryRequirements& requirements, uint32_t type, bool visible, Piece& piece);
  /// A block is freed with its last piece.
  void giveBack(const Piece& piece) noexcept;
  /// Allocations of the device that are in use.
  size_t count() const {
    const std::lock_guard lock(mutex_);
    return blocks_.size();
  }

 private:
  using Runs = std::map<VkDeviceSize, VkDeviceSize>;  // size by offset
  struct Block {
    DeviceHandle<VkDeviceMemory> memory;
    uint32_t type;
    VkDeviceSize size;
    std::byte* mapped;
    Runs free;
    Runs taken = {};  // its nodes become those of free runs, so that giving back needs no memory
  };

  VkResult makeBlock(VkDeviceSize size, uint32_t type, bool visible, bool exported = false);
  bool takeFrom(Block& block, VkDeviceSize size, VkDeviceSize alignment, Piece& piece);
  VkDeviceSize nextBlockSize(uint32_t type) const;

  VkDevice device_;
  const DeviceFunctions& vk_;
  uint32_t most_;
  const HangCount& hangs_;
  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<Block>> blocks_;
};

}  // namespace gnosphere::vulkan
