// SPDX-License-Identifier: Apache-2.0
// A lock on a file, by which processes of one machine know of each other.
#pragma once

#include <cerrno>
#include <filesystem>

#include "base/os.hpp"

namespace gnosphere::drive {

/// Holds a lock on a file. The system releases it when the process ends, however it ends.
class FileLock {
 public:
  enum class If { free, waited, made };

  /// Takes the lock if it is free, or waits for it, or makes the file, which must not be there.
  FileLock(const std::filesystem::path& file, If taken) : descriptor_(os::openForLock(file, taken == If::made)) {
    if (descriptor_ < 0)
      lost_ = errno == EEXIST;
    else if (const os::Lock lock = os::lockFile(descriptor_, taken == If::waited); lock != os::Lock::taken)
      lost_ = lock == os::Lock::busy;
    else
      lost_ = !(holds_ = os::isNamed(descriptor_, file));
  }
  ~FileLock() {
    if (descriptor_ >= 0) os::closeFile(descriptor_);
  }
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;
  bool holds() const { return holds_; }
  /// Whether another process has the lock, rather than that there is none, for example in a read-only folder.
  bool lost() const { return lost_; }

 private:
  os::Descriptor descriptor_;
  bool holds_ = false, lost_ = false;
};

}  // namespace gnosphere::drive
