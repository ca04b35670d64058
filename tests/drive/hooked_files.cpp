// SPDX-License-Identifier: Apache-2.0
#include "hooked_files.hpp"

#include <sys/file.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>

namespace gnosphere::test {

std::function<int()> beforeLock;

}  // namespace gnosphere::test

// In place of the function of the C library.
extern "C" int flock(int file, int operation) noexcept {
  if (gnosphere::test::beforeLock)
    if (const int reason = gnosphere::test::beforeLock()) {
      errno = reason;
      return -1;
    }
  return static_cast<int>(::syscall(SYS_flock, file, operation));
}
