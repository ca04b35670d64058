// SPDX-License-Identifier: Apache-2.0
// Calls of an object that one thread at a time may use.
#pragma once

#include <atomic>
#include <memory>
#include <thread>

#include "base/float_environment.hpp"
#include "base/maker_process.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere {

/// The process that has made an object, and the thread in which a call of it is at work.
struct CallState {
  const MakerProcess maker = {};
  std::atomic<std::thread::id> thread = {};  ///< of no thread if no call is at work
};

[[noreturn]] inline void refuseCall() {
  throw Error(ErrorCode::invalidArgument,
              "the simulator is at work: one thread at a time may use it, and a function that it calls may only read "
              "it; make a simulator for each thread");
}

/// A call that may change an object, which is at work while this lives, whatever the rounding mode and the
/// floating-point traps of the caller. Its class `T` has a function calls() that returns its CallState.
template <class T>
class Call {
 public:
  /// Throws Error(invalidArgument) as ofThisProcess() does, and if another call of the object is at work.
  explicit Call(const std::unique_ptr<T>& object) : object_(ofThisProcess(object)) {
    std::thread::id none;
    if (!object_.calls().thread.compare_exchange_strong(none, std::this_thread::get_id())) refuseCall();
  }
  ~Call() { object_.calls().thread = std::thread::id(); }
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;

  T* operator->() const { return &object_; }

 private:
  T& object_;
  const DefaultFloatEnvironment environment_;
};

/// Returns an object for a call that reads it. Throws Error(invalidArgument) as ofThisProcess() does, and if a call of
/// another thread is at work; functions that a call calls may read.
template <class T>
const T& forReading(const std::unique_ptr<T>& object) {
  T& checked = ofThisProcess(object);
  const std::thread::id thread = checked.calls().thread;
  if (thread != std::thread::id() && thread != std::this_thread::get_id()) refuseCall();
  return checked;
}

}  // namespace gnosphere
