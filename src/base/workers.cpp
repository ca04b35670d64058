// SPDX-License-Identifier: Apache-2.0
#include "base/workers.hpp"

namespace gnosphere {

Workers::~Workers() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  wanted_.notify_all();
  threads_.clear();  // the destructor of a std::jthread waits for its end
}

// Calls `work` on this thread and on at most `others` more. A thread that wakes after this one is done takes no part.
void Workers::together(uint64_t others, const std::function<void()>& work) {
  try {
    threads_.reserve(others);  // a thread that has begun always finds its place
    while (threads_.size() < others) threads_.push_back(newThread([this] { takeWork(); }));
  } catch (const std::system_error&) {
  } catch (const std::bad_alloc&) {
  }
  {
    const std::lock_guard lock(mutex_);
    work_ = &work;
    toTake_ = others;
  }
  for (uint64_t k = 0; k < others; ++k) wanted_.notify_one();
  work();
  std::unique_lock lock(mutex_);
  toTake_ = 0;
  done_.wait(lock, [&] { return atWork_ == 0; });
}

void Workers::takeWork() {
  std::unique_lock lock(mutex_);
  while (true) {
    wanted_.wait(lock, [&] { return ends_ || toTake_ > 0; });
    if (ends_) return;
    --toTake_;
    ++atWork_;
    const std::function<void()>& work = *work_;
    lock.unlock();
    work();
    lock.lock();
    if (--atWork_ == 0) done_.notify_one();
  }
}

}  // namespace gnosphere
