// SPDX-License-Identifier: Apache-2.0
// A storage buffer with its own memory, and copies between it and the host.
#pragma once

#include <span>
#include <string>
#include <utility>

#include "pipeline/device_memory.hpp"
#include "vulkan/device.hpp"

namespace gnosphere::vulkan {

class Buffer {
 public:
  Buffer() = default;
  /// `name` is used in plans and messages ("cannot allocate 96.0 MiB for 'points'") and must outlive the buffer.
  Buffer(const Device& device, const char* name, uint64_t bytes, MemoryKind kind);

  VkBuffer handle() const { return buffer_.get(); }
  /// Address by which shaders access the buffer.
  VkDeviceAddress address() const { return address_; }
  uint64_t bytes() const { return bytes_; }
  const char* name() const { return name_; }
  /// Returns the host address; null if the host cannot access the memory.
  void* mapped() const { return mapped_; }
  /// Makes device writes visible to the host, if the memory is not coherent.
  void invalidate() const;
  /// Makes host writes visible to the device.
  void flush() const;

 private:
  /// Memory from the caller's allocator, given back by the destructor.
  class Borrowed {
   public:
    Borrowed() = default;
    Borrowed(const Allocator& from, const Allocation& allocation) : from_(&from), allocation_(allocation) {}
    ~Borrowed() {
      if (from_) from_->release(allocation_);
    }
    Borrowed(Borrowed&& other) noexcept { swap(other); }
    Borrowed& operator=(Borrowed&& other) noexcept {
      Borrowed(std::move(other)).swap(*this);
      return *this;
    }

   private:
    void swap(Borrowed& other) noexcept {
      std::swap(from_, other.from_);
      std::swap(allocation_, other.allocation_);
    }
    const Allocator* from_ = nullptr;
    Allocation allocation_;
  };

  void allocate(const VkMemoryRequirements& requirements, int type);
  void borrow(const Allocator& from, const VkMemoryRequirements& requirements, int type);
  void need(bool succeeded) const;
  VkMappedMemoryRange mappedRange() const;

  const Device* device_ = nullptr;
  Borrowed borrowed_;
  DeviceHandle<VkDeviceMemory> memory_;
  VkDeviceMemory place_ = VK_NULL_HANDLE;  // the memory that the buffer is bound to, and where
  VkDeviceSize offset_ = 0;
  DeviceHandle<VkBuffer> buffer_;
  VkDeviceAddress address_ = 0;
  void* mapped_ = nullptr;
  bool coherent_ = true;
  uint64_t bytes_ = 0;
  const char* name_ = "";
};

/// Copies between the host and device buffers while the device does not use them, through a staging buffer with one
/// submission per 16 MiB.
class Transfer {
 public:
  explicit Transfer(const Device& device);

  /// Allocates what write() to this buffer needs.
  void prepareWrite(const Buffer& buffer) {
    if (!buffer.mapped()) stage(MemoryKind::upload);
  }
  void write(Buffer& buffer, uint64_t place, std::span<const std::byte> data);
  void read(const Buffer& buffer, uint64_t place, std::span<std::byte> data);

 private:
  uint64_t stage(MemoryKind kind);
  void copy(VkBuffer from, VkBuffer to, const VkBufferCopy& region);

  const Device& device_;
  DeviceHandle<VkCommandPool> pool_;
  Buffer staging_;
  MemoryKind stagingKind_ = MemoryKind::upload;
};

}  // namespace gnosphere::vulkan
