// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <unistd.h>

namespace gnosphere {

/// The process that has made an object. A process that was forked from it has none of the threads that work for the
/// object, so it can neither use nor destroy the object.
class MakerProcess {
 public:
  /// Whether this process was forked from the one that has made the object.
  bool isParent() const { return process_ != getpid(); }

 private:
  pid_t process_ = getpid();
};

}  // namespace gnosphere
