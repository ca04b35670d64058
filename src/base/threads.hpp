// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <exception>
#include <new>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "gnosphere/error.hpp"

namespace gnosphere {

/// Number of threads that this machine runs at once, at least one. Cached, because the C library opens a file for it.
inline unsigned threadCount() {
  static const unsigned count = std::max(1u, std::thread::hardware_concurrency());
  return count;
}

/// Returns the message about threads that the system cannot start. `name` says what the threads do.
inline std::string noMoreThreads(const std::string& name, const std::system_error& error) {
  return name + " cannot be started (" + error.code().message() +
         "): end other programs, or raise the limits of processes and of memory (ulimit -u and -v, TasksMax of "
         "systemd, or pids and memory of the container)";
}

/// Starts a thread that its caller cannot do without. If the system cannot start it, throws an Error that says what the
/// thread does, which is `name`.
template <typename Work>
std::thread startThread(const std::string& name, Work work) {
  try {
    return std::thread(std::move(work));
  } catch (const std::system_error& error) {
    throw Error(ErrorCode::outOfMemory, noMoreThreads(name, error));
  }
}

/// Calls work(first, end) for 0..count - 1 in runs of `run`, on at most `threads` threads, the caller's among them.
/// Each thread takes the next run when it is done with one, because a thread may start late. If the system starts fewer
/// threads, those that run do all the work. If `work` throws, the other threads end after the runs that they are at,
/// and inRuns() throws the first exception after all threads have ended.
template <typename Work>
void inRuns(uint64_t count, uint64_t run, uint64_t threads, const Work& work) {
  std::atomic<uint64_t> next = 0;
  std::atomic<bool> failed = false;
  std::exception_ptr failure;  // written by the thread that sets `failed`, and read when all threads have ended
  const auto loop = [&]() noexcept {
    try {
      for (uint64_t first = next.fetch_add(run); first < count && !failed; first = next.fetch_add(run))
        work(first, std::min(count, first + run));
    } catch (...) {
      if (!failed.exchange(true)) failure = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> others;
    try {
      for (uint64_t k = 1; k < threads && k * run < count; ++k) others.emplace_back(loop);
    } catch (const std::system_error&) {
    } catch (const std::bad_alloc&) {
    }
    loop();
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace gnosphere
