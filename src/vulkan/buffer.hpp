// SPDX-License-Identifier: Apache-2.0
// A storage buffer with its own memory.
#pragma once

#include <span>
#include <string>
#include <utility>

#include "pipeline/device_memory.hpp"
#include "vulkan/device.hpp"

namespace gnosphere::vulkan {

/// Most bytes of a staging buffer. An upload that needs more, such as that of a scene, has several, and the next
/// recording keeps one of them.
inline constexpr uint64_t kMostStagingBytes = 16 << 20;

/// Throws Error(outOfMemory) if one buffer of this size is larger than `most` bytes.
void refuseLarger(const Device& device, const char* name, uint64_t bytes, uint64_t most);

class Buffer {
 public:
  Buffer() = default;
  /// `name` is used in plans and messages ("cannot allocate 96.0 MiB for 'points'") and must outlive the buffer.
  Buffer(const Device& device, const char* name, uint64_t bytes, MemoryKind kind);
  /// A buffer in the host's memory from which, or with `read` to which, the device copies. Memory of the device that
  /// the host may write is scarce on some cards, and not for this.
  static Buffer staging(const Device& device, uint64_t bytes, bool read);
  /// A buffer of kind `device` in memory of its own, which fd() hands out if the device exports memory.
  static Buffer exported(const Device& device, const char* name, uint64_t bytes);

  VkBuffer handle() const { return buffer_.get(); }
  /// Address by which shaders access the buffer.
  VkDeviceAddress address() const { return address_; }
  uint64_t bytes() const { return bytes_; }
  const char* name() const { return name_; }
  /// Returns the host address; null if the host cannot access the memory.
  void* mapped() const { return mapped_; }
  /// Returns a new file descriptor of the memory, in which the buffer begins at 0, and the size of the memory. Only for
  /// a buffer of exported() on a device that exports memory.
  std::pair<int, uint64_t> fd() const;
  /// Makes device writes visible to the host, if the memory is not coherent.
  void invalidate() const;
  /// Makes host writes visible to the device.
  void flush() const;

 private:
  /// Holds memory from the caller's allocator or from the device's blocks, and returns it in the destructor.
  class Taken {
   public:
    Taken() = default;
    Taken(const Allocator& from, const Allocation& allocation, VkDeviceSize size)
        : from_(&from),
          allocation_(allocation),
          piece_{allocation.memory, allocation.offset, size, static_cast<std::byte*>(allocation.mapped)} {}
    Taken(MemoryBlocks& blocks, const MemoryBlocks::Piece& piece) : blocks_(&blocks), piece_(piece) {}
    ~Taken() {
      if (from_) from_->release(allocation_);
      if (blocks_) blocks_->giveBack(piece_);
    }
    Taken(Taken&& other) noexcept { swap(other); }
    Taken& operator=(Taken&& other) noexcept {
      Taken(std::move(other)).swap(*this);
      return *this;
    }
    VkDeviceMemory memory() const { return piece_.memory; }
    VkDeviceSize offset() const { return piece_.offset; }
    VkDeviceSize size() const { return piece_.size; }
    void* mapped() const { return piece_.mapped; }

   private:
    void swap(Taken& other) noexcept {
      std::swap(from_, other.from_);
      std::swap(allocation_, other.allocation_);
      std::swap(blocks_, other.blocks_);
      std::swap(piece_, other.piece_);
    }
    const Allocator* from_ = nullptr;
    Allocation allocation_;
    MemoryBlocks* blocks_ = nullptr;
    MemoryBlocks::Piece piece_;
  };

  enum class Place { any, host, exported };
  Buffer(const Device& device, const char* name, uint64_t bytes, std::span<const VkMemoryPropertyFlags> wanted,
         Place place);
  VkResult take(const VkMemoryRequirements& requirements, uint32_t type, bool exported);
  void need(VkResult result) const;
  VkMappedMemoryRange mappedRange() const;

  const Device* device_ = nullptr;
  Taken memory_;
  DeviceHandle<VkBuffer> buffer_;
  VkDeviceAddress address_ = 0;
  void* mapped_ = nullptr;
  bool coherent_ = true;
  uint64_t bytes_ = 0;
  const char* name_ = "";
};

}  // namespace gnosphere::vulkan
