// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "base/os.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere {

/// The process that has made an object. A process that was forked from it has none of the threads that work for the
/// object, so it can neither use nor destroy the object.
class MakerProcess {
 public:
  /// Whether this process was forked from the one that has made the object.
  bool isParent() const { return process_ != os::processNumber(); }
  /// Throws Error(invalidArgument) if this process was forked. The object is a simulator, or belongs to one.
  void check() const {
    if (isParent())
      throw Error(ErrorCode::invalidArgument,
                  "the simulator was made by another process, whose threads this one does not have; make a simulator "
                  "after the fork, or start processes with 'spawn'");
  }

 private:
  uint32_t process_ = os::processNumber();
};

/// Gives up an object, without destroying it, whose maker() is the parent of this process.
template <class T>
void leaveToParent(std::unique_ptr<T>& object) {
  if (object && object->maker().isParent()) static_cast<void>(object.release());
}

/// Returns an object for a call of it, after MakerProcess::check(). Throws Error(invalidArgument), too, if the object
/// has been moved elsewhere.
template <class T>
T& ofThisProcess(const std::unique_ptr<T>& object) {
  if (!object)
    throw Error(ErrorCode::invalidArgument,
                "the simulator, or what belongs to one, was moved to another variable; use that one");
  object->maker().check();
  return *object;
}

}  // namespace gnosphere
