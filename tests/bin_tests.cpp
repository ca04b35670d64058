// SPDX-License-Identifier: Apache-2.0
// Stage bin: the ways of giving triangles to beams agree to the byte, and no list overflows unseen.
#include <algorithm>

#include "support.hpp"
#include "town/town.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

namespace {

Scan scanBy(Binning binning, const Scene& scene, const Sensor& sensor, const Pose& pose = {}) {
  SimulatorOptions options = vulkanOptions();
  options.binning = binning;
  return scanOf(scene, sensor, pose, options);
}

void requireWaysAgree(const Scene& scene, const Sensor& sensor, const Pose& pose = {}) {
  const Scan nearest = scanBy(Binning::nearest, scene, sensor, pose);
  REQUIRE(sameBytes(nearest, scanBy(Binning::lists, scene, sensor, pose)));
  REQUIRE(sameBytes(nearest, scanBy(Binning::slabs, scene, sensor, pose)));
}

}  // namespace

TEST_CASE("lists, slabs and atomic minima give the same bytes on a soup of triangles") {
  needVulkan();
  for (uint32_t seed : {1u, 2u, 3u}) requireWaysAgree(sceneOf(soup(seed, 4000, 30, 4)), gridSensor(700, 40, -40, 40));
}

TEST_CASE("lists, slabs and atomic minima give the same bytes in a town") {
  needVulkan();
  requireWaysAgree(makeTown({.triangles = 60'000}), builtinSensors()[0], {{0, 0, 1.8}, {}});
}

TEST_CASE("the rows that a triangle has between two columns leave out none of its beams") {
  needVulkan();
  // From columns of half a radian to more than a subgroup's in a degree; edges in the columns' own planes, over the
  // poles, through the sensor; channels with and without offsets of their own.
  MeshBuilder room;
  room.box({-7, -5, -2}, {9, 6, 3}, 3);
  room.box({-40, -40, -30}, {40, 40, 30}, 1);
  Scene scene = sceneOf(room.take());
  scene.meshes.push_back(soup(9, 300, 20, 25));
  scene.instances.push_back({"", 1, {}});
  for (uint32_t columns : {12u, 100u, 720u, 3000u})
    for (bool offsets : {false, true}) {
      INFO(columns << " columns, offsets " << offsets);
      Sensor sensor = gridSensor(columns, 40, -88, 90);
      for (size_t j = 0; offsets && j < sensor.channels.size(); ++j)
        sensor.channels[j].azimuthOffsetDeg = 7.3 * (double(j % 5) - 2.2);
      const Scan slabs = scanBy(Binning::slabs, scene, sensor);
      requireSame(referenceOf(scene, sensor, {}), slabs);
      REQUIRE(sameBytes(slabs, scanBy(Binning::nearest, scene, sensor)));
    }
}

TEST_CASE("triangles with a corner on the sensor's axis, or next to it, leave out none of their beams") {
  needVulkan();
  for (double aside : {0.0, 1e-5, 1e-3})
    for (double height : {-2.0, -1e-4, 2.0})
      for (bool offsets : {false, true}) {
        INFO("a corner at " << aside << " from the axis, at height " << height << ", offsets " << offsets);
        MeshBuilder fan;
        for (int i = 0; i < 12; ++i) {
          const double from = 0.5 * i, to = from + 0.4, end = height * (i % 5 - 1);
          fan.triangle({aside * std::cos(2.0 * i), aside * std::sin(2.0 * i), height},
                       {6 * std::cos(from), 6 * std::sin(from), end}, {4 * std::cos(to), 4 * std::sin(to), end});
        }
        const Scene scene = sceneOf(fan.take());
        Sensor sensor = gridSensor(1500, 60, -89, 89);
        for (size_t j = 0; offsets && j < sensor.channels.size(); ++j)
          sensor.channels[j].azimuthOffsetDeg = 0.31 * (double(j % 5) - 2.2);
        requireSame(referenceOf(scene, sensor, {}), scanBy(Binning::slabs, scene, sensor));
      }
}

TEST_CASE("of triangles at equal range the lowest index owns the beam, whatever their order in space") {
  needVulkan();
  MeshBuilder builder;
  for (int copy = 0; copy < 5; ++copy) builder.quad({4, -3, -3}, {0, 6, 0}, {0, 0, 6}, 6);
  const Scene scene = sceneOf(builder.take());
  const Sensor sensor = gridSensor(720, 50, -30, 30);
  requireWaysAgree(scene, sensor);
  const Scan scan = scanBy(Binning::nearest, scene, sensor);
  for (size_t b = 0; b < scan.beamCount(); ++b)
    if (scan.hit(b)) REQUIRE(scan.triangles[b] < 72);
}

TEST_CASE("a candidate list that is too small grows, the scan runs again and nothing is lost", "[second-driver]") {
  needVulkan();
  MeshBuilder builder;
  for (int layer = 0; layer < 12; ++layer)
    builder.box({-9.0 - layer, -9.0 - layer, -9.0 - layer}, {9.0 + layer, 9.0 + layer, 9.0 + layer}, 4);
  const Scene scene = sceneOf(builder.take());
  const Sensor sensor = gridSensor(360, 45, -88, 88);
  const Scan lists = scanBy(Binning::lists, scene, sensor);
  CHECK(lists.counters.retries >= 1);
  CHECK(lists.counters.candidates >= 12 * sensor.beamCount());
  CHECK(lists.counters.misses == 0);
  CHECK(sameBytes(lists, scanBy(Binning::nearest, scene, sensor)));
}

TEST_CASE("more triangles and tiles than the lists were made for are all projected") {
  needVulkan();
  // 500,000 triangles that each cover a beam, and 5,000 that each cover most of the sensor.
  Scene scene = sceneOf(ball(500, 500, 20));
  MeshBuilder builder;
  for (int i = 0; i < 5000; ++i) {
    const double r = 30 + 0.01 * i;
    builder.triangle({r, -3 * r, -2 * r}, {r, 3 * r, -2 * r}, {r, 0, 3 * r});
  }
  scene.meshes.push_back(builder.take());
  scene.instances.push_back({"", 1, {}});
  const Sensor sensor = gridSensor(2000, 300, -80, 80);
  SimulatorOptions options = vulkanOptions();
  options.validation = false;  // speed: the layer has seen this path in the smaller tests
  Simulator simulator(scene, sensor, options);
  const Scan scan = simulator.scan({});
  CHECK(scan.counters.retries >= 1);
  CHECK(scan.counters.projected > 1u << 18);
  CHECK(scan.counters.misses == 0);
  CHECK(simulator.scan({}).counters.retries == 0);
  requireSame(referenceOf(scene, sensor, {}), scan);
}

TEST_CASE("the order of triangles and instances changes indices and nothing else") {
  needVulkan();
  const Mesh original = soup(7, 3000, 25, 5);
  const Sensor sensor = gridSensor(500, 40, -40, 40);
  const Scan expected = scanOf(sceneOf(Mesh(original)), sensor, {}, vulkanOptions());
  Random random(3);
  for (int round = 0; round < 3; ++round) {
    std::vector<uint32_t> order(original.triangleCount());
    for (uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    for (size_t i = order.size() - 1; i > 0; --i) std::swap(order[i], order[random.bits() % (i + 1)]);
    Mesh shuffled = original;
    for (size_t i = 0; i < order.size(); ++i)
      std::copy_n(&original.indices[3 * size_t{order[i]}], 3, &shuffled.indices[3 * i]);
    const Scan scan = scanOf(sceneOf(std::move(shuffled)), sensor, {}, vulkanOptions());
    REQUIRE(sameBytes(scan.ranges, expected.ranges));
    for (size_t b = 0; b < scan.beamCount(); ++b)
      if (scan.hit(b)) REQUIRE(order[scan.triangles[b]] == expected.triangles[b]);
  }
}
