// SPDX-License-Identifier: Apache-2.0
#define NOMINMAX
#define WIN32_LEAN_AND_MEAN
#include <windows.h>
// windows.h is first, because shellapi.h needs its types.
#include <fcntl.h>
#include <io.h>
#include <locale.h>
#include <shellapi.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <regex>
#include <system_error>
#include <thread>

#include "base/os.hpp"
#include "base/path.hpp"

namespace gnosphere::os {
namespace {

/// Sets errno to the reason why a function of Windows has failed.
void noteReason() {
  const DWORD reason = GetLastError();
  errno = reason == ERROR_SHARING_VIOLATION
              ? EACCES
              : std::error_code(static_cast<int>(reason), std::system_category()).default_error_condition().value();
}

HANDLE handleOf(Descriptor file) {
  return reinterpret_cast<HANDLE>(_get_osfhandle(file));
}

std::string utf8(const wchar_t* text) {
  return std::filesystem::path(text).string();
}

/// The C library's functions open files that nobody else may rename or remove, so they are opened by Windows.
Descriptor openShared(const std::filesystem::path& file, DWORD access, DWORD disposition, int flags) {
  constexpr DWORD kShare = FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE;
  const HANDLE handle = CreateFileW(file.c_str(), access, kShare, nullptr, disposition, FILE_ATTRIBUTE_NORMAL, nullptr);
  if (handle == INVALID_HANDLE_VALUE) {
    noteReason();
    std::error_code ignored;
    if (errno == EACCES && std::filesystem::is_directory(file, ignored)) errno = EISDIR;
    return -1;
  }
  return _open_osfhandle(reinterpret_cast<intptr_t>(handle), flags | _O_BINARY);
}

/// A lock of a range keeps others from reading and writing it, so that the range lies behind any file's end.
OVERLAPPED farRange() {
  OVERLAPPED place = {};
  place.OffsetHigh = 0x7fffffff;
  return place;
}

struct LocaleBefore {
  int shared;  // whether threads have one locale together, as _configthreadlocale tells
  std::string numbers;
};

}  // namespace

std::FILE* openFile(const std::filesystem::path& file, const char* mode) {
  const bool reads = mode[0] == 'r', appends = mode[0] == 'a';
  DWORD disposition = CREATE_ALWAYS;
  if (reads) disposition = OPEN_EXISTING;
  if (appends) disposition = OPEN_ALWAYS;
  if (std::strchr(mode, 'x')) disposition = CREATE_NEW;
  const Descriptor opened = openShared(file, reads ? GENERIC_READ : GENERIC_WRITE, disposition,
                                       reads     ? _O_RDONLY
                                       : appends ? _O_APPEND
                                                 : 0);
  return opened < 0 ? nullptr : _fdopen(opened, reads ? "rb" : appends ? "ab" : "wb");
}

std::FILE* openPart(const std::filesystem::path& file, bool isEmpty) {
  return openFile(file, isEmpty ? "wb" : "ab");
}

void copyPermissions(const std::filesystem::path&, std::FILE*) {}

bool isWritable(const std::filesystem::path& file) {
  return _waccess(file.c_str(), 2) == 0;
}

bool renameFile(const std::filesystem::path& file, const std::filesystem::path& name) {
  if (MoveFileExW(file.c_str(), name.c_str(), MOVEFILE_REPLACE_EXISTING)) return true;
  return noteReason(), false;
}

bool synchronise(std::FILE* stream) {
  return _commit(_fileno(stream)) == 0 || errno == EBADF || errno == EINVAL;
}

Descriptor openForLock(const std::filesystem::path& file, bool mustBeNew) {
  return openShared(file, GENERIC_READ | GENERIC_WRITE, mustBeNew ? CREATE_NEW : OPEN_ALWAYS, 0);
}

Descriptor descriptorOf(std::FILE* stream) {
  return _dup(_fileno(stream));
}

Lock lockFile(Descriptor file, bool wait) {
  OVERLAPPED place = farRange();
  const DWORD flags = LOCKFILE_EXCLUSIVE_LOCK | (wait ? 0 : LOCKFILE_FAIL_IMMEDIATELY);
  if (LockFileEx(handleOf(file), flags, 0, 1, 0, &place)) return Lock::taken;
  const DWORD reason = GetLastError();
  return reason == ERROR_LOCK_VIOLATION || reason == ERROR_IO_PENDING ? Lock::busy : Lock::absent;
}

// The name lies in the folder in which the file was made, and so on the same volume.
bool isNamed(Descriptor opened, const std::filesystem::path& file) {
  constexpr DWORD kShare = FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE;
  const HANDLE named = CreateFileW(file.c_str(), 0, kShare, nullptr, OPEN_EXISTING, FILE_ATTRIBUTE_NORMAL, nullptr);
  if (named == INVALID_HANDLE_VALUE) return false;
  BY_HANDLE_FILE_INFORMATION one, other;
  const bool same = GetFileInformationByHandle(handleOf(opened), &one) && GetFileInformationByHandle(named, &other) &&
                    one.nFileIndexHigh == other.nFileIndexHigh && one.nFileIndexLow == other.nFileIndexLow;
  CloseHandle(named);
  return same;
}

bool makeEmpty(Descriptor file) {
  return _chsize_s(file, 0) == 0;
}

void closeFile(Descriptor file) {
  _close(file);
}

std::filesystem::path cacheFolder() {
  const wchar_t* folder = _wgetenv(L"LOCALAPPDATA");
  return folder ? folder : L"";
}

// The pattern as a regular expression: what has a meaning there is preceded by a backslash.
bool fits(const std::string& pattern, const std::string& name) {
  std::string expression;
  for (size_t i = 0; i < pattern.size(); ++i) {
    const size_t end = pattern[i] == '[' ? pattern.find(']', i + (pattern[i + 1] == '!' ? 3 : 2)) : std::string::npos;
    if (pattern[i] == '*' || pattern[i] == '?') {
      expression += pattern[i] == '*' ? ".*" : ".";
    } else if (end != std::string::npos) {
      const bool isNot = pattern[i + 1] == '!';
      expression += (isNot ? "[^" : "[") + pattern.substr(i + 1 + isNot, end - i - isNot);
      i = end;
    } else {
      if (pattern[i] == '\\' && i + 1 < pattern.size()) ++i;
      if (std::ispunct(static_cast<unsigned char>(pattern[i]))) expression += '\\';
      expression += pattern[i];
    }
  }
  return std::regex_match(name, std::regex(expression));
}

Locale useClassicLocale() {
  const int shared = _configthreadlocale(_ENABLE_PER_THREAD_LOCALE);
  auto before = std::make_unique<LocaleBefore>(LocaleBefore{shared, setlocale(LC_NUMERIC, nullptr)});
  setlocale(LC_NUMERIC, "C");
  return before.release();
}

void useLocale(Locale locale) {
  const std::unique_ptr<LocaleBefore> before(static_cast<LocaleBefore*>(locale));
  setlocale(LC_NUMERIC, before->numbers.c_str());
  _configthreadlocale(before->shared);
}

std::string machineName() {
  wchar_t name[256] = {};
  DWORD size = 256;
  GetComputerNameExW(ComputerNameDnsHostname, name, &size);
  return utf8(name);
}

unsigned processorCount() {
  DWORD_PTR ofProcess = 0, ofSystem = 0;
  if (!GetProcessAffinityMask(GetCurrentProcess(), &ofProcess, &ofSystem) || ofProcess == 0)  // in several groups
    return std::max(1u, std::thread::hardware_concurrency());
  return static_cast<unsigned>(std::popcount(ofProcess));
}

// Windows sends no signals to threads.
void withoutSignals(const std::function<void()>& start) {
  start();
}

// The compilers for Windows that build the library do not declare its function for names.
void nameThread(const char*) {}

uint32_t processNumber() {
  return GetCurrentProcessId();
}

// There is no fork on Windows.
void atFork(void (*)(), void (*)()) {}

void* openLibrary(const std::string& file, bool) {
  return LoadLibraryW(pathOf(file).c_str());
}

std::string libraryProblem() {
  return std::system_category().message(static_cast<int>(GetLastError()));
}

void* symbolOf(void* library, const char* name) {
  return reinterpret_cast<void*>(GetProcAddress(static_cast<HMODULE>(library), name));
}

std::vector<std::string> vulkanLoaders() {
  return {"vulkan-1.dll"};
}

const char* vulkanAdvice() {
  return "the driver of the graphics card brings both";
}

bool isTerminal(std::FILE* stream) {
  const HANDLE handle = handleOf(_fileno(stream));
  DWORD mode = 0;
  return GetConsoleMode(handle, &mode) && SetConsoleMode(handle, mode | ENABLE_VIRTUAL_TERMINAL_PROCESSING);
}

unsigned terminalColumns(std::FILE* stream) {
  CONSOLE_SCREEN_BUFFER_INFO info;
  if (!GetConsoleScreenBufferInfo(handleOf(_fileno(stream)), &info)) return 0;
  return static_cast<unsigned>(info.srWindow.Right - info.srWindow.Left + 1);
}

void prepareProgram(int& argc, char**& argv) {
  SetConsoleOutputCP(CP_UTF8);
  for (std::FILE* stream : {stdin, stdout, stderr}) _setmode(_fileno(stream), _O_BINARY);
  static std::vector<std::string> texts;
  static std::vector<char*> arguments;
  wchar_t** const given = CommandLineToArgvW(GetCommandLineW(), &argc);
  for (int i = 0; i < argc; ++i) texts.push_back(utf8(given[i]));
  LocalFree(given);
  for (std::string& text : texts) arguments.push_back(text.data());
  arguments.push_back(nullptr);
  argv = arguments.data();
}

}  // namespace gnosphere::os
