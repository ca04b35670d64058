// SPDX-License-Identifier: Apache-2.0
// Hard cases of inputs: invalid corners, far worlds, unusual instances and sensors, empty scenes.
#include <algorithm>
#include <limits>

#include "hardcases/hardcases.hpp"
#include "town/town.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

namespace {

const int kInputWorlds = rounds(60);

TestOptions optionsBy(Binning binning, Accuracy accuracy) {
  TestOptions options = vulkanOptions();
  options.tuning.binning = binning;
  options.accuracy = accuracy;
  return options;
}

Scan scanBy(Binning binning, Accuracy accuracy, const Scene& scene, const Sensor& sensor) {
  return scanOf(scene, sensor, {}, optionsBy(binning, accuracy));
}

}  // namespace

TEST_CASE("hard: NaN, infinite and 1e30 corners") {
  Family family("NaN, Inf and 1e30", {allAround(90, 19)});
  Random random(21);
  const float poisons[] = {std::numeric_limits<float>::quiet_NaN(),
                           std::numeric_limits<float>::infinity(),
                           1e30f,
                           -std::numeric_limits<float>::infinity(),
                           -3e9f,
                           std::numeric_limits<float>::max()};
  for (int i = 0; i < kInputWorlds; ++i) {
    Scene world = sceneOf(soup(random.bits(), 60, 12, 5));
    Mesh& mesh = world.meshes[0];
    for (int k = 0; k < 12; ++k) mesh.positions[random.bits() % mesh.positions.size()] = poisons[random.bits() % 6];
    if (i % 3 == 0) world.instances.push_back({"", 0, scaling(1e12, 1e12, 1e12)});
    family.add(world, {{}, anyTurn(random)});
  }
  CHECK(requireRight(family).paperWrong > 0);
}

TEST_CASE("hard: worlds 1e5 to 1e7 m from the origin") {
  Family family("world offsets 1e5 to 1e7 m", {allAround(90, 19)});
  Random random(22);
  for (int i = 0; i < kInputWorlds; ++i) {
    const Vec3 far = {logUniform(random, 1e5, 1e7), -logUniform(random, 1e5, 1e7), logUniform(random, 1e2, 1e5)};
    Scene world = sceneOf(soup(random.bits(), 120, 20, 6));
    // The offset comes from the instance, from the mesh's origin or half from each; corners are moved as far as floats
    // allow.
    const double share = 0.5 * (i % 3);
    const Vec3 corners = i % 2 ? Vec3{-9000, 5000, 300} : Vec3{};
    world.meshes[0].origin = along(far, share);
    for (size_t k = 0; k < world.meshes[0].positions.size(); ++k)
      world.meshes[0].positions[k] += static_cast<float>(k % 3 == 0 ? corners.x : k % 3 == 1 ? corners.y : corners.z);
    world.instances[0].transform =
        translation((1 - share) * far.x - corners.x, (1 - share) * far.y - corners.y, (1 - share) * far.z - corners.z);
    family.add(world, {far, anyTurn(random)});
  }
  CHECK(requireRight(family).paperWrong > 0);
}

TEST_CASE("hard: mirrored and unevenly scaled instances") {
  Family family("mirrored and scaled instances", {allAround(90, 19)});
  Random random(23);
  for (int i = 0; i < kInputWorlds; ++i) {
    Scene world = sceneOf(i % 2 ? ball(7, 9, 1) : soup(random.bits(), 80, 1, 0.5), i % 4 < 2);
    world.instances.clear();
    for (int k = 0; k < 4; ++k) {
      const auto factor = [&] { return (random() < 0 ? -1 : 1) * logUniform(random, 0.05, 20); };
      world.instances.push_back({"", 0,
                                 translation(15 * random(), 15 * random(), 9 * random()) * rotationZ(3 * random()) *
                                     scaling(factor(), factor(), factor())});
    }
    family.add(world, {{}, anyTurn(random)});
  }
  CHECK(requireRight(family).paperWrong > 0);
}

TEST_CASE("hard: inverted normals, one side reflecting") {
  Family family("inverted normals, one-sided", {allAround(90, 19)});
  Random random(24);
  for (int i = 0; i < kInputWorlds; ++i) {
    Scene world = sceneOf(ball(5 + random.bits() % 8, 6 + random.bits() % 12, logUniform(random, 1, 20)), false);
    Mesh& mesh = world.meshes[0];
    for (size_t t = 0; t < mesh.triangleCount(); ++t)  // all or some triangles turned inside out
      if (i % 2 || random() < 0) std::swap(mesh.indices[3 * t], mesh.indices[3 * t + 1]);
    family.add(world, {anywhere(random, 8), anyTurn(random)});
  }
  for (const ReflectingFaces faces : {ReflectingFaces::material, ReflectingFaces::both}) {
    family.name = faces == ReflectingFaces::both ? "inverted normals, both sides" : "inverted normals, one-sided";
    CHECK(requireRight(family, faces).paperWrong > 0);
  }
}

TEST_CASE("hard: uneven channels with azimuth offsets, columns that do not divide a turn") {
  Random random(25);
  std::vector<Sensor> sensors;
  for (const uint32_t columns : {1u, 7u, 113u, 360u}) {
    Sensor sensor{"uneven", columns, {}, 0.3, 60};
    for (int j = 0; j < 24; ++j) {
      // Channels are clustered, duplicated, at both poles, and unsorted.
      const double elevation = j < 4 ? 12.5 : j == 5 ? 90 : j == 6 ? -90 : j % 2 ? 3 * random() : 89 * random();
      sensor.channels.push_back({elevation, j % 3 == 0 ? 0 : j % 3 == 1 ? 200 * random() : 3 * random()});
    }
    sensors.push_back(sensor);
  }
  Family family("uneven channels and columns", sensors);
  for (int i = 0; i < kInputWorlds; ++i)
    family.add(sceneOf(i % 2 ? soup(random.bits(), 150, 20, 8) : ball(9, 13, 12)), {{}, anyTurn(random)}, i % 4);
  requireRight(family);
}

TEST_CASE("hard: an empty scene, one triangle, a sensor without beams") {
  needVulkan();
  // `paper` cannot fail without triangles; for single triangles see the families of shape.
  const Sensor sensor = allAround(90, 19);
  Sensor blind = sensor;
  blind.channels.clear();
  MeshBuilder builder;
  builder.triangle({2, -1, -1}, {2, 1, -1}, {2, 0, 1});
  const Scene one = sceneOf(builder.take());
  Scene unplaced = one;
  unplaced.instances.clear();
  const Scan reference = referenceOf(one, sensor, {});
  CHECK(reference.counters.hits > 0);
  for (const Accuracy accuracy : {Accuracy::standard, Accuracy::exact}) {
    for (const Binning binning : {Binning::nearest, Binning::lists}) {
      if ((accuracy == Accuracy::exact) != (binning == Binning::lists) && !everyCombination()) continue;
      CHECK(scanBy(binning, accuracy, Scene{}, sensor).counters.misses == sensor.beamCount());
      Simulator simulator = makeSimulator(one, {blind, sensor}, optionsBy(binning, accuracy));
      CHECK(simulator.scan({}, 0).beamCount() == 0);
      requireSame(reference, simulator.scan({}, 1));
      simulator.removeInstance(0);
      CHECK(simulator.scan({}, 1).counters.misses == sensor.beamCount());
      CHECK(scanBy(binning, accuracy, unplaced, blind).beamCount() == 0);
    }
    CHECK(scanBy(Binning::nearest, accuracy, unplaced, sensor).counters.misses == sensor.beamCount());
  }
}

TEST_CASE("hard: more candidates than the buffer holds") {
  needVulkan();
  // `paper` has no lists that could overflow; on these shells it fails by its bounds as everywhere.
  Scene scene = sceneOf(ball(12, 24, 1));
  scene.instances.clear();
  for (int shell = 0; shell < 40; ++shell) scene.instances.push_back({"", 0, scaling(3 + shell, 3 + shell, 3 + shell)});
  const Sensor sensor = allAround(180, 31);
  const Scan reference = referenceOf(scene, sensor, {});
  for (const Accuracy accuracy : {Accuracy::standard, Accuracy::exact}) {
    const Scan lists = scanBy(Binning::lists, accuracy, scene, sensor);
    CHECK(lists.counters.retries >= 1);
    CHECK(lists.counters.candidates >= 40 * sensor.beamCount());
    requireSame(reference, lists);
    CHECK(sameBytes(lists, scanBy(Binning::nearest, accuracy, scene, sensor)));
  }
  CHECK_FALSE(compare(reference, scanBy(Binning::nearest, Accuracy::paper, scene, sensor)).same());
}

TEST_CASE("hard: twenty orders of the same triangles give the same bytes after mapping indices back") {
  needVulkan();
  // `paper` is not affected by the order, so it is not tested here.
  const Sensor sensor = allAround(96, 25);
  Mesh original = aimedMesh(sensor, 2, [](const Vec3&) { return 8.0; });
  const Mesh loose = soup(3, 400, 12, 4);
  const auto shift = static_cast<uint32_t>(original.vertexCount());
  original.positions.insert(original.positions.end(), loose.positions.begin(), loose.positions.end());
  for (uint32_t index : loose.indices) original.indices.push_back(index + shift);
  original.parts[0].triangleCount = static_cast<uint32_t>(original.triangleCount());
  Random random(26);
  Family family("permuted order", {sensor});
  std::vector<std::vector<uint32_t>> orders;
  for (int round = 0; round < 21; ++round) {
    std::vector<uint32_t>& order = orders.emplace_back(original.triangleCount());
    for (uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    for (size_t i = order.size() - 1; round > 0 && i > 0; --i) std::swap(order[i], order[random.bits() % (i + 1)]);
    Mesh shuffled = original;
    for (size_t i = 0; i < order.size(); ++i)
      std::copy_n(&original.indices[3 * size_t{order[i]}], 3, &shuffled.indices[3 * i]);
    family.add(sceneOf(std::move(shuffled)));
  }
  for (const Accuracy accuracy : {Accuracy::standard, Accuracy::exact}) {
    TestOptions options = vulkanOptions();
    options.accuracy = accuracy;
    Simulator simulator = makeSimulator(family.scene, family.sensors, options);
    const Scan first = simulator.scan(family.visits[0].pose);
    for (size_t round = 1; round < orders.size(); ++round) {
      const Scan scan = simulator.scan(family.visits[round].pose);
      REQUIRE(sameBytes(scan.ranges, first.ranges));
      // If two triangles are hit at one range on their common edge, `standard` chooses the lower index, which depends
      // on the order.
      if (accuracy == Accuracy::standard) continue;
      for (size_t b = 0; b < scan.beamCount(); ++b) REQUIRE(orders[round][scan.triangles[b]] == first.triangles[b]);
    }
  }
  requireRight(family);
}
