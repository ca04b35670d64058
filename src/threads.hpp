// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <thread>

namespace gnosphere {

/// Threads that this machine runs at once, at least one. Asked once: the C library opens a file for it.
inline unsigned threadCount() {
  static const unsigned count = std::max(1u, std::thread::hardware_concurrency());
  return count;
}

}  // namespace gnosphere
