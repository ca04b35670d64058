// SPDX-License-Identifier: Apache-2.0
// A storage buffer with memory of its own.
#pragma once

#include <span>
#include <string>

#include "pipeline/device_memory.hpp"
#include "vulkan/device.hpp"

namespace gnosphere::vulkan {

class Buffer {
 public:
  Buffer() = default;
  /// `name` must outlive it; it is for plans and messages: "cannot allocate 96.0 MiB for 'points'".
  Buffer(const Device& device, const char* name, uint64_t bytes, MemoryKind kind);

  VkBuffer handle() const { return buffer_.get(); }
  /// What shaders find it by.
  VkDeviceAddress address() const { return address_; }
  uint64_t bytes() const { return bytes_; }
  const char* name() const { return name_; }
  /// Host address; null for device memory that the host cannot see.
  void* mapped() const { return mapped_; }
  /// Makes device writes visible to the host, where memory is not coherent.
  void invalidate() const;
  /// Makes host writes visible to the device.
  void flush() const;

 private:
  const Device* device_ = nullptr;
  DeviceHandle<VkDeviceMemory> memory_;
  DeviceHandle<VkBuffer> buffer_;
  VkDeviceAddress address_ = 0;
  void* mapped_ = nullptr;
  bool coherent_ = true;
  uint64_t bytes_ = 0;
  const char* name_ = "";
};

/// Copies between host and device buffers that the device does not use meanwhile: one staging buffer, one submission
/// per 16 MiB.
class Transfer {
 public:
  explicit Transfer(const Device& device);

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
