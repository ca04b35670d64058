// SPDX-License-Identifier: Apache-2.0
// Times in nanoseconds as whole seconds and a rest, as ROS, OSI and calendars have them.
#pragma once

#include <cstdint>

namespace gnosphere {

struct SplitTime {
  int64_t seconds;       ///< rounded down, also before 0
  uint32_t nanoseconds;  ///< 0 to 999,999,999 after these seconds
};

constexpr SplitTime splitNanoseconds(int64_t time) {
  constexpr int64_t kSecond = 1'000'000'000;
  const int64_t rest = time % kSecond;
  if (rest < 0) return {time / kSecond - 1, static_cast<uint32_t>(rest + kSecond)};
  return {time / kSecond, static_cast<uint32_t>(rest)};
}

}  // namespace gnosphere
