// SPDX-License-Identifier: Apache-2.0
#include "vulkan/transfer.hpp"

#include <algorithm>
#include <cstring>

namespace gnosphere::vulkan {

Transfer::Transfer(const Device& device, uint64_t mostBytes)
    : device_(device), mostBytes_(std::min(mostBytes, kMostStagingBytes)), commands_(device) {}

void Transfer::write(Buffer& buffer, uint64_t place, std::span<const std::byte> data) {
  if (data.empty()) return;
  if (buffer.mapped()) {
    std::memcpy(static_cast<std::byte*>(buffer.mapped()) + place, data.data(), data.size());
    buffer.flush();
    return;
  }
  Buffer& staging = this->staging(false);
  for (uint64_t done = 0; done < data.size(); done += staging.bytes()) {
    const uint64_t size = std::min(data.size() - done, staging.bytes());
    std::memcpy(staging.mapped(), data.data() + done, size);
    staging.flush();
    copy(staging, buffer, {0, place + done, size});
  }
}

void Transfer::read(const Buffer& buffer, uint64_t place, std::span<std::byte> data) {
  if (data.empty()) return;
  if (buffer.mapped()) {
    buffer.invalidate();
    std::memcpy(data.data(), static_cast<const std::byte*>(buffer.mapped()) + place, data.size());
    return;
  }
  Buffer& staging = this->staging(true);
  for (uint64_t done = 0; done < data.size(); done += staging.bytes()) {
    const uint64_t size = std::min(data.size() - done, staging.bytes());
    copy(buffer, staging, {place + done, 0, size});
    staging.invalidate();
    std::memcpy(data.data() + done, staging.mapped(), size);
  }
}

Buffer& Transfer::staging(bool read) {
  Buffer& buffer = read ? read_ : written_;
  if (!buffer.handle()) buffer = Buffer::staging(device_, mostBytes_, read);
  return buffer;
}

void Transfer::copy(const Buffer& from, const Buffer& to, uint64_t bytes) {
  if (bytes > 0) copy(from, to, {0, 0, bytes});
}

void Transfer::copy(const Buffer& from, const Buffer& to, const VkBufferCopy& region) {
  commands_.begin(0);
  commands_.buffer().copy(from, to, region);
  commands_.buffer().barrier();  // a signalled fence alone does not let the host see what the device has written
  commands_.submit();
  commands_.wait();
}

}  // namespace gnosphere::vulkan
