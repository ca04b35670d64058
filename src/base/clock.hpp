// SPDX-License-Identifier: Apache-2.0
// How much time has passed.
#pragma once

#include <chrono>

namespace gnosphere {

using Clock = std::chrono::steady_clock;

inline double millisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

}  // namespace gnosphere
