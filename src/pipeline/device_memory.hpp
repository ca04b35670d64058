// SPDX-License-Identifier: Apache-2.0
// Interface to the memory of a device.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace gnosphere {

enum class MemoryKind {
  device,    ///< fast for kernels; the host may write() and read() it while the device does not use it
  upload,    ///< the host writes it at host(), then calls flush(); kernels read it
  readback,  ///< kernels write it; the host reads it at host() after a scan, and after invalidate()
};

class DeviceMemory {
 public:
  virtual ~DeviceMemory() = default;
  virtual uint64_t bytes() const = 0;
  /// Address by which kernels access the memory.
  virtual uint64_t address() const = 0;
  /// Host address; only for `upload` and `readback`.
  virtual void* host() = 0;
  virtual void flush() = 0;
  virtual void invalidate() = 0;
  /// Allocates what write() of these bytes to memory of the kind `device` needs.
  virtual void prepareWrite(uint64_t /*place*/, uint64_t /*bytes*/) {}
  /// Copies to and from memory of the kind `device`; `place` is an offset in bytes.
  virtual void write(uint64_t place, std::span<const std::byte> data) = 0;
  virtual void read(uint64_t place, std::span<std::byte> data) const = 0;
  /// Copies the first bytes of other memory of the same device and of the kind `device`.
  virtual void copyFrom(const DeviceMemory& other, uint64_t bytes) {
    std::vector<std::byte> part(std::min<uint64_t>(bytes, 16 << 20));
    for (uint64_t place = 0; place < bytes; place += part.size()) {
      const std::span run = std::span(part).first(std::min<uint64_t>(part.size(), bytes - place));
      other.read(place, run);
      write(place, run);
    }
  }
};

}  // namespace gnosphere
