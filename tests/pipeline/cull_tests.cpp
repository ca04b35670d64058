// SPDX-License-Identifier: Apache-2.0
// Culling: every culling switch leaves the bytes of the cloud unchanged.
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <cmath>
#include <numbers>

#include "common/shared.h"
#include "lists/list_sensors.hpp"
#include "support.hpp"
#include "town/town.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

namespace {

Culling nothing() {
  return {false, false, false, false, Culling::Occlusion::never};
}

struct Switch {
  const char* name;
  Culling culling;
};

std::vector<Switch> switches() {
  using O = Culling::Occlusion;
  return {{"range", {true, false, false, false, O::never}},        {"rows", {false, true, false, false, O::never}},
          {"columns", {false, false, true, false, O::never}},      {"cones", {false, false, false, true, O::never}},
          {"occlusion", {false, false, false, false, O::always}},  {"all", {true, true, true, true, O::always}},
          {"all but range", {false, true, true, true, O::always}}, {"automatic", {}}};
}

TestOptions optionsWith(Accuracy accuracy, Culling culling) {
  TestOptions options = vulkanOptions();
  options.accuracy = accuracy;
  options.tuning.culling = culling;
  return options;
}

Scan scanWith(const Scene& scene, const Sensor& sensor, const Pose& pose, Accuracy accuracy, Culling culling) {
  return scanOf(scene, sensor, pose, optionsWith(accuracy, culling));
}

// True for a software device. A graphics card has fewer shells, and works on most triangles of a shell at once.
bool onCpu(const Simulator& simulator) {
  return simulator.device().type == "cpu";
}

// A round wall of `segments` quads, in `rings` rows, without the segment `leftOut`.
Mesh wallAround(double radius, uint32_t segments, uint32_t rings, uint32_t leftOut) {
  Mesh mesh;
  for (uint32_t i = 0; i < segments; ++i)
    for (uint32_t j = 0; j <= rings; ++j) {
      // Segment i is centred on the azimuth of column i of a sensor with `segments` columns.
      const double azimuth = -std::numbers::pi + 2 * std::numbers::pi * (i - 0.5) / segments;
      mesh.positions.push_back(static_cast<float>(radius * std::cos(azimuth)));
      mesh.positions.push_back(static_cast<float>(radius * std::sin(azimuth)));
      mesh.positions.push_back(static_cast<float>(radius * (double(j) / rings - 0.5)));
    }
  for (uint32_t i = 0; i < segments; ++i)
    for (uint32_t j = 0; j < rings && i != leftOut; ++j) {
      const uint32_t a = i * (rings + 1) + j, b = (i + 1) % segments * (rings + 1) + j;
      for (uint32_t corner : {a, b, a + 1, b, b + 1, a + 1}) mesh.indices.push_back(corner);
    }
  mesh.parts = {{0, static_cast<uint32_t>(mesh.triangleCount()), 0}};
  return mesh;
}

}  // namespace

TEST_CASE("culling: every switch leaves the cloud of a town unchanged", "[combinations]") {
  needVulkan();
  const Scene town = makeTown({60'000, 3});
  const Accuracy accuracy = GENERATE(Accuracy::standard, Accuracy::exact);
  const Pose pose = {{-7.5, 1.25, 1.8}, {0.02, -0.03, 0.6, 0.8}};
  // The channels have azimuth offsets, and the columns do not fill the last entry of the farthest-range table.
  Sensor shifted = builtinSensor("VLP-16");
  shifted.columns = 1237;
  for (size_t j = 0; j < shifted.channels.size(); ++j) shifted.channels[j].azimuthOffsetDeg = 37.0 * double(j % 5) - 60;
  const std::vector<Sensor> sensors = {builtinSensor("VLP-32"), shifted};
  Simulator without = makeSimulator(town, sensors, optionsWith(accuracy, nothing()));
  const Scan full[] = {without.scan(pose, 0), without.scan(pose, 1)};
  for (const Scan& scan : full) CHECK(scan.counters.culledByCluster == 0);
  for (const auto& [name, culling] : switches()) {
    // The accuracy has no part in culling, but for the corners that it rounds.
    if (accuracy == Accuracy::exact && std::string(name) != "all" && !everyCombination()) continue;
    const size_t first = std::string(name) == "all" || everyCombination() ? 0 : 1;
    Simulator simulator = makeSimulator(town, {sensors.begin() + static_cast<std::ptrdiff_t>(first), sensors.end()},
                                        optionsWith(accuracy, culling));
    for (size_t i = first; i < sensors.size(); ++i) {
      INFO(sensors[i].name << ", " << name);
      CHECK(sameBytes(full[i], simulator.scan(pose, i - first)));
    }
  }
}

TEST_CASE("culling: every switch leaves the cloud unchanged that the first-corner cull gives") {
  needVulkan();
  using Cull = AccuracyParts::Cull;
  const bool ground = GENERATE(false, true);
  // In a town many triangles have their first corner out of range and others in range. On the ground few beams meet a
  // cluster, and those of one row meet triangles on the edge of the range, 1.8 m / sin 11 degrees away.
  MeshBuilder builder;
  builder.quad({-20, -20, -1.8}, {40, 0, 0}, {0, 40, 0}, 133);
  const Scene scene = ground ? sceneOf(builder.take()) : makeTown({60'000, 3});
  const Sensor sensor = ground ? gridSensor(72, 16, -25, 5, 9.45) : gridSensor(500, 48, -30, 20, 25);
  const Pose pose = ground ? Pose{} : Pose{{-7.5, 1.25, 1.8}, {0.02, -0.03, 0.6, 0.8}};
  const auto scan = [&](Cull cull, Culling culling) {
    TestOptions options = optionsWith(Accuracy::standard, culling);
    options.accuracyParts = accuracyPartsOf(Accuracy::standard);
    options.accuracyParts->cull = cull;
    return scanOf(scene, sensor, pose, options);
  };
  const Scan full = scan(Cull::firstCorner, nothing());
  CHECK(full.counters.culledByCluster == 0);
  CHECK(full.counters.hits < scan(Cull::nearestPoint, nothing()).counters.hits);
  for (const auto& [name, culling] : switches()) {
    CAPTURE(ground, name);
    const Scan culled = scan(Cull::firstCorner, culling);
    CHECK(sameBytes(full, culled));
    if (std::string(name) == "all") CHECK(culled.counters.culledByCluster > 0);
  }
}

TEST_CASE("culling: many shells leave the cloud of a town unchanged") {
  needVulkan();
  const Scene town = makeTown({60'000, 3});
  const Sensor sensor = gridSensor(2603, 200, -30, 30, 80);
  TestOptions options = vulkanOptions();
  options.tuning.binning = Binning::slabs;
  options.tuning.culling.occlusion = Culling::Occlusion::always;
  Simulator shells = makeSimulator(town, sensor, options);
  const std::vector<Plan::Stage> stages = shells.plan().stages;
  REQUIRE(stages[0].dispatches >= 2 + 2 * (onCpu(shells) ? 10 : 2));
  const Pose pose = {{-7.5, 1.25, 1.8}, {0.02, -0.03, 0.6, 0.8}};
  const Scan scan = shells.scan(pose);
  CHECK(scan.counters.culledHidden > 0);
  CHECK(sameBytes(scan, scanWith(town, sensor, pose, Accuracy::standard, nothing())));
}

TEST_CASE("culling: a mesh of one cluster that reaches through several shells is projected once") {
  needVulkan();
  // Walls that lead away from the sensor, each from another distance on; none hides another one.
  Scene scene;
  for (uint32_t i = 0; i < 8; ++i) {
    const float from = 3.0f + 4.0f * static_cast<float>(i), up = 0.25f * from;
    Mesh wall;
    wall.positions = {from, 0, -up, 60, 20, -up, 60, 20, up, from, 0, up};
    wall.indices = {0, 1, 2, 0, 2, 3};
    wall.parts = {{0, 2, 0}};
    scene.meshes.push_back(wall);
    const double c = std::cos(0.7 * i), s = std::sin(0.7 * i);
    scene.instances.push_back({"", i, {}});
    scene.instances.back().transform.rows = {c, -s, 0, 0, s, c, 0, 0, 0, 0, 1, 0};
  }
  scene.materials.push_back({});
  TestOptions options = vulkanOptions();
  options.faces = ReflectingFaces::both;
  options.tuning.binning = GENERATE(Binning::slabs, Binning::nearest);
  options.tuning.culling.occlusion = Culling::Occlusion::always;
  const Scan scan = scanOf(scene, gridSensor(700, 40, -24, 24, 100), {}, options);
  CHECK(scan.counters.projected == 16);
  CHECK(scan.counters.culledByCluster == 0);
}

TEST_CASE("culling: clusters are bounded by the time in which the beams that see them fire") {
  needVulkan();
  const Sensor sensor = builtinSensor("VLP-32C");
  TestOptions options = vulkanOptions();
  options.effects.sensorMotion.use = EffectUse::on;
  Simulator simulator = makeSimulator(makeTown({300'000, 1}), sensor, options);
  // The sensor drives at 15 m/s and turns at 30 degrees per second.
  const Pose start = {{-60, 0, 1.8}, {}}, end = {{-58.5, 0, 1.8}, {0, 0, 0.0261769, 0.9996573}};
  const auto projectedTo = [&](const Pose& last) {
    Shot shot;
    shot.motion.stamps = {{0, start}, {sensor.rotationPeriod, last}};
    uint64_t projected = 0;
    simulator.scanAll({&shot, 1}, [&](size_t, const Scan& scan) { projected = scan.counters.projected; });
    return projected;
  };
  const uint64_t still = projectedTo(start), moving = projectedTo(end);
  INFO(still << " triangles projected at rest, " << moving << " in motion");
  CHECK(moving < 9 * still / 4);  // bounds of the whole scan's motion let three times as many through
}

TEST_CASE("culling: what near triangles hide is skipped in a small scene, too") {
  needVulkan();
  const Scene town = makeTown({40'000, 3});
  const Pose pose = {{0, 0, 1.8}, {}};
  Culling culling;
  const Scan scan = scanWith(town, builtinSensor("VLP-16"), pose, Accuracy::standard, culling);
  culling.occlusion = Culling::Occlusion::never;
  const Scan seen = scanWith(town, builtinSensor("VLP-16"), pose, Accuracy::standard, culling);
  // On a CPU more than a twentieth of the triangles; on graphics cards, with fewer shells, a fortieth.
  CHECK(scan.counters.culledByCluster > seen.counters.culledByCluster + town.placedTriangleCount() / 100);
  CHECK(sameBytes(scan, seen));
}

TEST_CASE("culling: shells are chosen after a scan of a small scene has found many triangles over each other") {
  needVulkan();
  MeshBuilder builder;
  builder.box({-3, -0.05, -1}, {3, 0.05, 1.5});
  Scene scene = sceneOf(builder.take());
  scene.instances.clear();
  for (int i = 0; i < 600; ++i) {
    const auto place = [&](double step) { return 20 * std::fmod(step * i, 1) - 10; };
    scene.instances.push_back({"", 0, translation(place(0.618), place(0.755), 0) * rotationZ(2.4 * i)});
  }
  const Sensor sensor = gridSensor(1080, 4, -10, 10, 60);
  Simulator simulator = makeSimulator(scene, sensor, vulkanOptions());
  if (!onCpu(simulator)) return;
  // The sensor moves between scans, so that no scan reuses the hits of the one before.
  const auto scanOf = [&](int turn) { return simulator.scan({{0, 0, 0.01 * turn}, {}}); };
  const Scan first = scanOf(0), second = scanOf(1), again = scanOf(0);
  CHECK(second.counters.projected * 2 < first.counters.projected);
  CHECK(again.counters.projected * 2 < first.counters.projected);
  CHECK(sameBytes(again, first));
  requireSame(referenceOf(scene, sensor, {}), again);
  // Without the walls a scan has one shell again, and with them it needs to find out anew.
  for (size_t i = 1; i < 600; ++i) simulator.removeInstance(i);
  scanOf(2);
  const std::vector<Instance> walls(scene.instances.begin() + 1, scene.instances.end());
  simulator.addInstances(walls);
  CHECK(scanOf(0).counters.projected * 2 > first.counters.projected);
  CHECK(scanOf(1).counters.projected * 2 < first.counters.projected);
}

TEST_CASE("culling: what comes into a scene counts when shells are chosen, as if it had been there") {
  needVulkan();
  const Scene town = makeTown({.triangles = 60'000, .seed = 3});
  const Sensor sensor = gridSensor(360, 16, -15, 15, 100);
  Simulator whole = makeSimulator(town, sensor, vulkanOptions()),
            filled = makeSimulator(Scene{}, sensor, vulkanOptions());
  filled.addScene(town);
  const Pose pose = {{0, 0, 1.8}, {}};
  const Scan expected = whole.scan(pose), scan = filled.scan(pose);
  CHECK(sameBytes(scan, expected));
  CHECK(filled.plan().stages[0].dispatches == whole.plan().stages[0].dispatches);
}

TEST_CASE("culling: what triangles of the same shell hide is skipped") {
  needVulkan();
  // Mostly, stage project tries the small triangles of the near wall before it comes to those of the far one. The order
  // is that in which threads list clusters, so one of several scans must have it.
  Scene scene = sceneOf(wallAround(10, 360, 20, 360));
  scene.meshes.push_back(wallAround(40, 360, 20, 360));
  scene.instances.push_back({"", 1, {}});
  TestOptions options = vulkanOptions();
  options.faces = ReflectingFaces::both;
  options.tuning.binning = Binning::slabs;
  options.tuning.keepStill = false;
  const Sensor sensor = gridSensor(700, 40, -24, 24, 100);
  Simulator oneShell = makeSimulator(scene, sensor, options);
  REQUIRE(oneShell.plan().stages[0].dispatches == 3);
  uint64_t most = 0;
  options.tuning.culling.occlusion = Culling::Occlusion::never;
  const Scan seen = scanOf(scene, sensor, {}, options);
  CHECK(seen.counters.culledByCluster == 0);
  for (int i = 0; i < 20; ++i) {
    const Scan scan = oneShell.scan({});
    most = std::max(most, scan.counters.culledByCluster);
    CHECK(sameBytes(scan, seen));
  }
  if (onCpu(oneShell)) CHECK(most > scene.meshes[1].triangleCount() / 4);
}

TEST_CASE("culling: few beams tried on all triangles of a cluster find what each triangle's own beams find") {
  needVulkan();
  // Balls of small triangles: a cluster lies between few beams, and most of these pass it.
  Scene scene;
  scene.materials.push_back(material(true));
  for (uint32_t i = 0; i < 60; ++i) {
    const double angle = 2.4 * i, far = 4 + 0.7 * i;
    scene.meshes.push_back(
        ball(24, 48, 0.7, {far * std::cos(angle), far * std::sin(angle), 0.1 * far * std::sin(5.0 * i)}));
    scene.instances.push_back({"", i, {}});
  }
  const std::vector<Sensor> heads = {gridSensor(1800, 16, -15, 15, 100), builtinSensor("Puck")};
  TestOptions options = vulkanOptions();
  options.tuning.culling.occlusion = GENERATE(Culling::Occlusion::always, Culling::Occlusion::never);
  options.tuning.binning = Binning::nearest;
  Simulator byTriangle = makeSimulator(scene, heads, options);
  options.tuning.binning = Binning::slabs;
  Simulator byCluster = makeSimulator(scene, heads, options);
  for (size_t head = 0; head < heads.size(); ++head)
    for (uint32_t k = 0; k < 3; ++k) {
      const Pose pose = {{0.3 * k, 0.1, 0.05 * k}, {}};
      const Scan expected = byTriangle.scan(pose, head), scan = byCluster.scan(pose, head);
      CHECK(scan.counters.hits > 500);
      CHECK(sameBytes(expected, scan));
      CHECK(scan.counters.culledBetweenBeams < expected.counters.culledBetweenBeams / 4);
    }
}

TEST_CASE("culling: hidden triangles, and those out of range or between beams, are skipped") {
  needVulkan();
  const Scene town = makeTown({200'000, 1});
  const Sensor sensor = builtinSensor("HDL-64E");
  const Pose pose = {{0, 0, 1.8}, {}};
  const auto culled = [&](Culling culling) {
    return scanWith(town, sensor, pose, Accuracy::standard, culling).counters.culledByCluster;
  };
  using O = Culling::Occlusion;
  CHECK(culled({true, false, false, false, O::never}) > 0);
  CHECK(culled({false, true, false, false, O::never}) > 0);
  CHECK(culled({false, false, false, false, O::always}) > town.placedTriangleCount() / 10);
  CHECK(culled({true, true, true, true, O::always}) > culled({true, true, true, true, O::never}));
  const auto hidden = [&](O occlusion) {
    return scanWith(town, sensor, pose, Accuracy::standard, {true, true, true, true, occlusion}).counters.culledHidden;
  };
  CHECK(hidden(O::always) > 0);
  CHECK(hidden(O::never) == 0);
}

TEST_CASE("culling: the far side of a one-sided ball is skipped from any side and with any transform") {
  needVulkan();
  const Sensor sensor = gridSensor(720, 90, -89, 89, 60);
  const Culling cones = {false, false, false, true, Culling::Occlusion::never};
  const Scene scene = sceneOf(ball(60, 90, 3), false);
  Simulator without = makeSimulator(scene, sensor, optionsWith(Accuracy::standard, nothing()));
  Simulator with = makeSimulator(scene, sensor, optionsWith(Accuracy::standard, cones));
  for (const Transform& placed : {translation(9, 1, 0.5), translation(6, -4, 2) * rotationZ(2) * scaling(2, 2, 2),
                                  translation(0, 8, 1) * scaling(-1, 1, 1), translation(0, 0, 0)}) {
    without.setTransform(0, placed);
    with.setTransform(0, placed);
    const Scan full = without.scan({}), scan = with.scan({});
    CHECK(sameBytes(full, scan));
    // From inside every triangle is back-facing, and from the centre the cone of every cluster tells so.
    CHECK(scan.counters.culledByCluster > scene.placedTriangleCount() / 4);
  }
  // A stretched instance has other normals than its cone assumes, so the cone is not used.
  Scene stretched = sceneOf(ball(60, 90, 3), false);
  stretched.instances[0].transform = translation(9, 1, 0.5) * scaling(1, 2, 1);
  const Scan scan = scanWith(stretched, sensor, {}, Accuracy::standard, cones);
  CHECK(scan.counters.culledByCluster == 0);
  requireSame(referenceOf(stretched, sensor, {}), scan);
}

TEST_CASE("culling: geometry visible through one column of a wall is seen, also at the azimuth seam") {
  needVulkan();
  // The columns do not fill the table's last entry, so what wraps around lies across a narrower entry.
  const uint32_t columns = 101;
  const Sensor sensor = gridSensor(columns, 5, -8, 8, 40);
  // The clusters of the far wall are narrower or wider than the last entry of the table.
  const uint32_t segments = GENERATE(404u, 120u);
  const uint32_t gaps[] = {0, 3, 4, 7, 50, 95, 96, 100};
  Scene scene = sceneOf(wallAround(20, segments, 4, segments));
  for (uint32_t gap : gaps) scene.meshes.push_back(wallAround(3, columns, 1, gap));
  Simulator without = makeSimulator(scene, sensor, optionsWith(Accuracy::standard, nothing()));
  const Culling occlusion = {false, false, false, false, Culling::Occlusion::always};
  Simulator with = makeSimulator(scene, sensor, optionsWith(Accuracy::standard, occlusion));
  for (uint32_t i = 0; i < std::size(gaps); ++i) {
    INFO("column " << gaps[i]);
    const size_t near = without.addInstance(1 + i, {});
    REQUIRE(with.addInstance(1 + i, {}) == near);
    const Scan full = without.scan({}), scan = with.scan({});
    CHECK(full.ranges[2 * columns + gaps[i]] > 19);
    CHECK(sameBytes(full, scan));
    if (segments == 404 && onCpu(with)) CHECK(scan.counters.culledByCluster > scene.meshes[0].triangleCount() / 4);
    without.removeInstance(near);
    with.removeInstance(near);
  }
}

// The beams of a list lie anywhere in their cells, also in the last ones of an entry of the table.
TEST_CASE("culling: geometry visible through a gap is seen by every beam of a list") {
  needVulkan();
  const uint32_t columns = 101;
  Sensor sensor = asList(gridSensor(columns, 5, -8, 8, 40));
  Random random(4);
  for (size_t i = 0; i < sensor.beamCount(); ++i)
    sensor.patterns[0].directions[i] =
        directionAt(2 * std::numbers::pi * (double(i % columns) + 0.3 * random()) / columns - std::numbers::pi,
                    0.07 * (double(i / columns) - 2) + 0.01 * random());
  Scene scene = sceneOf(wallAround(20, 404, 4, 404));
  for (uint32_t gap = 0; gap < 24; ++gap) scene.meshes.push_back(wallAround(3, columns, 1, gap));
  Simulator without = makeSimulator(scene, sensor, optionsWith(Accuracy::standard, nothing()));
  const Culling occlusion = {false, false, false, false, Culling::Occlusion::always};
  Simulator with = makeSimulator(scene, sensor, optionsWith(Accuracy::standard, occlusion));
  for (uint32_t gap = 0; gap < 24; ++gap) {
    INFO("column " << gap);
    const size_t near = without.addInstance(1 + gap, {});
    REQUIRE(with.addInstance(1 + gap, {}) == near);
    const Scan full = without.scan({});
    CHECK(full.ranges[2 * columns + gap] > 19);
    CHECK(sameBytes(full, with.scan({})));
    without.removeInstance(near);
    with.removeInstance(near);
  }
}

TEST_CASE("culling: a near wall hides geometry in every row of a later shell") {
  needVulkan();
  // A near wall hides two far ones, one above the horizon and one below it.
  Scene scene = sceneOf(wallAround(60, 720, 20, 720));
  scene.meshes.push_back(scene.meshes[0]);
  scene.meshes.push_back(wallAround(10, 90, 20, 90));
  scene.instances[0].transform.rows = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0.2, 18};
  scene.instances.push_back({"", 1, {}});
  scene.instances[1].transform.rows = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0.2, -18};
  scene.instances.push_back({"", 2, {}});
  const Sensor sensor = gridSensor(700, 40, -24, 24, 100);
  TestOptions options = vulkanOptions();
  options.faces = ReflectingFaces::both;
  options.tuning.culling.occlusion = Culling::Occlusion::always;
  const Scan scan = scanOf(scene, sensor, {}, options);
  CHECK(scan.counters.culledByCluster > 19 * scene.meshes[0].triangleCount() / 10);
  options.tuning.culling.occlusion = Culling::Occlusion::never;
  CHECK(sameBytes(scanOf(scene, sensor, {}, options), scan));
}
