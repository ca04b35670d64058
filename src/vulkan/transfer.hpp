// SPDX-License-Identifier: Apache-2.0
// Copies between the host and device buffers that the device does not use.
#pragma once

#include <span>

#include "vulkan/buffer.hpp"
#include "vulkan/commands.hpp"

namespace gnosphere::vulkan {

/// Copies through a staging buffer, with one submission per 16 MiB, or per `mostBytes` if that is less.
class Transfer {
 public:
  Transfer(const Device& device, uint64_t mostBytes);

  /// Allocates what write() to this buffer needs.
  void prepareWrite(const Buffer& buffer) {
    if (!buffer.mapped()) staging(false);
  }
  void write(Buffer& buffer, uint64_t place, std::span<const std::byte> data);
  void read(const Buffer& buffer, uint64_t place, std::span<std::byte> data);
  /// Copies the first bytes of a buffer to another one, on the device.
  void copy(const Buffer& from, const Buffer& to, uint64_t bytes);

 private:
  Buffer& staging(bool read);
  void copy(const Buffer& from, const Buffer& to, const VkBufferCopy& region);

  const Device& device_;
  uint64_t mostBytes_;
  Buffer written_, read_;  // made at their first use
  Commands commands_;      // the last member, because it waits for copies that use the buffers
};

}  // namespace gnosphere::vulkan
