// SPDX-License-Identifier: Apache-2.0
// A sensor that is too large for one buffer is scanned in parts, and nobody can tell.
#include <algorithm>
#include <catch2/matchers/catch_matchers.hpp>

#include "support.hpp"

namespace gnosphere::test {
namespace {

constexpr uint32_t kColumns = 5000, kChannels = 7;

// So many channels of the sensor fit into one buffer: a beam's largest entry has 16 bytes.
uint64_t bufferFor(uint64_t channels) {
  return channels * kColumns * 16;
}

// Channels neither in order of elevation nor, `offsets` given, all at the columns' azimuths.
Sensor shuffledSensor(bool offsets) {
  Sensor sensor = gridSensor(kColumns, kChannels, -50, 60);
  std::swap(sensor.channels[0], sensor.channels[5]);
  std::swap(sensor.channels[2], sensor.channels[3]);
  for (uint32_t j = 0; offsets && j < kChannels; ++j) sensor.channels[j].azimuthOffsetDeg = 1.7 * (j % 3);
  return sensor;
}

Scene sceneOfParts() {
  Scene scene = sceneOf(soup(5, 1500, 40, 5));
  scene.instances.push_back({"", 0, rotationZ(2)});
  return scene;
}

uint64_t fates(const Counters& c) {
  return c.nonFinite + c.degenerate + c.culledByCluster + c.culledByRange + c.culledByFace + c.culledBetweenBeams +
         c.culledHidden + c.projected;
}

}  // namespace

TEST_CASE("a sensor in parts gives the bytes of the whole one, whatever the way") {
  needVulkan();
  const Scene scene = sceneOfParts();
  const Pose pose = {{1, -2, 0.5}, {0, 0, std::sin(0.2), std::cos(0.2)}};
  const Sensor sensor = shuffledSensor(true);
  for (Accuracy accuracy : {Accuracy::standard, Accuracy::exact}) {
    SimulatorOptions options = vulkanOptions();
    options.accuracy = accuracy;
    const Scan whole = scanOf(scene, sensor, pose, options);
    REQUIRE(whole.counters.hits > whole.beamCount() / 2);
    for (Binning binning : {Binning::nearest, Binning::nearest32, Binning::lists, Binning::slabs}) {
      if (accuracy == Accuracy::exact && binning != Binning::nearest) continue;
      INFO("accuracy " << int(accuracy) << ", binning " << int(binning));
      options.binning = binning;
      options.maxBufferBytes = bufferFor(binning == Binning::nearest ? 1 : 3);
      REQUIRE(sameBytes(scanOf(scene, sensor, pose, options), whole));
    }
  }
}

TEST_CASE("what the parts of a sensor count and take adds up") {
  needVulkan();
  const Scene scene = sceneOfParts();
  SimulatorOptions options = vulkanOptions();
  const Scan whole = scanOf(scene, shuffledSensor(false), {}, options);
  options.maxBufferBytes = bufferFor(3);
  const Scan parts = scanOf(scene, shuffledSensor(false), {}, options);
  CHECK(sameBytes(parts, whole));
  CHECK(parts.counters.beams == whole.counters.beams);
  CHECK(parts.counters.hits == whole.counters.hits);
  CHECK(parts.counters.misses == whole.counters.misses);
  CHECK(parts.counters.triangles == 3 * whole.counters.triangles);
  CHECK(fates(parts.counters) == parts.counters.triangles);
  CHECK(parts.counters.projected >= whole.counters.projected);
  REQUIRE(parts.timings.stages.size() == whole.timings.stages.size());
  double sum = 0;
  for (size_t i = 0; i < parts.timings.stages.size(); ++i) {
    CHECK(parts.timings.stages[i].name == whole.timings.stages[i].name);
    if (parts.timings.stages[i].name != "resolve") sum += parts.timings.stages[i].ms;  // the host's
  }
  CHECK(std::abs(parts.timings.gpuMs - sum) <= 1e-6 * sum);
}

TEST_CASE("parts of several sensors stay in flight, and lists of some of them grow") {
  needVulkan();
  const Scene scene = sceneOfParts();
  const std::vector<Sensor> sensors = {shuffledSensor(true), gridSensor(300, 20, -30, 10), shuffledSensor(false)};
  SimulatorOptions options = vulkanOptions();
  options.binning = Binning::lists;
  Simulator whole(scene, sensors, options);
  options.maxBufferBytes = bufferFor(2);
  Simulator parts(scene, sensors, options);
  std::vector<Shot> shots;
  for (size_t i = 0; i < 9; ++i) shots.push_back({{{i < 3 ? -500.0 : 3.0 * double(i), 1, 0}, {}}, i * 2 % 3});
  uint64_t retries = 0;
  parts.scanAll(shots, [&](size_t i, const Scan& scan) {
    INFO("shot " << i);
    const Scan expected = whole.scan(shots[i].pose, shots[i].sensor);
    CHECK(sameBytes(scan, expected));
    CHECK(scan.counters.hits == expected.counters.hits);
    retries += scan.counters.retries;
  });
  CHECK(retries > 0);
}

TEST_CASE("more columns than a column's number may have are an error that names the sensor") {
  needVulkan();
  const auto scanOfColumns = [](uint32_t columns) {
    return scanOf(sceneOf(soup(1, 100, 5, 1)), gridSensor(columns, 1, 0, 0), {}, vulkanOptions());
  };
  CHECK(scanOfColumns(1 << 20).counters.hits > 0);
  CHECK_THROWS_WITH(scanOfColumns((1 << 20) + 1), "sensor 'grid' has 1048577 columns; the limit is 1048576");
}

TEST_CASE("a channel that one buffer does not hold is an error that names the sensor") {
  needVulkan();
  SimulatorOptions options = vulkanOptions();
  options.maxBufferBytes = bufferFor(1) - 16;
  try {
    scanOf(sceneOf(soup(1, 100, 5, 1)), shuffledSensor(false), {}, options);
    FAIL("no error");
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::outOfMemory);
    const std::string text = error.what();
    CHECK(text.starts_with("sensor 'grid' has 5000 columns; one buffer of the device '"));
    CHECK(text.ends_with("' holds 4999 beams, less than one channel"));
  }
}

}  // namespace gnosphere::test
