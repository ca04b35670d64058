// SPDX-License-Identifier: Apache-2.0
#include <dlfcn.h>
#include <fcntl.h>
#include <fnmatch.h>
#include <locale.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <initializer_list>
#include <thread>

#include "base/os.hpp"
#include "base/unfinished.hpp"

namespace gnosphere::os {
namespace {

UnfinishedFiles unfinished;

/// The handler of signals that end the program. The system calls the handler once, and the signal that it raises then
/// has the usual effect.
void removeAndEnd(int signal) {
  unfinished.removeAll([](const char* name) { ::unlink(name); });
  ::raise(signal);
}

}  // namespace

std::FILE* openFile(const std::filesystem::path& file, const char* mode) {
  return std::fopen(file.c_str(), mode);
}

// O_NONBLOCK keeps a pipe without a reader from waiting for one.
std::FILE* openPart(const std::filesystem::path& file, bool isEmpty) {
  const int opened = ::open(
      file.c_str(), O_CREAT | O_WRONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC | (isEmpty ? O_TRUNC : O_APPEND), 0666);
  if (opened < 0) return nullptr;
  struct stat what;
  const bool isFile = ::fstat(opened, &what) == 0 && S_ISREG(what.st_mode);
  if (!isFile) errno = ENXIO;
  std::FILE* stream = isFile ? ::fdopen(opened, isEmpty ? "wb" : "ab") : nullptr;
  if (!stream) {
    const int reason = errno;
    ::close(opened);
    errno = reason;
  }
  return stream;
}

void copyPermissions(const std::filesystem::path& file, std::FILE* to) {
  struct stat what;
  if (::stat(file.c_str(), &what) == 0) (void)!::fchmod(::fileno(to), what.st_mode & 0777);
}

bool isWritable(const std::filesystem::path& file) {
  return ::access(file.c_str(), W_OK) == 0;
}

bool renameFile(const std::filesystem::path& file, const std::filesystem::path& name) {
  return std::rename(file.c_str(), name.c_str()) == 0;
}

void removeFile(const std::filesystem::path& file) {
  ::unlink(file.c_str());
}

int addUnfinished(const std::filesystem::path& file) {
  return unfinished.add(file);
}

void dropUnfinished(int place) {
  unfinished.drop(place);
}

void removeUnfinishedAtEnd() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction action = {};
    if (::sigaction(signal, nullptr, &action) != 0 || (action.sa_flags & SA_SIGINFO) || action.sa_handler != SIG_DFL)
      continue;
    action.sa_handler = removeAndEnd;
    action.sa_flags = SA_RESETHAND;
    ::sigfillset(&action.sa_mask);
    ::sigaction(signal, &action, nullptr);
  }
}

std::string reasonText(int reason) {
  return std::strerror(reason);
}

// File systems that cannot promise this, and pipes and devices, say so by EINVAL or ENOTSUP.
bool synchronise(std::FILE* stream) {
  return ::fsync(::fileno(stream)) == 0 || errno == EINVAL || errno == ENOTSUP;
}

Descriptor openForLock(const std::filesystem::path& file, bool mustBeNew) {
  return ::open(file.c_str(), O_CREAT | (mustBeNew ? O_EXCL : 0) | O_RDWR | O_NOFOLLOW | O_CLOEXEC, 0666);
}

Descriptor descriptorOf(std::FILE* stream) {
  return ::fcntl(::fileno(stream), F_DUPFD_CLOEXEC, 0);
}

// Other machines respect the lock, too, if the file system can.
Lock lockFile(Descriptor file, bool wait) {
  int failed = 0;
  do failed = ::flock(file, wait ? LOCK_EX : LOCK_EX | LOCK_NB);
  while (failed && errno == EINTR);  // a signal that a handler has taken
  if (!failed) return Lock::taken;
  return errno == EWOULDBLOCK ? Lock::busy : Lock::absent;
}

bool isNamed(Descriptor opened, const std::filesystem::path& file) {
  struct stat one, named;
  return ::fstat(opened, &one) == 0 && ::lstat(file.c_str(), &named) == 0 && one.st_ino == named.st_ino &&
         one.st_dev == named.st_dev;
}

bool makeEmpty(Descriptor file) {
  return ::ftruncate(file, 0) == 0;
}

void closeFile(Descriptor file) {
  ::close(file);
}

// By the XDG base directory specification, relative paths in the environment count as unset.
std::filesystem::path cacheFolder() {
  const auto absolute = [](const char* variable) {
    const char* value = std::getenv(variable);
    const std::filesystem::path path(value ? value : "");
    return path.is_absolute() ? path : std::filesystem::path();
  };
  if (const auto folder = absolute("XDG_CACHE_HOME"); !folder.empty()) return folder;
  if (const auto home = absolute("HOME"); !home.empty()) return home / ".cache";
  return {};
}

bool fits(const std::string& pattern, const std::string& name) {
  return ::fnmatch(pattern.c_str(), name.c_str(), 0) == 0;
}

Locale useClassicLocale() {
  static const locale_t kClassic = ::newlocale(LC_ALL_MASK, "C", nullptr);
  return ::uselocale(kClassic);
}

void useLocale(Locale locale) {
  ::uselocale(static_cast<locale_t>(locale));
}

unsigned processorCount() {
  cpu_set_t processors;
  if (::sched_getaffinity(0, sizeof processors, &processors) != 0)  // there are more than a set has
    return std::max(1u, std::thread::hardware_concurrency());
  return static_cast<unsigned>(CPU_COUNT(&processors));
}

void withoutSignals(const std::function<void()>& start) {
  sigset_t blocked, before;
  ::sigfillset(&blocked);
  for (const int fault : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTRAP, SIGSYS}) ::sigdelset(&blocked, fault);
  ::pthread_sigmask(SIG_BLOCK, &blocked, &before);
  try {
    start();
  } catch (...) {
    ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
    throw;
  }
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

void nameThread(const char* name) {
  ::pthread_setname_np(::pthread_self(), name);
}

std::string machineName() {
  char name[256] = {};
  ::gethostname(name, sizeof(name) - 1);
  return name;
}

uint32_t processNumber() {
  return static_cast<uint32_t>(::getpid());
}

void atFork(void (*before)(), void (*after)()) {
  ::pthread_atfork(before, after, after);
}

// AddressSanitizer calls dlopen() itself, which then does not search where the RUNPATH of this library says; so a
// library of ours is also looked for beside this one. The sanitizers end a process that asks for symbols of its own.
// Not every system can be asked: with musl, as on Alpine, a library shares them in any case.
void* openLibrary(const std::string& file, [[maybe_unused]] bool ownSymbols) {
  int flags = RTLD_NOW | RTLD_LOCAL;
#ifdef RTLD_DEEPBIND
  if (ownSymbols && !::dlsym(RTLD_DEFAULT, "__asan_init") && !::dlsym(RTLD_DEFAULT, "__tsan_init"))
    flags |= RTLD_DEEPBIND;
#endif
  void* const library = ::dlopen(file.c_str(), flags);
  Dl_info self;
  if (library || !ownSymbols || !::dladdr(reinterpret_cast<const void*>(&openLibrary), &self)) return library;
  return ::dlopen((std::filesystem::path(self.dli_fname).parent_path() / file).c_str(), flags);
}

std::string libraryProblem() {
  const char* why = ::dlerror();
  return why ? why : "the system gives no reason";
}

void* symbolOf(void* library, const char* name) {
  return ::dlsym(library, name);
}

std::vector<std::string> vulkanLoaders() {
  return {"libvulkan.so.1", "libvulkan.so"};
}

const char* vulkanAdvice() {
  return "apt install mesa-vulkan-drivers brings one that runs on the CPU";
}

bool isTerminal(std::FILE* stream) {
  return ::isatty(::fileno(stream)) == 1;
}

unsigned terminalColumns(std::FILE* stream) {
  winsize size = {};
  return ::ioctl(::fileno(stream), TIOCGWINSZ, &size) == 0 ? size.ws_col : 0;
}

// A file that the program or a driver opens must not get the number of a standard stream that is closed: what is
// printed would be written to that file. A stream that was closed still fails.
void prepareProgram(int&, char**&) {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (::fcntl(stream, F_GETFD) == -1) ::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
}

}  // namespace gnosphere::os
