// SPDX-License-Identifier: Apache-2.0
// Memory of a device, as the pipeline sees it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace gnosphere {

enum class MemoryKind {
  device,    ///< fast for kernels; the host writes and reads it while the device does not use it
  upload,    ///< the host writes it at host(), then calls flush(); kernels read it
  readback,  ///< kernels write it; the host reads it at host() after a scan, and after invalidate()
};

class DeviceMemory {
 public:
  virtual ~DeviceMemory() = default;
  virtual uint64_t bytes() const = 0;
  /// What kernels find it by.
  virtual uint64_t address() const = 0;
  /// Of upload and readback.
  virtual void* host() = 0;
  virtual void flush() = 0;
  virtual void invalidate() = 0;
  /// Of device, `place` in bytes.
  virtual void write(uint64_t place, std::span<const std::byte> data) = 0;
  virtual void read(uint64_t place, std::span<std::byte> data) const = 0;
};

}  // namespace gnosphere
