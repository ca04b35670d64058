// SPDX-License-Identifier: Apache-2.0
#include "hooked_files.hpp"

#include <fcntl.h>
#include <stdio.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>

namespace gnosphere::test {

std::function<int()> beforeLock;
std::function<int(const std::string&)> beforeRename, beforeMkdir;

namespace {

/// Calls a hook, if there is one. Returns whether the call fails, with its reason in errno.
template <class Hook, class... Names>
bool fails(const Hook& hook, const Names&... names) {
  const int reason = hook ? hook(names...) : 0;
  if (reason != 0) errno = reason;
  return reason != 0;
}

}  // namespace
}  // namespace gnosphere::test

// In place of the functions of the C library.
extern "C" {

int flock(int file, int operation) noexcept {
  using namespace gnosphere::test;
  return fails(beforeLock) ? -1 : static_cast<int>(::syscall(SYS_flock, file, operation));
}

int rename(const char* from, const char* to) noexcept {
  using namespace gnosphere::test;
  return fails(beforeRename, to) ? -1 : ::renameat(AT_FDCWD, from, AT_FDCWD, to);
}

int mkdir(const char* name, mode_t mode) noexcept {
  using namespace gnosphere::test;
  return fails(beforeMkdir, name) ? -1 : ::mkdirat(AT_FDCWD, name, mode);
}
}
