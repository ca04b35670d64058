// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "common/arrays.h"

namespace gnosphere {

/// Interface to the memory that holds the scene's arrays. Places and sizes are in bytes.
class SceneMemory {
 public:
  virtual ~SceneMemory() = default;
  /// Makes room for at least `bytes`; keeps the content.
  virtual void reserve(gpu::Array array, uint64_t bytes) = 0;
  /// Allocates what a write of these bytes needs, so that this write fails only if the device does. The last call for
  /// an array counts.
  virtual void prepareWrite(gpu::Array array, uint64_t place, uint64_t bytes) = 0;
  virtual void write(gpu::Array array, uint64_t place, std::span<const std::byte> data) = 0;
  virtual void read(gpu::Array array, uint64_t place, std::span<std::byte> data) const = 0;
};

}  // namespace gnosphere
