// SPDX-License-Identifier: Apache-2.0
// The functions of the operating system, with one interface: os_posix.cpp and os_windows.cpp implement it. Texts and
// names of files are in UTF-8. A function that fails leaves the reason in errno.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace gnosphere::os {

/// Opens a file as std::fopen does, for bytes. A file that is open can be renamed and removed by every process.
std::FILE* openFile(const std::filesystem::path& file, const char* mode);

/// Opens an unfinished file for writing, and creates it if it does not exist. `isEmpty` removes what the file contains;
/// otherwise writing appends. Returns null if the name is that of a link, a pipe or a device.
std::FILE* openPart(const std::filesystem::path& file, bool isEmpty);

/// Gives an open file the permissions of another one, as far as the system lets.
void copyPermissions(const std::filesystem::path& file, std::FILE* to);

/// Whether a file, pipe or device can be written or replaced.
bool isWritable(const std::filesystem::path& file);

/// Gives a file another name; a file that has it is replaced.
bool renameFile(const std::filesystem::path& file, const std::filesystem::path& name);

/// Removes a file, if that is possible.
void removeFile(const std::filesystem::path& file);

/// Adds a file to those that removeUnfinishedAtEnd() is about, and returns its place among them; -1 if there are too
/// many, or its name is too long.
int addUnfinished(const std::filesystem::path& file);
/// Takes a file out again.
void dropUnfinished(int place);
/// From now on a signal that ends this program first removes its unfinished files: SIGINT, SIGTERM and SIGHUP, unless
/// they are ignored or have another handler, and on Windows the events of the console. A library must not call this
/// function, because signals belong to the program.
void removeUnfinishedAtEnd();

/// Returns the words for a reason that a function of this file has just left in errno.
std::string reasonText(int reason);

/// The content of an open file reaches the disk. Returns true, too, if the file system cannot promise this.
bool synchronise(std::FILE* stream);

/// A file that is open for its lock. Whoever closes it, or ends, gives the lock back.
using Descriptor = int;
enum class Lock { taken, busy, absent };  ///< busy: another holder has it; absent: the file system has no locks

/// Opens a file for its lock, and makes it if it is not there; with `mustBeNew` it must not be there. -1 if that
/// fails, and on POSIX if the name is that of a link.
Descriptor openForLock(const std::filesystem::path& file, bool mustBeNew);
/// Another descriptor of an open file, which outlives the stream. -1 if that fails.
Descriptor descriptorOf(std::FILE* stream);
/// Takes the lock of a file, and waits for it if `wait`.
Lock lockFile(Descriptor file, bool wait);
/// Whether an open file still has this name: another process may have renamed or removed it meanwhile.
bool isNamed(Descriptor opened, const std::filesystem::path& file);
bool makeEmpty(Descriptor file);
void closeFile(Descriptor file);

/// The folder in which programs of this user keep what they can make again; empty if there is none.
std::filesystem::path cacheFolder();

/// Whether a name fits a pattern with *, ? and sets as [a-c] and [!a-c].
bool fits(const std::string& pattern, const std::string& name);

using Locale = void*;
/// Lets C's library write and read numbers with a decimal point in this thread. Returns the locale before, for one
/// useLocale().
Locale useClassicLocale();
void useLocale(Locale locale);

/// Returns the number of processors on which this thread may run, at least one. The system may have more.
unsigned processorCount();

/// Calls `start`, whose new threads take no signals but those of faults of their own, which the program's handlers may
/// want to report.
void withoutSignals(const std::function<void()>& start);
/// Gives this thread a name, which debuggers and lists of threads show. The system may cut it after 15 letters.
void nameThread(const char* name);

std::string machineName();
uint32_t processNumber();
/// From now on, each fork of this process calls `before` first, and `after` in both processes when it is done.
void atFork(void (*before)(), void (*after)());

/// Opens a shared library, which stays open; null if it cannot be opened. With `ownSymbols` the library uses its own
/// copy of what another library of the process has, too.
void* openLibrary(const std::string& file, bool ownSymbols = false);
/// Why this thread's last openLibrary() gave null.
std::string libraryProblem();
/// The address of a function in a library; null if the library has none of this name.
void* symbolOf(void* library, const char* name);

/// The file names under which Vulkan's loader may be found, the usual one first.
std::vector<std::string> vulkanLoaders();
/// The end of messages that no Vulkan driver is there.
const char* vulkanAdvice();

/// Whether a stream is a terminal that knows the control sequences of ECMA-48.
bool isTerminal(std::FILE* stream);
/// The columns of the terminal that a stream is; 0 if it is none, or does not say.
unsigned terminalColumns(std::FILE* stream);
/// Gives a program's main() standard streams for bytes in UTF-8, each open, and its arguments in UTF-8.
void prepareProgram(int& argc, char**& argv);

}  // namespace gnosphere::os
