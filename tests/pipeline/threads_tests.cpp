// SPDX-License-Identifier: Apache-2.0
// Work shared among threads, and simulators in several threads.
#include <pthread.h>
#include <sched.h>
#include <signal.h>

#include <algorithm>
#include <atomic>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cfenv>
#include <chrono>
#include <new>
#include <string>
#include <thread>
#include <vector>

#include "base/os.hpp"
#include "base/threads.hpp"
#include "base/workers.hpp"
#include "no_more_threads.hpp"
#include "support.hpp"
#include "vulkan/ready_device.hpp"

namespace gnosphere::test {
TEST_CASE("all runs are completed by however many threads the system starts") {
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

TEST_CASE("workers complete all runs again and again, and throw the exception of the work") {
  Workers workers;
  std::vector<int> done(1000);
  for (int turn = 1; turn <= 200; ++turn) {
    workers.inRuns(done.size(), 7, 1 + turn % 5, [&](uint64_t first, uint64_t end) {
      for (uint64_t i = first; i < end; ++i) ++done[i];
    });
    REQUIRE(std::count(done.begin(), done.end(), turn) == 1000);
    CHECK_THROWS_AS(workers.inRuns(100, 1, 4,
                                   [](uint64_t first, uint64_t) {
                                     if (first == 30) throw std::bad_alloc();
                                   }),
                    std::bad_alloc);
  }
  Workers alone;
  const NoMoreThreads none;
  alone.inRuns(done.size(), 7, 4, [&](uint64_t first, uint64_t end) {
    for (uint64_t i = first; i < end; ++i) done[i] = -1;
  });
  CHECK(std::count(done.begin(), done.end(), -1) == 1000);
}

TEST_CASE("workers share work that no thread could do alone") {
  Workers workers;
  for (int turn = 0; turn < 20; ++turn) {
    std::atomic<int> there = 0;
    workers.inRuns(3, 1, 3, [&](uint64_t, uint64_t) {
      ++there;
      while (there < 3) std::this_thread::yield();
    });
  }
}

TEST_CASE("the processors are those on which the thread may run, not those of the machine") {
  std::thread([] {
    cpu_set_t all, one;
    REQUIRE(::sched_getaffinity(0, sizeof all, &all) == 0);
    CHECK(os::processorCount() == static_cast<unsigned>(CPU_COUNT(&all)));
    CPU_ZERO(&one);
    for (int i = 0; i < CPU_SETSIZE && CPU_COUNT(&one) == 0; ++i)
      if (CPU_ISSET(i, &all)) CPU_SET(i, &one);
    REQUIRE(::sched_setaffinity(0, sizeof one, &one) == 0);
    CHECK(os::processorCount() == 1);
  }).join();
}

TEST_CASE("threads of the library have a name and take no signals of the program, which its own threads keep") {
  sigset_t before, after;
  ::pthread_sigmask(SIG_BLOCK, nullptr, &before);
  const std::thread::id caller = std::this_thread::get_id();
  std::atomic<int> there = 0;
  const auto look = [&](uint64_t = 0, uint64_t = 0) {
    ++there;
    while (there < 2) std::this_thread::yield();
    if (std::this_thread::get_id() == caller) return;
    sigset_t blocked;
    ::pthread_sigmask(SIG_BLOCK, nullptr, &blocked);
    for (const int signal : {SIGTERM, SIGINT, SIGALRM, SIGUSR1, SIGCHLD}) CHECK(::sigismember(&blocked, signal) == 1);
    for (const int fault : {SIGSEGV, SIGBUS, SIGFPE}) CHECK(::sigismember(&blocked, fault) == 0);
    char name[16] = {};
    ::pthread_getname_np(::pthread_self(), name, sizeof name);
    CHECK(std::string(name) == "gnosphere");
  };
  inRuns(2, 1, 2, look);
  there = 0;
  Workers().inRuns(2, 1, 2, look);
  there = 1;
  startThread("a test", look).join();
  const NoMoreThreads none;
  CHECK_THROWS_AS(startThread("a test", look), Error);
  ::pthread_sigmask(SIG_BLOCK, nullptr, &after);
  for (const int signal : {SIGTERM, SIGINT, SIGALRM})
    CHECK(sigismember(&before, signal) == sigismember(&after, signal));
}

TEST_CASE("an exception of the work ends all threads and is thrown by inRuns()") {
  for (const uint64_t threads : {1, 4}) {
    std::atomic<int> done = 0;
    CHECK_THROWS_AS(inRuns(1'000'000, 1, threads,
                           [&](uint64_t first, uint64_t) {
                             ++done;
                             if (first == 3) throw std::bad_alloc();
                             std::this_thread::sleep_for(std::chrono::microseconds(10));
                           }),
                    std::bad_alloc);
    CHECK(done < 500'000);
  }
}

TEST_CASE("the reference gives the same result with only the caller's thread") {
  const Scene scene = sceneOf(soup(3, 20'000, 40, 2));
  const Scan with = referenceOf(scene, gridSensor(200, 16, -30, 30), {});
  const NoMoreThreads none;
  CHECK(sameBytes(with, referenceOf(scene, gridSensor(200, 16, -30, 30), {})));
}

TEST_CASE("simulators in several threads give the same results as in one thread") {
  needVulkan();
  const Scene scene = sceneOf(soup(7, 300, 30, 10));
  const std::vector<Sensor> sensors = {gridSensor(120, 8, -30, 30), gridSensor(60, 16, -20, 20)};
  const auto scans = [&](size_t turn) {
    TestOptions options = vulkanOptions();
    // One lock guards the layer's own state, which would serialise the threads.
    if (turn % 2 == 1) options.validation = false;
    options.tuning.binning = turn % 3 == 0 ? Binning::lists : Binning::nearest;
    Simulator simulator = makeSimulator(scene, sensors, options);
    std::vector<Scan> results;
    for (size_t sensor = 0; sensor < sensors.size(); ++sensor) results.push_back(simulator.scan({}, sensor));
    return results;
  };
  const std::vector<Scan> expected = scans(0);
  const Scan reference = referenceOf(scene, sensors[0], {});
  constexpr size_t kThreads = 2, kTurns = 3;
  std::string problems[kThreads];
  std::vector<std::thread> threads;
  for (size_t thread = 0; thread < kThreads; ++thread)
    threads.emplace_back([&, thread] {
      try {
        for (size_t turn = 0; turn < kTurns; ++turn) {
          if (listDevices().size() < 2) problems[thread] += "a device is missing; ";
          const std::vector<Scan> results = scans(thread + turn);
          for (size_t i = 0; i < results.size(); ++i)
            if (!sameBytes(results[i], expected[i])) problems[thread] += "turn " + std::to_string(turn) + "; ";
        }
      } catch (const std::exception& error) {
        problems[thread] += error.what();
      }
    });
  for (std::thread& thread : threads) thread.join();
  for (const std::string& problem : problems) CHECK(problem == "");
  requireSame(reference, expected[0]);
}

TEST_CASE("a scan has the same bits in every rounding mode of the caller, who finds it as before") {
  needVulkan();
  const Scene scene = sceneOf(soup(11, 300, 30, 10));
  const Sensor sensor = builtinSensor("VLP-16");
  const Pose pose = {{0.37, 0, 0}, {0, 0, 0.1, 1}};
  for (const bool onDevice : {true, false}) {
    TestOptions options = onDevice ? vulkanOptions() : TestOptions();
    if (!onDevice) options.device.kind = DeviceChoice::Kind::reference;
    options.accuracy = Accuracy::exact;
    options.validation = false;
    Scan scans[2];
    for (const int mode : {FE_TONEAREST, FE_UPWARD}) {
      REQUIRE(std::fesetround(mode) == 0);
      Simulator simulator = makeSimulator(scene, {sensor}, options);
      const int made = std::fegetround();
      Scan scan = simulator.scan(pose);
      const int scanned = std::fegetround();
      std::fesetround(FE_TONEAREST);
      CHECK((made == mode && scanned == mode));
      scans[mode == FE_UPWARD] = std::move(scan);
    }
    CHECK(sameBytes(scans[0], scans[1]));
  }
}

#if defined(__GLIBC__) && defined(__SSE2__)
TEST_CASE("simulators work in a thread with floating-point traps and without denormal numbers, which it keeps") {
  needVulkan();
  Scene scene = sceneOf(soup(11, 300, 30, 10));
  MeshBuilder tiny;
  tiny.triangle({0, 0, 0}, {1e-40, 0, 0}, {0, 1e-40, 0});
  scene.meshes.push_back(tiny.take());
  scene.instances.push_back({"", 1, {}});
  const SensorRequest request = {builtinSensor("VLP-16"), {}, {Field::incidence}};
  constexpr int kTraps = FE_DIVBYZERO | FE_INVALID | FE_OVERFLOW;
  constexpr unsigned kToZero = 0x8040;
  for (const bool onDevice : {true, false}) {
    TestOptions options = onDevice ? vulkanOptions() : TestOptions();
    if (!onDevice) options.device.kind = DeviceChoice::Kind::reference;
    const Scan expected = Simulator(scene, request, options).scan({});
    CHECK(expected.counters.degenerate == 0);
    vulkan::destroyIdleDevices();  // threads of the driver start with the next simulator
    std::fenv_t usual;
    std::fegetenv(&usual);
    feenableexcept(kTraps);
    __builtin_ia32_ldmxcsr(__builtin_ia32_stmxcsr() | kToZero);
    Simulator simulator(scene, request, options);
    const Scan scan = simulator.scan({});
    static_cast<void>(simulator.plan(0, 2));
    const int traps = fegetexcept();
    const unsigned mode = __builtin_ia32_stmxcsr();
    std::fesetenv(&usual);
    CHECK(traps == kTraps);
    CHECK((mode & kToZero) == kToZero);
    CHECK(sameBytes(scan, expected));
    CHECK(scan.counters.degenerate == 0);
  }
}
#endif

TEST_CASE("a simulator at work refuses other calls, of its own functions and of other threads") {
  const Scene scene = sceneOf(soup(8, 300, 30, 10));
  SimulatorOptions options;
  options.device = DeviceChoice::Kind::reference;
  Simulator simulator(scene, gridSensor(60, 16, -20, 20), options);
  const Scan expected = simulator.scan({});
  const auto atWork = Catch::Matchers::StartsWith("the simulator is at work: one thread at a time may use it");
  const auto refusesChanges = [&] {
    CHECK_THROWS_WITH(simulator.scan({}), atWork);
    CHECK_THROWS_WITH(simulator.setTransform(0, {}), atWork);
    CHECK(simulator.device().type == "reference");
  };
  const auto refusesReaders = [&] {
    CHECK_THROWS_WITH(simulator.plan(), atWork);
    CHECK_THROWS_WITH(simulator.memory(), atWork);
    refusesChanges();
  };
  const std::vector<Shot> shots(2);
  const size_t effects = simulator.plan().effects.size();
  std::vector<Scan> received;
  simulator.scanAll(shots, [&](size_t shot, const Scan& scan) {
    received.push_back(scan);
    if (shot == 0) {
      refusesChanges();
      CHECK(simulator.plan().effects.size() == effects);
    } else {
      std::thread(refusesReaders).join();
    }
  });
  REQUIRE(received.size() == 2);
  for (const Scan& scan : received) CHECK(sameBytes(scan, expected));
  Batch batch;
  CHECK_THROWS_WITH(simulator.scanBatchInto(shots, batch, {}, [&](size_t) { simulator.scan({}); }), atWork);
  CHECK(sameBytes(simulator.scan({}), expected));  // the call that failed is over
}

TEST_CASE("simulators that share a device scan and compile in several threads at the same time") {
  needVulkan();
  const Scene scene = sceneOf(soup(8, 300, 30, 10));
  const Sensor small = gridSensor(60, 16, -20, 20), large = gridSensor(120, 8, -30, 30);
  std::vector<Simulator> simulators;
  for (int i = 0; i < 3; ++i) simulators.push_back(makeSimulator(scene, small, vulkanOptions()));
  const auto scans = [&](Simulator& simulator) {
    std::vector<Scan> results;
    for (int turn = 0; turn < 4; ++turn) results.push_back(simulator.scan({}));
    SensorRequest request{large, Effects::none()};
    request.effects.intensity.use = EffectUse::on;  // so that both threads want kernels that are not compiled
    results.push_back(simulator.scan({}, simulator.addSensor(request)));
    return results;
  };
  std::vector<Scan> results[2];
  std::string problems[2];
  std::vector<std::thread> threads;
  for (size_t i = 0; i < 2; ++i)
    threads.emplace_back([&, i] {
      try {
        results[i] = scans(simulators[i]);
      } catch (const std::exception& error) {
        problems[i] = error.what();
      }
    });
  for (std::thread& thread : threads) thread.join();
  const std::vector<Scan> expected = scans(simulators[2]);
  for (size_t i = 0; i < 2; ++i) {
    CHECK(problems[i] == "");
    REQUIRE(results[i].size() == expected.size());
    for (size_t k = 0; k < expected.size(); ++k) CHECK(sameBytes(results[i][k], expected[k]));
  }
}

}  // namespace gnosphere::test
