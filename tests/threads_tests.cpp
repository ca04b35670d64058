// SPDX-License-Identifier: Apache-2.0
// Work that is shared among threads, and simulators in several threads.
#include <pthread.h>

#include <thread>

#include "base/threads.hpp"
#include "support.hpp"

namespace gnosphere::test {
namespace {

// While it lives, the system starts no thread: none has room for its stack.
class NoMoreThreads {
 public:
  NoMoreThreads() {
    pthread_getattr_default_np(&before_);
    pthread_attr_t huge;
    pthread_attr_init(&huge);
    pthread_attr_setstacksize(&huge, size_t{1} << 50);
    pthread_setattr_default_np(&huge);
    pthread_attr_destroy(&huge);
  }
  ~NoMoreThreads() {
    pthread_setattr_default_np(&before_);
    pthread_attr_destroy(&before_);
  }
  NoMoreThreads(const NoMoreThreads&) = delete;
  NoMoreThreads& operator=(const NoMoreThreads&) = delete;

 private:
  pthread_attr_t before_;
};

}  // namespace

TEST_CASE("all runs are worked on by however many threads the system starts") {
  const auto runsOf = [](uint64_t threads) {
    std::vector<std::atomic<int>> done(1000);
    inRuns(done.size(), 7, threads, [&](uint64_t first, uint64_t end) {
      for (uint64_t i = first; i < end; ++i) ++done[i];
    });
    return std::all_of(done.begin(), done.end(), [](int times) { return times == 1; });
  };
  CHECK(runsOf(4));
  const NoMoreThreads none;
  REQUIRE_THROWS_AS(std::thread([] {}), std::system_error);
  CHECK(runsOf(4));
}

TEST_CASE("the reference gives the same without any thread but the caller's") {
  const Scene scene = sceneOf(soup(3, 20'000, 40, 2));
  const Scan with = referenceOf(scene, gridSensor(200, 16, -30, 30), {});
  const NoMoreThreads none;
  CHECK(sameBytes(with, referenceOf(scene, gridSensor(200, 16, -30, 30), {})));
}

}  // namespace gnosphere::test
