// SPDX-License-Identifier: Apache-2.0
// Step bin: all ways of binning give the same bytes, and lists that overflow are detected.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "support.hpp"
#include "town/town.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

namespace {

TestOptions optionsBy(Binning binning) {
  TestOptions options = vulkanOptions();
  options.tuning.binning = binning;
  return options;
}

Scan scanBy(Binning binning, const Scene& scene, const Sensor& sensor, const Pose& pose = {}) {
  return scanOf(scene, sensor, pose, optionsBy(binning));
}

// The reference takes seconds for a million beams, so it sees every tenth column of a large grid.
constexpr uint32_t kSkip = 10;

Scan referenceOfSome(const Scene& scene, Sensor sensor) {
  sensor.columns /= kSkip;
  return referenceOf(scene, sensor, {});
}

/// The beams of a scan that referenceOfSome() has, too.
Scan someOf(const Scan& scan) {
  Scan some;
  some.columns = scan.columns / kSkip;
  some.channels = scan.channels;
  for (size_t beam = 0; beam < scan.beamCount(); beam += kSkip) {
    some.ranges.push_back(scan.ranges[beam]);
    some.triangles.push_back(scan.triangles[beam]);
    some.instances.push_back(scan.instances[beam]);
    some.points.insert(some.points.end(), &scan.points[3 * beam], &scan.points[3 * beam] + 3);
  }
  return some;
}

void requireWaysAgree(const Scene& scene, const Sensor& sensor, const Pose& pose = {}) {
  const Scan nearest = scanBy(Binning::nearest, scene, sensor, pose);
  REQUIRE(sameBytes(nearest, scanBy(Binning::lists, scene, sensor, pose)));
  REQUIRE(sameBytes(nearest, scanBy(Binning::slabs, scene, sensor, pose)));
}

}  // namespace

TEST_CASE("lists, slabs and atomic binning give the same bytes on random triangles") {
  needVulkan();
  Scene scene;
  scene.materials.push_back(material(true));
  for (uint32_t i = 0; i < 3; ++i) {
    scene.meshes.push_back(soup(i + 1, 4000, 30, 4));
    scene.instances.push_back({"", i, translation(1000 * i, 0, 0)});
  }
  const Sensor sensor = gridSensor(700, 40, -40, 40);
  Simulator nearest = makeSimulator(scene, sensor, optionsBy(Binning::nearest)),
            lists = makeSimulator(scene, sensor, optionsBy(Binning::lists)),
            slabs = makeSimulator(scene, sensor, optionsBy(Binning::slabs));
  for (double x : {0, 1000, 2000}) {
    const Pose pose = {{x, 0, 0}, {}};
    const Scan scan = nearest.scan(pose);
    REQUIRE(scan.counters.hits > 1000);
    REQUIRE(sameBytes(scan, lists.scan(pose)));
    REQUIRE(sameBytes(scan, slabs.scan(pose)));
  }
}

TEST_CASE("lists, slabs and atomic binning give the same bytes in a town") {
  needVulkan();
  requireWaysAgree(makeTown({.triangles = 60'000}), builtinSensors()[0], {{0, 0, 1.8}, {}});
}

TEST_CASE("the rows of a triangle between two columns include all its beams", "[combinations]") {
  needVulkan();
  // The columns are from half a radian wide to less than a degree per subgroup. Some edges lie in the planes of
  // columns, over the poles or through the sensor; channels are with and without azimuth offsets.
  MeshBuilder room;
  room.box({-7, -5, -2}, {9, 6, 3}, 3);
  room.box({-40, -40, -30}, {40, 40, 30}, 1);
  Scene scene = sceneOf(room.take());
  scene.meshes.push_back(soup(9, 300, 20, 25));
  scene.instances.push_back({"", 1, {}});
  std::vector<Sensor> sensors;
  for (uint32_t columns : {12u, 100u, 720u, 3000u})
    for (bool offsets : {false, true}) {
      if (offsets != (columns == 12 || columns == 720) && !everyCombination()) continue;
      Sensor& sensor = sensors.emplace_back(gridSensor(columns, 40, -88, 90));
      for (size_t j = 0; offsets && j < sensor.channels.size(); ++j)
        sensor.channels[j].azimuthOffsetDeg = 7.3 * (double(j % 5) - 2.2);
    }
  Simulator slabs = makeSimulator(scene, sensors, optionsBy(Binning::slabs)),
            nearest = makeSimulator(scene, sensors, optionsBy(Binning::nearest));
  for (size_t i = 0; i < sensors.size(); ++i) {
    INFO(sensors[i].columns << " columns, second offset " << sensors[i].channels[1].azimuthOffsetDeg);
    const Scan scan = slabs.scan({}, i);
    requireSame(referenceOf(scene, sensors[i], {}), scan);
    REQUIRE(sameBytes(scan, nearest.scan({}, i)));
  }
}

TEST_CASE("the columns of a small triangle in a row include all its beams", "[combinations]") {
  needVulkan();
  // The triangles are round, or slivers along or across the rows. Triangles cover from none to some hundred beams and
  // lie up to 60 degrees above or below the horizon. On the way between its ends, an edge rises above the straight line
  // by up to one of 900 rows.
  Random uniform(5);
  MeshBuilder builder;
  for (int i = 0; i < 4000; ++i) {
    const double azimuth = std::numbers::pi * uniform(), elevation = 1.02 * uniform();
    const double width = 0.03 * std::pow(30.0, uniform()) / std::sqrt(30.0), height = 0.004 * std::pow(20.0, uniform());
    Vec3 corner[3];
    for (Vec3& p : corner) {
      const double turn = azimuth + width * uniform(), up = elevation + height * uniform(), range = 20 + uniform();
      p = {range * std::cos(up) * std::cos(turn), range * std::cos(up) * std::sin(turn), range * std::sin(up)};
    }
    builder.triangle(corner[0], corner[1], corner[2]);
  }
  const Scene scene = sceneOf(builder.take());
  std::vector<Sensor> sensors;
  for (uint32_t columns : {360u, 5000u})
    for (bool offsets : {false, true}) {
      if (offsets == (columns == 360) && !everyCombination()) continue;
      Sensor& sensor = sensors.emplace_back(gridSensor(columns, columns == 360 ? 900 : 200, -60, 60));
      for (size_t j = 0; offsets && j < sensor.channels.size(); ++j)
        sensor.channels[j].azimuthOffsetDeg = 1.3 * (double(j % 5) - 2.2);
    }
  std::vector<Scan> references;
  for (const Sensor& sensor : sensors) references.push_back(referenceOfSome(scene, sensor));
  for (Accuracy accuracy : {Accuracy::draft, Accuracy::standard, Accuracy::exact}) {
    if (accuracy == Accuracy::draft && !everyCombination()) continue;
    TestOptions options = optionsBy(Binning::slabs), other = optionsBy(Binning::lists);
    options.accuracy = other.accuracy = accuracy;
    Simulator slabs = makeSimulator(scene, sensors, options), lists = makeSimulator(scene, sensors, other);
    for (size_t i = 0; i < sensors.size(); ++i) {
      INFO(sensors[i].columns << " columns, first offset " << sensors[i].channels[0].azimuthOffsetDeg << ", accuracy "
                              << int(accuracy));
      const Scan scan = slabs.scan({}, i);
      REQUIRE(scan.counters.hits > 5'000);
      if (accuracy != Accuracy::draft) requireSame(references[i], someOf(scan));
      REQUIRE(sameBytes(scan, lists.scan({}, i)));
    }
  }
}

TEST_CASE("triangles with a corner on or near the sensor's axis keep all their beams") {
  needVulkan();
  std::vector<Sensor> sensors(2, gridSensor(1500, 60, -89, 89));
  for (size_t j = 0; j < sensors[1].channels.size(); ++j)
    sensors[1].channels[j].azimuthOffsetDeg = 0.31 * (double(j % 5) - 2.2);
  Scene all;
  all.materials.push_back(material(true));
  std::vector<std::string> names;
  for (double aside : {0.0, 1e-5, 1e-3})
    for (double height : {-2.0, -1e-4, 2.0}) {
      MeshBuilder fan;
      for (int i = 0; i < 12; ++i) {
        const double from = 0.5 * i, to = from + 0.4, end = height * (i % 5 - 1);
        fan.triangle({aside * std::cos(2.0 * i), aside * std::sin(2.0 * i), height},
                     {6 * std::cos(from), 6 * std::sin(from), end}, {4 * std::cos(to), 4 * std::sin(to), end});
      }
      all.meshes.push_back(fan.take());
      names.push_back("a corner at " + std::to_string(aside) + " from the axis, at height " + std::to_string(height));
    }
  Simulator simulator = makeSimulator(all, sensors, optionsBy(Binning::slabs));
  for (uint32_t mesh = 0; mesh < all.meshes.size(); ++mesh) {
    const Scene scene = sceneOf(Mesh(all.meshes[mesh]));
    const size_t instance = simulator.addInstance(mesh, {});
    for (size_t i = 0; i < sensors.size(); ++i) {
      INFO(names[mesh] << ", offsets " << i);
      const Scan reference = referenceOf(scene, sensors[i], {});
      REQUIRE(reference.counters.hits > 0);
      requireSame(reference, simulator.scan({}, i));
    }
    simulator.removeInstance(instance);
  }
}

TEST_CASE("among triangles at equal range, the one with the lowest index owns the beam, in any spatial order") {
  needVulkan();
  MeshBuilder builder;
  for (int copy = 0; copy < 5; ++copy) builder.quad({4, -3, -3}, {0, 6, 0}, {0, 0, 6}, 6);
  const Scene scene = sceneOf(builder.take());
  const Sensor sensor = gridSensor(720, 50, -30, 30);
  requireWaysAgree(scene, sensor);
  const Scan scan = scanBy(Binning::nearest, scene, sensor);
  CHECK(scan.counters.hits > 1000);
  for (size_t b = 0; b < scan.beamCount(); ++b)
    if (scan.hit(b)) REQUIRE(scan.triangles[b] < 72);
}

TEST_CASE("a candidate list that is too small grows, the scan runs again, and no hit is lost", "[second-driver]") {
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

TEST_CASE("more triangles and tiles than the lists had room for are all projected") {
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
  TestOptions options = vulkanOptions();
  options.validation = false;  // for speed; smaller tests run this path with the layer
  Simulator simulator = makeSimulator(scene, sensor, options);
  const Scan scan = simulator.scan({});
  CHECK(scan.counters.retries >= 1);
  CHECK(scan.counters.projected > 1u << 18);
  CHECK(scan.counters.misses == 0);
  const Scan again = simulator.scan({});
  CHECK(again.counters.retries == 0);
  CHECK(sameBytes(again, scan));
  requireSame(referenceOfSome(scene, sensor), someOf(scan));
}

TEST_CASE("the order of triangles and instances changes only indices") {
  needVulkan();
  const Mesh original = soup(7, 1000, 25, 5);
  Scene scene = sceneOf(Mesh(original));
  for (int i = 1; i < 4; ++i) scene.instances.push_back({"", 0, translation(2 * i, -3 * i, 0.5 * i) * rotationZ(i)});
  const std::vector<Instance> instances = scene.instances;
  const Sensor sensor = gridSensor(500, 40, -40, 40);
  const Scan expected = scanOf(scene, sensor, {}, vulkanOptions());
  CHECK(expected.counters.hits > 10'000);
  Random random(3);
  const auto shuffledOrder = [&](size_t count) {
    std::vector<uint32_t> order(count);
    for (uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    for (size_t i = order.size() - 1; i > 0; --i) std::swap(order[i], order[random.bits() % (i + 1)]);
    return order;
  };
  for (int round = 0; round < 3; ++round) {
    const std::vector<uint32_t> order = shuffledOrder(original.triangleCount()), ofInstances = shuffledOrder(4);
    for (size_t i = 0; i < order.size(); ++i)
      std::copy_n(&original.indices[3 * size_t{order[i]}], 3, &scene.meshes[0].indices[3 * i]);
    for (size_t i = 0; i < 4; ++i) scene.instances[i] = instances[ofInstances[i]];
    const Scan scan = scanOf(scene, sensor, {}, vulkanOptions());
    REQUIRE(sameBytes(scan.ranges, expected.ranges));
    for (size_t b = 0; b < scan.beamCount(); ++b) {
      if (!scan.hit(b)) continue;
      REQUIRE(order[scan.triangles[b]] == expected.triangles[b]);
      REQUIRE(ofInstances[scan.instances[b]] == expected.instances[b]);
    }
  }
}
