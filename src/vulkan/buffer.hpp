// SPDX-License-Identifier: Apache-2.0
// A storage buffer with memory of its own.
#pragma once

#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "vulkan/device.hpp"

namespace gnosphere::vulkan {

enum class Memory {
  device,    ///< fast for shaders
  upload,    ///< written by the host, read once or rarely by shaders
  readback,  ///< read by the host
};

class Buffer {
 public:
  Buffer() = default;
  /// `name` must outlive it; it is for plans and messages: "cannot allocate 96.0 MiB for 'points'".
  Buffer(const Device& device, const char* name, uint64_t bytes, Memory memory);

  VkBuffer handle() const { return buffer_.get(); }
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
  void* mapped_ = nullptr;
  bool coherent_ = true;
  uint64_t bytes_ = 0;
  const char* name_ = "";
};

/// Copies between host and device buffers that the device does not use meanwhile: one staging buffer, one submission
/// per 16 MiB.
class Uploader {
 public:
  explicit Uploader(const Device& device);

  /// A new buffer with the data.
  template <typename T>
  Buffer upload(const char* name, std::span<const T> data) {
    Buffer buffer(device_, name, data.size_bytes(), Memory::device);
    write(data, buffer, 0);
    return buffer;
  }
  /// Data to a part of a buffer, from its `first`-th element on.
  template <typename T>
  void write(std::span<const T> data, Buffer& buffer, size_t first) {
    writeBytes(data.data(), buffer, first * sizeof(T), data.size_bytes());
  }
  /// A part of a buffer.
  template <typename T>
  std::vector<T> read(const Buffer& buffer, size_t first, size_t count) {
    std::vector<T> data(count);
    readBytes(buffer, first * sizeof(T), count * sizeof(T), data.data());
    return data;
  }

 private:
  void writeBytes(const void* data, Buffer& buffer, uint64_t offset, uint64_t bytes);
  void readBytes(const Buffer& buffer, uint64_t offset, uint64_t bytes, void* data);
  uint64_t stage(Memory memory);
  void copy(VkBuffer from, VkBuffer to, const VkBufferCopy& region);

  const Device& device_;
  DeviceHandle<VkCommandPool> pool_;
  Buffer staging_;
  Memory stagingKind_ = Memory::upload;
};

}  // namespace gnosphere::vulkan
