// SPDX-License-Identifier: Apache-2.0
// Subscribers in processes of their own, on the loopback interface.
#pragma once

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch_test_macros.hpp>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#ifdef __SANITIZE_ADDRESS__
extern "C" size_t __sanitizer_get_current_allocated_bytes();  // GCC 12 has no header with it
#endif

namespace gnosphere::test {

/// Makes Cyclone DDS of this process and of those that it starts use the loopback interface alone, in a domain that
/// other tests on this machine hardly have.
inline int loopbackDomain() {
  static const int domain = [] {
    setenv("CYCLONEDDS_URI",
           "<CycloneDDS><Domain><General><Interfaces><NetworkInterface address='127.0.0.1'/></Interfaces>"
           "<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
           "<MaxAutoParticipantIndex>99</MaxAutoParticipantIndex><Peers><Peer address='127.0.0.1'/></Peers></Discovery>"
           "</Domain></CycloneDDS>",
           1);
    const int chosen = 1 + getpid() % 100;  // their ports are below those that Linux gives to others
    setenv("ROS_DOMAIN_ID", std::to_string(chosen).c_str(), 1);
    return chosen;
  }();
  return domain;
}

struct Wanted {
  std::string type = "cloud", qos = "reliable";
  int count = 1, seconds = 20, sleepMs = 0;
};

/// The program tests/ros2/listener while it runs.
class Listener {
 public:
  Listener(const Wanted& wanted, const std::vector<std::string>& topics) {
    std::vector<std::string> words = {GNOSPHERE_LISTENER,
                                      std::to_string(loopbackDomain()),
                                      wanted.type,
                                      wanted.qos,
                                      std::to_string(wanted.count),
                                      std::to_string(wanted.seconds),
                                      std::to_string(wanted.sleepMs)};
    words.insert(words.end(), topics.begin(), topics.end());
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    int ends[2];
    REQUIRE(pipe2(ends, O_CLOEXEC) == 0);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], 1);
    REQUIRE(posix_spawn(&process_, arguments[0], &actions, nullptr, arguments.data(), environ) == 0);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    reader_ = std::thread([this, end = ends[0]] { read(fdopen(end, "r")); });
  }
  ~Listener() {
    end(SIGKILL);
    if (reader_.joinable()) reader_.join();
  }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  void tell(int number) const { kill(process_, number); }
  void end(int number) {
    if (process_ <= 0) return;
    kill(process_, number);
    waitpid(process_, nullptr, 0);
    process_ = 0;
  }
  /// All lines until the listener ends, without its last one.
  std::vector<std::string> lines() {
    reader_.join();
    if (!lines_.empty() && lines_.back() == "end") lines_.pop_back();
    return lines_;
  }

 private:
  // A listener must not wait until its output is read.
  void read(std::FILE* output) {
    char* line = nullptr;
    size_t room = 0;
    while (getline(&line, &room, output) > 0) {
      lines_.emplace_back(line);
      lines_.back().pop_back();
    }
    std::free(line);
    std::fclose(output);
  }

  pid_t process_ = 0;
  std::vector<std::string> lines_;
  std::thread reader_;
};

/// Waits up to 20 s until a condition holds, and returns whether it does.
inline bool eventually(const std::function<bool()>& condition) {
  for (int i = 0; i < 2000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

/// Megabytes of memory that this process has now. AddressSanitizer keeps freed memory for a while to find later
/// accesses to it, so there only allocations count that are not freed.
inline double residentMegabytes() {
#ifdef __SANITIZE_ADDRESS__
  return static_cast<double>(__sanitizer_get_current_allocated_bytes()) / 1e6;
#else
  std::ifstream file("/proc/self/statm");
  double all = 0, resident = 0;
  file >> all >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
#endif
}

}  // namespace gnosphere::test
