// SPDX-License-Identifier: Apache-2.0
// The functions of the operating system, with the same expectations on each.
#include <catch2/catch_test_macros.hpp>
#include <cerrno>
#include <csignal>
#include <fstream>
#include <string>
#include <system_error>
#include <vector>
#ifndef _WIN32
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#endif

#include "base/file.hpp"
#include "base/os.hpp"
#include "base/path.hpp"
#include "base/text.hpp"
#include "folder.hpp"

using namespace gnosphere;

TEST_CASE("one holder at a time has the lock of a file") {
  const test::Folder folder;
  const std::filesystem::path file = folder.path() / "lock";
  const os::Descriptor one = os::openForLock(file, true);
  REQUIRE(one >= 0);
  CHECK(os::openForLock(file, true) < 0);
  CHECK(errno == EEXIST);
  const os::Descriptor other = os::openForLock(file, false);
  REQUIRE(other >= 0);
  CHECK(os::lockFile(one, false) == os::Lock::taken);
  CHECK(os::lockFile(other, false) == os::Lock::busy);
  os::closeFile(one);
  CHECK(os::lockFile(other, true) == os::Lock::taken);
  os::closeFile(other);
}

TEST_CASE("a link is not opened for its lock, and the file that it names is not made") {
  const test::Folder folder;
  std::error_code failed;  // of systems where not everybody may make links
  std::filesystem::create_symlink("elsewhere", folder.path() / "lock", failed);
  if (failed) return;
  CHECK(os::openForLock(folder.path() / "lock", false) < 0);
  CHECK(!std::filesystem::exists(folder.path() / "elsewhere"));
}

#ifndef _WIN32
namespace {

/// Runs `work` in a process of its own, which sends itself a signal afterwards. Returns the signal that has ended it,
/// or 0.
template <typename Work>
int endOf(int signal, const Work& work) {
  const pid_t child = ::fork();
  if (child == 0) {
    std::signal(signal, SIG_DFL);  // Catch2 has a handler
    work();
    ::raise(signal);
    ::_exit(0);
  }
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
}

}  // namespace

TEST_CASE("an unfinished file is no device, pipe or link") {
  const test::Folder folder;
  const std::filesystem::path pipe = folder.path() / "pipe", link = folder.path() / "link";
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  const int reader = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  REQUIRE(reader >= 0);
  for (const std::filesystem::path& file : {std::filesystem::path("/dev/null"), pipe}) {
    errno = 0;
    CHECK(!os::openPart(file, true));
    CHECK(errno == ENXIO);
  }
  ::close(reader);
  CHECK(!os::openPart(pipe, false));  // which would wait for another reader
  std::filesystem::create_symlink("elsewhere", link);
  CHECK(!os::openPart(link, true));
  CHECK(!std::filesystem::exists(folder.path() / "elsewhere"));
}

TEST_CASE("signals that end a program remove its unfinished files if it wishes, and no others") {
  const test::Folder folder;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    INFO("signal " << signal);
    const auto write = [&] {
      AtomicFile done(folder / "done");
      done.commit();
      static AtomicFile open(folder / "open");
      open.write("text");
      static AtomicFile part(folder / "resumed", folder / "resumed.part");
    };
    CHECK(endOf(signal, write) == signal);
    CHECK(std::filesystem::exists(folder / ".open.part"));
    CHECK(endOf(signal, [&] { os::removeUnfinishedAtEnd(), write(); }) == signal);
    CHECK(!std::filesystem::exists(folder / ".open.part"));
    CHECK(std::filesystem::exists(folder / "done"));
    CHECK(std::filesystem::exists(folder / "resumed.part"));
    const auto ignore = [&] {
      std::signal(signal, SIG_IGN);
      os::removeUnfinishedAtEnd();
      write();
    };
    CHECK(endOf(signal, ignore) == 0);
    CHECK(std::filesystem::exists(folder / ".open.part"));
  }
}
#endif

TEST_CASE("more files may be unfinished than are removed at a program's end") {
  const test::Folder folder;
  std::vector<int> places;
  for (int i = 0; i < 100; ++i) places.push_back(os::addUnfinished(folder / std::to_string(i)));
  CHECK(places[0] >= 0);
  CHECK(places.back() == -1);
  for (const int place : places) os::dropUnfinished(place);
  const int again = os::addUnfinished(folder / "again");
  CHECK(again == places[0]);
  os::dropUnfinished(again);
  CHECK(os::addUnfinished(folder / std::string(5000, 'a')) == -1);
}

TEST_CASE("an open file can be written, renamed and replaced, and knows whether a name is its own") {
  const test::Folder folder;
  const std::filesystem::path file = folder.path() / "file", name = folder.path() / "name";
  std::ofstream(name) << "old";
  std::FILE* const stream = os::openFile(file, "wbx");
  REQUIRE(stream);
  CHECK(!os::openFile(file, "wbx"));
  CHECK(errno == EEXIST);
  const os::Descriptor opened = os::descriptorOf(stream);
  CHECK(os::terminalColumns(stream) == 0);
  CHECK(std::fputs("new\n", stream) >= 0);
  CHECK(os::synchronise(stream));
  CHECK(std::fclose(stream) == 0);
  CHECK(os::isNamed(opened, file));
  CHECK(os::renameFile(file, name));
  CHECK(!os::isNamed(opened, file));
  CHECK(os::isNamed(opened, name));
  CHECK(readWholeFile(name) == "new\n");  // no byte is added at the end of a line
  CHECK(os::makeEmpty(opened));
  CHECK(readWholeFile(name).empty());
  os::closeFile(opened);
  CHECK(!os::renameFile(file, name));
  CHECK(errno == ENOENT);
}

TEST_CASE("a name in UTF-8 is that of the file") {
  const test::Folder folder;
  const std::filesystem::path file = folder.path() / pathOf("Größe 測量.txt");
  AtomicFile output(file);
  output.write("content");
  output.commit();
  CHECK(readWholeFile(folder.path() / u8"Größe 測量.txt") == "content");
  CHECK(file.filename().string() == "Größe 測量.txt");
}

TEST_CASE("a file is removed, and a reason has words") {
  const test::Folder folder;
  const std::filesystem::path file = folder.path() / "file";
  std::ofstream(file) << "content";
  os::removeFile(file);
  CHECK(!std::filesystem::exists(file));
  os::removeFile(file);  // a file that is not there is no problem
  CHECK(!os::openFile(file, "rb"));
  CHECK(os::reasonText(errno) == "No such file or directory");
}

TEST_CASE("a path has a name in UTF-8, and a name of a device is known by any capitals and ending") {
#ifdef _WIN32
  CHECK_THROWS_AS(pathOf("Gr\xf6\xdf.glb"), Error);
#else
  CHECK(pathOf("Gr\xf6\xdf.glb").string() == "Gr\xf6\xdf.glb");
#endif
  for (const char* device : {"con", "Nul", "AUX.txt", "prn ", "COM1", "lpt9.d"}) CHECK(namesDevice(device));
  for (const char* name : {"", "console", "com0", "com10", "lpt", "a.nul", "top"}) CHECK(!namesDevice(name));
}

TEST_CASE("a name fits a pattern") {
  CHECK(os::fits("car*", "car 7"));
  CHECK(!os::fits("car*", "a car"));
  CHECK(os::fits("wall?", "wall1"));
  CHECK(!os::fits("wall?", "wall"));
  CHECK(os::fits("[a-c]1", "b1"));
  CHECK(!os::fits("[!a-c]1", "b1"));
  CHECK(os::fits("a.(b)+", "a.(b)+"));
  CHECK(!os::fits("a.b", "axb"));
  CHECK(os::fits("\\*", "*"));
  CHECK(!os::fits("\\*", "x"));
  CHECK(os::fits("[", "["));
}

TEST_CASE("a library that is not there has a reason, and the process a number") {
  CHECK(!os::openLibrary("gnosphere-no-such-library"));
  CHECK(!os::libraryProblem().empty());
  CHECK(os::processNumber() > 0);
  CHECK(!os::machineName().empty());
}

TEST_CASE("no number of bytes is told as 0.0 of a unit") {
  CHECK(mebibytes(0) == "0 bytes");
  CHECK(mebibytes(51) == "51 bytes");
  CHECK(mebibytes(52) == "0.1 KiB");
  CHECK(mebibytes(4096) == "4.0 KiB");
  CHECK(mebibytes(52 * 1024) == "0.1 MiB");
  CHECK(mebibytes(3 << 20) == "3.0 MiB");
}
