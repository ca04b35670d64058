// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "base/threads.hpp"

namespace gnosphere {

/// Keeps threads, because to wake a thread takes a fraction of the time that it takes to start one, so these threads
/// can share work of a tenth of a millisecond. A thread starts when it is first wanted. One thread at a time may call
/// inRuns().
class Workers {
 public:
  Workers() = default;
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  /// Does the same as inRuns() of threads.hpp.
  template <typename Work>
  void inRuns(uint64_t count, uint64_t run, uint64_t threads, const Work& work) {
    SharedRuns<Work> runs(count, run, work);
    const uint64_t useful = std::min(threads, (count + run - 1) / run);
    if (useful > 1)
      together(useful - 1, [&] { runs(); });
    else
      runs();
    runs.throwFailure();
  }

 private:
  void together(uint64_t others, const std::function<void()>& work);
  void takeWork();

  std::mutex mutex_;
  std::condition_variable wanted_, done_;
  const std::function<void()>* work_ = nullptr;
  uint64_t toTake_ = 0, atWork_ = 0;  ///< threads that may still take part, and threads that do
  bool ends_ = false;
  std::vector<std::jthread> threads_;
};

}  // namespace gnosphere
