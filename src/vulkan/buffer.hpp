// SPDX-License-Identifier: Apache-2.0
// A storage buffer with memory of its own.
#pragma once

#include <cstring>
#include <span>
#include <string>

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
  /// `name` is for messages: "cannot allocate 96.0 MiB for 'points'".
  Buffer(const Device& device, const char* name, uint64_t bytes, Memory memory);
  ~Buffer() { destroy(); }
  Buffer(Buffer&& other) noexcept { swap(other); }
  Buffer& operator=(Buffer&& other) noexcept {
    swap(other);
    return *this;
  }

  VkBuffer handle() const { return buffer_; }
  uint64_t bytes() const { return bytes_; }
  /// Host address; null for device memory that the host cannot see.
  void* mapped() const { return mapped_; }
  /// Makes device writes visible to the host, where memory is not coherent.
  void invalidate() const;
  /// Makes host writes visible to the device.
  void flush() const;

 private:
  void swap(Buffer& other) noexcept;
  void destroy();

  VkDevice device_ = VK_NULL_HANDLE;
  VkBuffer buffer_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  void* mapped_ = nullptr;
  bool coherent_ = true;
  uint64_t bytes_ = 0;
};

/// Copies host data into new device buffers: one staging buffer, one submission per upload.
class Uploader {
 public:
  explicit Uploader(const Device& device);
  ~Uploader();
  Uploader(const Uploader&) = delete;
  Uploader& operator=(const Uploader&) = delete;

  template <typename T>
  Buffer upload(const char* name, std::span<const T> data) {
    return uploadBytes(name, data.data(), data.size_bytes());
  }

 private:
  Buffer uploadBytes(const char* name, const void* data, uint64_t bytes);

  const Device& device_;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  Buffer staging_;
};

}  // namespace gnosphere::vulkan
