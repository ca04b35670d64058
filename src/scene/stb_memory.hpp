// SPDX-License-Identifier: Apache-2.0
// The memory of stb_image, which unpacks all data of an image, however small the image is.
#pragma once

#include <cstddef>
#include <cstdlib>

namespace gnosphere {

/// The memory that stb_image may allocate in this thread.
struct StbMemory {
  size_t mostBytes = static_cast<size_t>(-1);  ///< of one array
  bool wasRefused = false;                     ///< whether it has asked for more
};
inline thread_local StbMemory stbMemory;

inline void* stbReallocate(void* array, size_t bytes) {
  if (bytes <= stbMemory.mostBytes) return std::realloc(array, bytes);
  stbMemory.wasRefused = true;
  return nullptr;
}

}  // namespace gnosphere
