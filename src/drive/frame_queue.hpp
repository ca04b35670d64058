// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "base/threads.hpp"
#include "drive/record.hpp"

namespace gnosphere::drive {

/// Hands frames to a thread that writes them while the next ones are scanned. A frame that is written is used again, so
/// there are at most three.
class FrameQueue {
 public:
  explicit FrameQueue(std::function<void(FrameRecord&)> write) : write_(std::move(write)) {
    empty_.resize(3);
    // The thread calls RunOptions::progress, a function of the program.
    thread_ = startThread(
        "a drive: the thread that writes or publishes frames", [this] { loop(); }, Signals::taken);
  }
  /// Frames that wait are dropped.
  ~FrameQueue() {
    {
      const std::lock_guard lock(mutex_);
      waiting_.clear();
      ended_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
  }
  FrameQueue(const FrameQueue&) = delete;
  FrameQueue& operator=(const FrameQueue&) = delete;

  /// Fills the record of every frame by scan(record), and waits until all are written. Throws what writing has thrown.
  template <class Scan>
  void run(const std::vector<uint64_t>& frames, Scan scan) {
    for (const uint64_t frame : frames) {
      FrameRecord record = empty();
      record.frame = frame;
      scan(record);
      push(std::move(record));
    }
    finish();
  }

 private:
  /// Waits for a frame that can be filled. Throws what writing has thrown.
  FrameRecord empty() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return !empty_.empty() || failure_; });
    if (failure_) std::rethrow_exception(failure_);
    FrameRecord record = std::move(empty_.front());
    empty_.pop_front();
    return record;
  }

  void push(FrameRecord record) {
    {
      const std::lock_guard lock(mutex_);
      waiting_.push_back(std::move(record));
    }
    changed_.notify_all();
  }

  /// Waits until all frames are written. Throws what writing has thrown.
  void finish() {
    {
      const std::lock_guard lock(mutex_);
      ended_ = true;
    }
    changed_.notify_all();
    thread_.join();
    if (failure_) std::rethrow_exception(failure_);
  }

  void loop() {
    for (;;) {
      FrameRecord record;
      {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return !waiting_.empty() || ended_; });
        if (waiting_.empty()) return;
        record = std::move(waiting_.front());
        waiting_.pop_front();
      }
      try {
        write_(record);
        const std::lock_guard lock(mutex_);
        empty_.push_back(std::move(record));
        changed_.notify_all();
      } catch (...) {
        const std::lock_guard lock(mutex_);
        failure_ = std::current_exception();
        waiting_.clear();
        changed_.notify_all();
        return;
      }
    }
  }

  std::function<void(FrameRecord&)> write_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<FrameRecord> empty_, waiting_;
  bool ended_ = false;
  std::exception_ptr failure_;
  std::jthread thread_;
};

}  // namespace gnosphere::drive
