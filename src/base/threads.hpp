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

#include "base/os.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere {

/// Number of threads that the first thread to ask may run at once, at least one; later threads get the same number.
inline unsigned threadCount() {
  static const unsigned count = os::processorCount();
  return count;
}

/// Tells whether handlers of the program's signals run in a thread. A thread that calls functions of the program takes
/// signals, because such a function may raise a signal, or start a process, which inherits the thread's mask.
enum class Signals { blocked, taken };

/// Starts a thread of the library. Throws std::system_error if the system cannot start it.
template <typename Work>
std::jthread newThread(Work work, Signals signals = Signals::blocked) {
  std::jthread thread;
  const auto start = [&] {
    thread = std::jthread([work = std::move(work)]() mutable {
      os::nameThread("gnosphere");
      work();
    });
  };
  if (signals == Signals::blocked)
    os::withoutSignals(start);
  else
    start();
  return thread;
}

/// Returns the message about threads that the system cannot start. `name` says what the threads do.
inline std::string noMoreThreads(const std::string& name, const std::system_error& error) {
  return name + " cannot be started (" + error.code().message() +
         "): end other programs, or raise the limits of processes and of memory (on Linux ulimit -u and -v, "
         "TasksMax of systemd, or pids and memory of the container)";
}

/// Starts a thread that its caller cannot do without. If the system cannot start it, throws an Error that says what the
/// thread does, which is `name`.
template <typename Work>
std::jthread startThread(const std::string& name, Work work, Signals signals = Signals::blocked) {
  try {
    return newThread(std::move(work), signals);
  } catch (const std::system_error& error) {
    throw Error(ErrorCode::outOfMemory, noMoreThreads(name, error));
  }
}

/// The work that several threads share: work(first, end) for 0..count - 1 in runs of `run`. Each thread takes the next
/// run when it is done with one, because a thread may start late. If `work` throws, the threads end after the runs that
/// they are at.
template <typename Work>
class SharedRuns {
 public:
  SharedRuns(uint64_t count, uint64_t run, const Work& work) : count_(count), run_(run), work_(work) {}

  /// Takes runs until none is left. Each of the threads calls this once.
  void operator()() noexcept {
    try {
      for (uint64_t first = next_.fetch_add(run_); first < count_ && !failed_; first = next_.fetch_add(run_))
        work_(first, std::min(count_, first + run_));
    } catch (...) {
      if (!failed_.exchange(true)) failure_ = std::current_exception();
    }
  }

  /// Throws the first exception of `work`. All threads must have ended.
  void throwFailure() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  const uint64_t count_, run_;
  const Work& work_;
  std::atomic<uint64_t> next_ = 0;
  std::atomic<bool> failed_ = false;
  std::exception_ptr failure_;  // written by the thread that sets `failed_`
};

/// Calls work(first, end) for 0..count - 1 in runs of `run`, on at most `threads` threads, the caller's among them. If
/// the system starts fewer threads, the threads that run do all the work. If `work` throws, inRuns() throws the first
/// exception after all threads have ended.
template <typename Work>
void inRuns(uint64_t count, uint64_t run, uint64_t threads, const Work& work) {
  SharedRuns<Work> runs(count, run, work);
  {
    std::vector<std::jthread> others;
    try {
      for (uint64_t k = 1; k < threads && k * run < count; ++k) others.push_back(newThread([&] { runs(); }));
    } catch (const std::system_error&) {
    } catch (const std::bad_alloc&) {
    }
    runs();
  }
  runs.throwFailure();
}

}  // namespace gnosphere
