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
#include "base/text.hpp"
#include "base/unfinished.hpp"

namespace gnosphere::os {
namespace {

UnfinishedFiles unfinished;

constexpr DWORD kShareAll = FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE;

thread_local DWORD lastReason = 0;  // of noteReason()

/// Sets errno to the reason why a function of Windows has failed. Reasons that the C library has no number for are EIO,
/// and reasonText() then has the words of Windows.
void noteReason(DWORD reason) {
  lastReason = reason;
  switch (reason) {
    case ERROR_FILE_NOT_FOUND:
    case ERROR_PATH_NOT_FOUND: errno = ENOENT; break;
    case ERROR_FILE_EXISTS:
    case ERROR_ALREADY_EXISTS: errno = EEXIST; break;
    case ERROR_DISK_FULL:
    case ERROR_HANDLE_DISK_FULL: errno = ENOSPC; break;
    case ERROR_ACCESS_DENIED: errno = EACCES; break;
    case ERROR_SHARING_VIOLATION: errno = EBUSY; break;
    case ERROR_FILENAME_EXCED_RANGE: errno = ENAMETOOLONG; break;
    case ERROR_TOO_MANY_OPEN_FILES: errno = EMFILE; break;
    case ERROR_NOT_ENOUGH_MEMORY: errno = ENOMEM; break;
    case ERROR_WRITE_PROTECT: errno = EROFS; break;
    default: errno = EIO;
  }
}

HANDLE handleOf(Descriptor file) {
  return reinterpret_cast<HANDLE>(_get_osfhandle(file));
}

/// Returns a text in UTF-8. Halves of surrogate pairs, which names of files may have, become U+FFFD.
std::string utf8(const wchar_t* text) {
  const int size = WideCharToMultiByte(CP_UTF8, 0, text, -1, nullptr, 0, nullptr, nullptr);
  std::string result(static_cast<size_t>(std::max(size, 1)), '\0');
  WideCharToMultiByte(CP_UTF8, 0, text, -1, result.data(), size, nullptr, nullptr);
  result.pop_back();  // the zero at the end
  return result;
}

/// The words of Windows for a reason, without the full stop.
std::string wordsOf(DWORD reason) {
  wchar_t words[512] = L"";
  FormatMessageW(FORMAT_MESSAGE_FROM_SYSTEM | FORMAT_MESSAGE_IGNORE_INSERTS, nullptr, reason, 0, words, 512, nullptr);
  const std::string text = utf8(words);
  return std::string(trimmed(text, " .\r\n")) + " (Windows' error " + std::to_string(reason) + ")";
}

/// Calls a function of Windows that renames, removes or opens `file`, and again for 1.5 s if another program has it
/// open, as virus scanners and indexers have new files for a moment. A folder or a read-only file is not waited for.
template <typename Call>
bool patiently(const std::filesystem::path& file, const Call& call) {
  for (DWORD pause = 12;; pause *= 2) {  // ms
    if (call()) return true;
    const DWORD reason = GetLastError(), attributes = GetFileAttributesW(file.c_str());
    const bool stays = attributes != INVALID_FILE_ATTRIBUTES &&
                       (attributes & (FILE_ATTRIBUTE_READONLY | FILE_ATTRIBUTE_DIRECTORY)) != 0;
    const bool mayPass = reason == ERROR_SHARING_VIOLATION || (reason == ERROR_ACCESS_DENIED && !stays);
    if (!mayPass || pause > 768) return noteReason(reason), false;
    Sleep(pause);
  }
}

/// The C library's functions open files that nobody else may rename or remove, so they are opened by Windows.
Descriptor openShared(const std::filesystem::path& file, DWORD access, DWORD disposition, int flags) {
  const HANDLE handle =
      CreateFileW(file.c_str(), access, kShareAll, nullptr, disposition, FILE_ATTRIBUTE_NORMAL, nullptr);
  if (handle == INVALID_HANDLE_VALUE) {
    noteReason(GetLastError());
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

// A file that another program has open, and shares no removal of, cannot be replaced.
bool isWritable(const std::filesystem::path& file) {
  if (_waccess(file.c_str(), 2) != 0) return false;
  return patiently(file, [&] {
    const HANDLE opened =
        CreateFileW(file.c_str(), DELETE, kShareAll, nullptr, OPEN_EXISTING, FILE_ATTRIBUTE_NORMAL, nullptr);
    return opened != INVALID_HANDLE_VALUE && CloseHandle(opened);
  });
}

bool renameFile(const std::filesystem::path& file, const std::filesystem::path& name) {
  return patiently(name, [&] { return MoveFileExW(file.c_str(), name.c_str(), MOVEFILE_REPLACE_EXISTING); });
}

void removeFile(const std::filesystem::path& file) {
  patiently(file, [&] { return DeleteFileW(file.c_str()); });
}

int addUnfinished(const std::filesystem::path& file) {
  return unfinished.add(file);
}

void dropUnfinished(int place) {
  unfinished.drop(place);
}

void removeUnfinishedAtEnd() {
  const auto handler = [](DWORD) -> BOOL {
    unfinished.removeAll([](const wchar_t* name) { DeleteFileW(name); });
    return FALSE;  // the next handler ends the program
  };
  SetConsoleCtrlHandler(handler, TRUE);
}

std::string reasonText(int reason) {
  if (reason == EBUSY) return "another program has it open";
  return reason == EIO && lastReason != 0 ? wordsOf(lastReason) : std::strerror(reason);
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
  const HANDLE named = CreateFileW(file.c_str(), 0, kShareAll, nullptr, OPEN_EXISTING, FILE_ATTRIBUTE_NORMAL, nullptr);
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
  return wordsOf(GetLastError());
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
  static const UINT kBefore = GetConsoleOutputCP();  // the console belongs to the shell, too
  if (kBefore != 0 && SetConsoleOutputCP(CP_UTF8)) std::atexit([] { SetConsoleOutputCP(kBefore); });
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
