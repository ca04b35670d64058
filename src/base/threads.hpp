// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <system_error>
#include <thread>
#include <vector>

namespace gnosphere {

/// Number of threads that this machine runs at once, at least one. Cached, because the C library opens a file for it.
inline unsigned threadCount() {
  static const unsigned count = std::max(1u, std::thread::hardware_concurrency());
  return count;
}

/// Calls work(first, end) for 0..count - 1 in runs of `run`, on at most `threads` threads, the caller's among them.
/// Each thread takes the next run when it is done with one, because a thread may start late. If the system starts fewer
/// threads, those that run do all the work.
template <typename Work>
void inRuns(uint64_t count, uint64_t run, uint64_t threads, const Work& work) {
  std::atomic<uint64_t> next = 0;
  const auto loop = [&] {
    for (uint64_t first = next.fetch_add(run); first < count; first = next.fetch_add(run))
      work(first, std::min(count, first + run));
  };
  std::vector<std::jthread> others;
  try {
    for (uint64_t k = 1; k < threads && k * run < count; ++k) others.emplace_back(loop);
  } catch (const std::system_error&) {
  }
  loop();
}

}  // namespace gnosphere
