// SPDX-License-Identifier: Apache-2.0
// Step resolve: range, point and owner of every beam, compared with closed forms and the double-precision reference.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "support.hpp"
#include "town/town.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

TEST_CASE("the device's range of flat ground is the height over the sine of the depression") {
  needVulkan();
  MeshBuilder builder;
  builder.quad({-100, -100, 0}, {200, 0, 0}, {0, 200, 0}, 64);
  const Sensor sensor = gridSensor(1800, 40, -40, -2, 60);
  const Scan scan = scanOf(sceneOf(builder.take()), sensor, {{0.7, 0.3, 1.8}, {}}, vulkanOptions());
  for (uint32_t channel = 0; channel < 40; ++channel) {
    const double range = 1.8 / std::sin(-sensor.channels[channel].elevationDeg * std::numbers::pi / 180);
    for (uint32_t column = 0; column < 1800; ++column) {
      const size_t beam = channel * size_t{1800} + column;
      REQUIRE(scan.hit(beam) == (range <= 60));
      if (scan.hit(beam)) REQUIRE(std::abs(scan.ranges[beam] - range) <= 4e-6 * range / 1.8 * range + 1e-6);
    }
  }
}

TEST_CASE("a point lies on its beam at its range") {
  needVulkan();
  const Sensor sensor = gridSensor(360, 31, -60, 60);
  const Scan scan = scanOf(sceneOf(soup(5, 2000, 20, 4)), sensor, {}, vulkanOptions());
  CHECK(scan.counters.hits > 1000);
  CHECK(scan.counters.misses > 0);
  for (size_t b = 0; b < scan.beamCount(); ++b) {
    if (!scan.hit(b)) {
      REQUIRE((std::isnan(scan.ranges[b]) && std::isnan(scan.points[3 * b]) && scan.instances[b] == kNoTriangle));
      continue;
    }
    const Vec3 d = sensor.direction(b);
    const double r = scan.ranges[b];
    REQUIRE(std::abs(scan.points[3 * b] - r * d.x) <= 5e-7 * r);
    REQUIRE(std::abs(scan.points[3 * b + 1] - r * d.y) <= 5e-7 * r);
    REQUIRE(std::abs(scan.points[3 * b + 2] - r * d.z) <= 5e-7 * r);
  }
}

TEST_CASE("the range window applies to each hit: nearer hits are ignored, farther ones are misses", "[second-driver]") {
  needVulkan();
  MeshBuilder builder;
  builder.quad({2, -50, -50}, {0, 100, 0}, {0, 0, 100});
  builder.quad({4, -50, -50}, {0, 100, 0}, {0, 0, 100});
  builder.quad({90, -50, -50}, {0, 100, 0}, {0, 0, 100});
  const Scene scene = sceneOf(builder.take());
  Sensor sensor = gridSensor(720, 21, -20, 20, 60);
  sensor.rangeMin = 3;
  const Scan scan = scanOf(scene, sensor, {}, vulkanOptions());
  requireSame(referenceOf(scene, sensor, {}), scan);
  size_t nearer = 0, farther = 0, doubtful = 0;
  for (size_t b = 0; b < scan.beamCount(); ++b) {
    const Vec3 d = sensor.direction(b);
    // How far within the window and the wall at x a beam meets it; the last wall is out of range everywhere.
    const auto within = [&](double x) {
      const double range = d.x > 0 ? x / d.x : 0;
      return std::min({range - 3, 60 - range, 50 - std::abs(range * d.y), 50 - std::abs(range * d.z)});
    };
    const double first = within(2), second = within(4);
    if (std::min(std::abs(first), std::abs(second)) < 1e-3) {
      ++doubtful;
      continue;
    }
    INFO("beam " << b);
    REQUIRE(scan.hit(b) == (std::max(first, second) > 0));
    if (!scan.hit(b)) continue;
    const double range = (first > 0 ? 2 : 4) / d.x;
    REQUIRE(std::abs(scan.ranges[b] - range) < 1e-5 * range);
    ++(first > 0 ? nearer : farther);
  }
  CHECK(nearer > 100);
  CHECK(farther > 100);
  CHECK(doubtful < 10);
}

TEST_CASE("owners are the instance and the triangle within its mesh", "[second-driver]") {
  needVulkan();
  Scene scene = sceneOf(ball(16, 32, 1));
  scene.instances.clear();
  MeshBuilder nothing;
  scene.meshes.push_back(nothing.take());
  for (int i = 0; i < 40; ++i) {
    scene.instances.push_back({"", 0, rotationZ(0.157 * i) * translation(8, 0, 0.3 * (i % 5))});
    if (i % 7 == 0) scene.instances.push_back({"empty", 1, {}});
  }
  const Sensor sensor = gridSensor(1500, 40, -20, 20);
  requireSame(referenceOf(scene, sensor, {}), scanOf(scene, sensor, {}, vulkanOptions()));
}

TEST_CASE("random triangles with unusual sensors and poses match the reference") {
  needVulkan();
  for (uint32_t seed = 1; seed <= 6; ++seed) {
    Random uniform(seed);
    Scene scene = sceneOf(soup(seed, 3000, 20, seed % 2 ? 1 : 8), seed % 3 != 0);
    for (int k = 0; k < 3; ++k)
      scene.instances.push_back({"", 0,
                                 translation(10 * uniform(), 10 * uniform(), 10 * uniform()) *
                                     rotationZ(3 * uniform()) * scaling(1 + 0.5 * uniform(), k == 0 ? -1 : 1, 1)});
    Sensor sensor{"odd", 613 + seed, {}, 0.5, 45};
    for (int j = 0; j < 33; ++j) sensor.channels.push_back({88 * uniform(), seed % 2 ? 9 * uniform() : 0});
    const Pose pose = {{5 * uniform(), 5 * uniform(), 5 * uniform()}, {uniform(), uniform(), uniform(), uniform()}};
    INFO("seed " << seed);
    requireSame(referenceOf(scene, sensor, pose), scanOf(scene, sensor, pose, vulkanOptions()));
  }
}

TEST_CASE("a town matches the reference for VLP-16 and HDL-64E") {
  needVulkan();
  const Scene town = makeTown({.triangles = 100'000});
  for (const Sensor& sensor : {builtinSensors()[0], builtinSensors()[2]}) {
    const Pose pose = {{1.3, 0.4, 1.8}, {0.01, -0.02, 0.3, 0.95}};
    requireSame(referenceOf(town, sensor, pose), scanOf(town, sensor, pose, vulkanOptions()));
  }
}

TEST_CASE("a world moved by 5,000 km gives the same ranges") {
  needVulkan();
  Scene scene = sceneOf(soup(11, 3000, 20, 3));
  const Sensor sensor = gridSensor(900, 40, -40, 40);
  const Scan near = scanOf(scene, sensor, {{1.5, 0.25, 2}, {}}, vulkanOptions());
  scene.instances[0].transform = translation(5e6, -3e6, 1e6);
  const Scan far = scanOf(scene, sensor, {{5e6 + 1.5, -3e6 + 0.25, 1e6 + 2}, {}}, vulkanOptions());
  CHECK(sameBytes(near, far));
}

TEST_CASE("beams aimed at the corners and edges of closed meshes all hit") {
  needVulkan();
  // The sensor's beams pass through the ball's own corners: same rings, same segments, and half steps between.
  for (uint32_t segments : {36u, 100u}) {
    const Scene scene = sceneOf(ball(36, segments, 10));
    Sensor sensor{"aimed", segments * 2, {}, 0, 100};
    for (int ring = 0; ring <= 72; ++ring) sensor.channels.push_back({-90 + 2.5 * ring, 0});
    const Scan scan = scanOf(scene, sensor, {}, vulkanOptions());
    CHECK(scan.counters.misses == 0);
  }
}

TEST_CASE("paper loses returns on large triangles and counts them as misses") {
  needVulkan();
  MeshBuilder builder;
  builder.quad({-200, -200, 0}, {400, 0, 0}, {0, 400, 0});
  const Scene scene = sceneOf(builder.take());
  TestOptions options = vulkanOptions();
  options.accuracy = Accuracy::paper;
  const Pose pose = {{0.7, 0.3, 1.8}, {}};
  const Scan paper = scanOf(scene, builtinSensors()[2], pose, options);
  const Scan standard = scanOf(scene, builtinSensors()[2], pose, vulkanOptions());
  CHECK(paper.counters.hits * 2 < standard.counters.hits);
  CHECK(paper.counters.hits + paper.counters.misses == paper.beamCount());
}

TEST_CASE("exact counts how often integers were needed") {
  needVulkan();
  MeshBuilder builder;
  builder.box({-4, -4, -4}, {4, 4, 4}, 4);  // corners and edges exactly on beams at 0, 45 and 90 degrees
  const Scene scene = sceneOf(builder.take());
  TestOptions options = vulkanOptions();
  CHECK(scanOf(scene, builtinSensors()[0], {}, options).counters.integerSides == 0);
  options.accuracy = Accuracy::exact;
  const Scan aligned = scanOf(scene, gridSensor(360, 37, -90, 90), {}, options);
  CHECK(aligned.counters.integerSides > 0);
  CHECK(aligned.counters.misses == 0);
  options.tuning.float64 = false;
  const Scan single = scanOf(scene, gridSensor(360, 37, -90, 90), {}, options);
  CHECK(single.counters.integerRanges >= single.counters.hits);
  CHECK(sameBytes(aligned, single));

  // Lasers beside the axis of the head, too, need integers only where double precision cannot decide.
  options.tuning.float64 = true;
  const Scan head = scanOf(scene, builtinSensor("OS1-64"), {{0.3, 0.2, 0.1}, {}}, options);
  CHECK(head.counters.hits > 10'000);
  CHECK(head.counters.integerRanges * 100 < head.counters.hits);
}
