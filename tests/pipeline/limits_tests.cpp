// SPDX-License-Identifier: Apache-2.0
// Limits of a device: no buffer exceeds its limit, and everything within the limit works.
#include <algorithm>
#include <catch2/matchers/catch_matchers_string.hpp>

#include "columns.hpp"
#include "effects/sensor_plan.hpp"
#include "pipeline/device_backend.hpp"
#include "pipeline/host_memory.hpp"
#include "support.hpp"
#include "town/town.hpp"

namespace gnosphere::test {
namespace {

using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::StartsWith;

constexpr uint64_t kMebibyte = 1 << 20;

/// A sensor with unsorted elevations, and azimuth offsets on some channels.
Sensor shuffledSensor() {
  Sensor sensor = gridSensor(5000, 7, -50, 60);
  std::swap(sensor.channels[0], sensor.channels[5]);
  for (uint32_t j = 0; j < 7; ++j) sensor.channels[j].azimuthOffsetDeg = 1.7 * (j % 3);
  return sensor;
}

/// Groups of triangles side by side, `apart` metres from each other. Most triangles cover too many beams to be tried
/// without being listed.
Scene crowds(int count, double apart) {
  Scene scene = sceneOf(soup(5, 5000, 40, 5));
  scene.instances.clear();
  for (int i = 0; i < count; ++i) scene.instances.push_back({"", 0, translation(apart * i, 0, 0.1 * i)});
  return scene;
}

/// A machine of a terabyte on which each scan counts so many candidates, and does nothing else.
class CountingMachine final : public Machine {
 public:
  explicit CountingMachine(uint32_t candidates) : candidates_(candidates) {
    traits_.info.maxBufferBytes = uint64_t{1} << 40;
    traits_.int64Atomics = true;
  }
  const Traits& traits() const override { return traits_; }
  std::unique_ptr<DeviceMemory> allocate(const char* name, uint64_t bytes, MemoryKind) override {
    return std::make_unique<HostMemory>(name, bytes);
  }
  void prepare(std::span<const Variant>) override {}
  size_t slots() const override { return 1; }
  void submit(size_t, std::span<const Step>, const BoundArrays& arrays) override {
    auto& counters = *static_cast<gpu::Counters*>(arrays[static_cast<size_t>(gpu::Array::counters)]->host());
    counters.candidates = candidates_;
    counters.alive = gpu::kAlive;
  }
  void wait(size_t) override {}
  void readTimings(size_t, Timings&) override {}

 private:
  Traits traits_;
  uint32_t candidates_;
};

uint64_t largestBuffer(const Simulator& simulator) {
  uint64_t largest = 0;
  for (const auto& buffer : simulator.plan().buffers) largest = std::max(largest, buffer.bytes);
  return largest;
}

/// Returns the message of the out-of-memory error that `work` throws.
template <typename Work>
std::string outOfMemory(const Work& work) {
  try {
    work();
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::outOfMemory);
    return error.what();
  }
  FAIL("no error");
  return "";
}

}  // namespace

TEST_CASE("a buffer limit that all buffers keep changes no byte, with every accuracy and binning", "[combinations]") {
  needVulkan();
  Scene scene = sceneOf(soup(5, 1500, 40, 5));
  scene.instances.push_back({"", 0, rotationZ(2)});
  const Pose pose = {{1, -2, 0.5}, {0, 0, std::sin(0.2), std::cos(0.2)}};
  for (Accuracy accuracy : {Accuracy::standard, Accuracy::exact})
    for (Binning binning : {Binning::nearest, Binning::lists, Binning::slabs}) {
      if (accuracy == Accuracy::exact && binning != Binning::lists && !everyCombination()) continue;
      INFO("accuracy " << int(accuracy) << ", binning " << int(binning));
      TestOptions options = vulkanOptions();
      options.accuracy = accuracy;
      options.tuning.binning = binning;
      Simulator free = makeSimulator(scene, shuffledSensor(), options);
      const Scan expected = free.scan(pose);
      REQUIRE(expected.counters.hits > expected.beamCount() / 2);
      options.tuning.maxBufferBytes = largestBuffer(free);
      REQUIRE(sameBytes(scanOf(scene, shuffledSensor(), pose, options), expected));
    }
}

TEST_CASE("a buffer limit changes no byte of a scan with effects") {
  needVulkan();
  const Scene scene = sceneOf(soup(5, 1500, 40, 5));
  TestOptions options = vulkanOptions();
  options.effects = Effects();
  for (const char* effect : {"detection.reflectance=0.1", "range-noise.sigma=0.02", "divergence.horizontal=0.003"})
    assign(options.effects, effect);
  options.fields = {Field::intensity, Field::normal};
  Sensor sensor = shuffledSensor();
  sensor.maxReturns = 3;
  Simulator free = makeSimulator(scene, sensor, options);
  const Scan expected = free.scan({});
  options.tuning.maxBufferBytes = largestBuffer(free);
  const Scan capped = scanOf(scene, sensor, {}, options);
  CHECK(sameBytes(capped, expected));
  for (const Field field : options.fields)
    CHECK(sameBytes(valuesOf<float>(capped, field), valuesOf<float>(expected, field)));
}

TEST_CASE("a buffer limit too small for a sensor or a scene is an error that names the array, its size and the limit") {
  needVulkan();
  const auto errorOf = [](const Scene& scene, uint64_t cap) {
    TestOptions options = vulkanOptions();
    options.tuning.maxBufferBytes = cap;
    return outOfMemory([&] { makeSimulator(scene, gridSensor(100'000, 2, -10, 10), options); });
  };
  const Scene scene = sceneOf(soup(1, 100, 5, 1));
  const std::string columns = errorOf(scene, kMebibyte / 2), words = errorOf(scene, kMebibyte);
  CHECK_THAT(columns, StartsWith("'columns' needs one buffer of 0.8 MiB; the device '"));
  CHECK_THAT(columns, ContainsSubstring("' allows 0.5 MiB; scan a sector of the sensor at a time"));
  CHECK_THAT(words, StartsWith("'words' needs one buffer of 1.5 MiB; the device '"));
  CHECK_THAT(errorOf(sceneOf(soup(1, 100'000, 5, 1)), kMebibyte), ContainsSubstring(" allows 1.0 MiB"));
}

TEST_CASE("a list that exceeds the limit fails only that scan") {
  needVulkan();
  Scene scene = crowds(36, 0);
  scene.instances.push_back({"", 0, translation(1000, 0, 0)});
  const Sensor sensor = gridSensor(1000, 64, -30, 30, 100);
  const Pose crowded = {{0, 0, 0.3}, {}}, other = {{1000, 1, 0.3}, {}};
  for (Binning binning : {Binning::nearest, Binning::lists, Binning::slabs}) {
    INFO("binning " << int(binning));
    TestOptions options = vulkanOptions();
    options.tuning.binning = binning;
    options.tuning.culling.occlusion = Culling::Occlusion::never;
    Simulator free = makeSimulator(scene, sensor, options);
    options.tuning.maxBufferBytes = kMebibyte;
    Simulator capped = makeSimulator(scene, sensor, options);
    const Scan expected = free.scan(other);
    REQUIRE(free.scan(crowded).counters.projected * 16 > options.tuning.maxBufferBytes);
    REQUIRE(expected.counters.hits > 0);
    for (int round = 0; round < 2; ++round) {
      const std::string message = outOfMemory([&] { capped.scan(crowded); });
      CHECK_THAT(message, ContainsSubstring("' needs one buffer of "));
      CHECK_THAT(message, ContainsSubstring("' allows 1.0 MiB"));
      const Scan scan = capped.scan(other);
      CHECK(scan.counters.retries > 0);
      CHECK(sameBytes(scan, expected));
      CHECK(sameBytes(capped.scan(other), expected));
    }
    // Scans in flight before and after it must succeed.
    const std::vector<Shot> shots = {{other}, {other}, {crowded}, {other}};
    size_t received = 0;
    outOfMemory(
        [&] { capped.scanAll(shots, [&](size_t, const Scan& scan) { received += sameBytes(scan, expected); }); });
    CHECK(received == 2);
    CHECK(sameBytes(capped.scan(other), expected));
  }
}

TEST_CASE("lists grow up to the limit and change no byte") {
  needVulkan();
  const Scene scene = crowds(24, 12);
  const Sensor sensor = gridSensor(1000, 64, -30, 30, 500);
  std::vector<Shot> shots;
  for (int i = 0; i < 8; ++i) shots.push_back({{{-200.0 + 30 * i, 1, 0.3}, {}}});
  for (Binning binning : {Binning::nearest, Binning::lists, Binning::slabs}) {
    INFO("binning " << int(binning));
    TestOptions options = vulkanOptions();
    options.tuning.binning = binning;
    options.tuning.culling.occlusion = Culling::Occlusion::never;
    Simulator free = makeSimulator(scene, sensor, options);
    std::vector<Scan> expected;
    free.scanAll(shots, [&](size_t, const Scan& scan) { expected.push_back(scan); });
    // The limit is the largest array of a simulator that has made all scans.
    options.tuning.maxBufferBytes = largestBuffer(free);
    Simulator capped = makeSimulator(scene, sensor, options);
    uint64_t retries = 0;
    capped.scanAll(shots, [&](size_t i, const Scan& scan) {
      INFO("shot " << i);
      CHECK(sameBytes(scan, expected[i]));
      retries += scan.counters.retries;
    });
    // With slabs the lists have room for several views from the start.
    if (binning != Binning::slabs) CHECK(retries >= 1);
    CHECK(largestBuffer(capped) <= options.tuning.maxBufferBytes);
  }
}

TEST_CASE("a town in two shells with a buffer limit has the same bytes and is culled equally") {
  needVulkan();
  const Scene scene = makeTown({.triangles = 30'000});
  TestOptions options = vulkanOptions();
  options.tuning.culling.occlusion = Culling::Occlusion::always;
  options.tuning.binning = Binning::nearest;  // with slabs the counts depend on which triangles have been tried before
  const Pose pose = {{0, 0, 1.8}, {}};
  const Scan whole = scanOf(scene, builtinSensors()[0], pose, options);
  options.tuning.maxBufferBytes = kMebibyte / 2;
  const Scan capped = scanOf(scene, builtinSensors()[0], pose, options);
  CHECK(sameBytes(whole, capped));
  CHECK(capped.counters.culledByCluster == whole.counters.culledByCluster);
}

TEST_CASE("a list whose words have no numbers of 31 bits is an error, however much memory there is") {
  const Scene scene = sceneOf(soup(1, 100, 5, 1));
  Effects effects = Effects::none();
  effects.divergence = {EffectUse::on, 7, Effects::Divergence::Profile::gaussian, 3e-3, 2e-3};
  effects.intensity.use = EffectUse::automatic;
  const TestOptions options;
  const auto scanWith = [&](uint32_t candidates) {
    SensorPlanner planner(options);
    const auto backend =
        makeDeviceBackend(std::make_unique<CountingMachine>(candidates), scene,
                          {planner.plan(scene, {gridSensor(100, 4, -10, 10), effects}, 0, false)}, options);
    const Shot shot;
    Scan scan;
    backend->scanAll({&shot, 1}, scan, [](size_t) {});
    return scan.counters.retries;
  };
  // A candidate of a footprint has three words.
  constexpr uint32_t kMost = 0x7fffffff / 3;
  CHECK(scanWith(kMost - 10) == 1);
  CHECK_THAT(outOfMemory([&] { scanWith(kMost + 10); }), StartsWith("'candidates' needs more than 715827882 entries"));
}

TEST_CASE("more columns than directions can distinguish are an error that names the sensor") {
  needVulkan();
  CHECK_THROWS_WITH(scanOf(sceneOf(soup(1, 100, 5, 1)), gridSensor((1 << 25) + 1, 1, 0, 0), {}, vulkanOptions()),
                    "sensor 'grid' has 33554433 columns; the limit is 33554432");
}

// Above 2^24 columns a float cannot represent every column number, and a triangle's columns are computed in floats.
TEST_CASE("20 million beams in one channel lose no beam", "[.slow]") {
  needVulkan();
  constexpr uint32_t kColumns = 20'000'000, kEvery = 4000;
  TestOptions options = vulkanOptions();
  options.accuracy = Accuracy::exact;
  const Scene crowd = sceneOf(soup(3, 20'000, 40, 3)), wall = sceneOf(ball(6, 50'000, 5));
  for (double offset : {0.0, 1.7})
    for (Binning binning : {Binning::slabs, Binning::nearest, Binning::lists}) {
      INFO("offset " << offset << ", binning " << int(binning));
      if (offset > 0 && binning != Binning::slabs) continue;
      options.tuning.binning = binning;
      Sensor sensor = gridSensor(kColumns, 1, 3, 3);
      sensor.channels[0].azimuthOffsetDeg = offset;
      const Scan scan = scanOf(crowd, sensor, {{1, 2, 0.5}, {}}, options);
      Sensor few = sensor;
      few.columns = kColumns / kEvery;
      const Scan expected = scanOf(crowd, few, {{1, 2, 0.5}, {}}, options);
      REQUIRE(expected.counters.hits > few.columns / 2);
      size_t different = 0;
      for (size_t i = 0; i < few.columns; ++i)
        different += scan.triangles[i * kEvery] != expected.triangles[i] ||
                     std::memcmp(&scan.points[3 * i * kEvery], &expected.points[3 * i], 3 * sizeof(float)) != 0;
      CHECK(different == 0);
      requireSame(referenceOf(crowd, few, {{1, 2, 0.5}, {}}), expected);
      // The columns at both sides of 50,000 triangles that stand side by side around the sensor.
      CHECK(scanOf(wall, sensor, {{0.1, 0.2, 0.3}, {}}, options).counters.misses == 0);
    }
}

}  // namespace gnosphere::test
