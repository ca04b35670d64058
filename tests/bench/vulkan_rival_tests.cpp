// SPDX-License-Identifier: Apache-2.0
// Vulkan's ray tracing as the bench uses it, compared with the reference: a benchmark is meaningful only if the results
// agree.
#include <algorithm>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>

#include "rivals/vulkan.hpp"
#include "support.hpp"
#include "town/town.hpp"

using namespace gnosphere;
using namespace gnosphere::bench;
using Catch::Matchers::ContainsSubstring;

namespace {

std::unique_ptr<Rival> makeOrSkip(const Scene& scene, const Vec3& origin, VulkanWay way, Motion motion,
                                  uint64_t maxAllocationBytes = 0) {
  test::needVulkan();
  try {
    return makeVulkan(scene, origin, way, {{}, motion, test::vulkanOptions().validation, maxAllocationBytes});
  } catch (const Error& error) {
    if (std::strstr(error.what(), "lacks") == nullptr) throw;
    SKIP(error.what());
  }
  return nullptr;
}

Scan scanOf(Rival& rival, const Sensor& sensor, const Pose& pose) {
  Hits hits;
  rival.trace(sensor, pose, hits);
  Scan scan;
  scan.ranges = hits.ranges;
  scan.triangles = hits.triangles;
  scan.instances = hits.instances;
  return scan;
}

Sensor streetSensor() {
  Sensor sensor = test::gridSensor(300, 24, -40, 30, 60);
  sensor.rangeMin = 3;
  return sensor;
}

Quaternion turned() {
  return {0.1, -0.05, 0.3, std::sqrt(1 - 0.1 * 0.1 - 0.05 * 0.05 - 0.3 * 0.3)};
}

}  // namespace

TEST_CASE("ray tracing hits the same triangles as the reference") {
  const auto way = GENERATE(VulkanWay::rayQuery, VulkanWay::rayTracingPipeline);
  const auto motion = GENERATE(Motion::none, Motion::everything);
  const Scene town = makeTown({20'000, 1});
  const auto rival = makeOrSkip(town, {}, way, motion);
  CAPTURE(rival->name(), static_cast<int>(motion));
  CHECK(rival->build() > 0);
  const Pose pose = {{2.5, 0.5, 1.8}, turned()};
  const Scan reference = test::referenceOf(town, streetSensor(), pose, ReflectingFaces::both);
  CHECK(reference.counters.hits > 1000);
  CHECK(reference.counters.misses > 1000);
  test::requireSame(reference, scanOf(*rival, streetSensor(), pose));
  // A different sensor in the same place.
  const Sensor other = test::gridSensor(77, 3, -10, 10, 100);
  test::requireSame(test::referenceOf(town, other, pose, ReflectingFaces::both), scanOf(*rival, other, pose));
}

TEST_CASE("ray tracing follows instances that move") {
  const auto way = GENERATE(VulkanWay::rayQuery, VulkanWay::rayTracingPipeline);
  const auto motion = GENERATE(Motion::none, Motion::transforms, Motion::everything);
  Scene scene = test::sceneOf(test::ball(20, 40, 1.5));
  for (int i = 1; i < 12; ++i) scene.instances.push_back({"", 0, test::translation(4.0 * i - 20, 6, 0.5)});
  const auto rival = makeOrSkip(scene, {1, 2, 3}, way, motion);
  CAPTURE(rival->name(), static_cast<int>(motion));
  rival->build();
  std::vector<Moved> moved;
  for (size_t i = 0; i < scene.instances.size(); i += 2) {
    Transform& transform = scene.instances[i].transform;
    transform = test::translation(0, -7, 0) * transform * test::rotationZ(0.3 * double(i)) * test::scaling(1, 2, 0.5);
    moved.push_back({i, transform});
  }
  CHECK(rival->update(moved) > 0);
  const Pose pose = {{1.5, -0.5, 0.2}, turned()};
  const Scan reference = test::referenceOf(scene, streetSensor(), pose, ReflectingFaces::both);
  CHECK(reference.counters.hits > 500);
  test::requireSame(reference, scanOf(*rival, streetSensor(), pose));
}

TEST_CASE("ray tracing keeps its precision far from the world's origin") {
  const auto way = GENERATE(VulkanWay::rayQuery, VulkanWay::rayTracingPipeline);
  Scene scene = test::sceneOf(test::ball(20, 40, 8));
  scene.meshes[0].origin = {1000, 2000, 3000};
  scene.instances[0].transform = test::translation(5e6, -3e6, 1e5);
  const Pose pose = {{5e6 + 1001, -3e6 + 2001, 1e5 + 3000.5}, turned()};
  const auto rival = makeOrSkip(scene, pose.position, way, Motion::none);
  rival->build();
  test::requireSame(test::referenceOf(scene, streetSensor(), pose, ReflectingFaces::both),
                    scanOf(*rival, streetSensor(), pose));
}

TEST_CASE("ray tracing splits a mesh that is too large for one structure") {
  const auto way = GENERATE(VulkanWay::rayQuery, VulkanWay::rayTracingPipeline);
  Scene scene = test::sceneOf(test::ball(50, 100, 8));
  scene.instances.push_back({"", 0, test::translation(1, 2, 3)});
  const auto rival = makeOrSkip(scene, {}, way, Motion::everything, 1 << 20);
  rival->build();
  test::requireSame(test::referenceOf(scene, streetSensor(), {}, ReflectingFaces::both),
                    scanOf(*rival, streetSensor(), {}));
  Scene moved = scene;
  moved.instances[1].transform = test::translation(-2, 1, 0);
  rival->update(std::vector<Moved>{{1, moved.instances[1].transform}});
  test::requireSame(test::referenceOf(moved, streetSensor(), {}, ReflectingFaces::both),
                    scanOf(*rival, streetSensor(), {}));
}

TEST_CASE("ray tracing of an empty scene gives misses") {
  const auto way = GENERATE(VulkanWay::rayQuery, VulkanWay::rayTracingPipeline);
  const Scene empty;
  const auto rival = makeOrSkip(empty, {}, way, Motion::none);
  rival->build();
  const Scan scan = scanOf(*rival, streetSensor(), {});
  REQUIRE(scan.beamCount() == streetSensor().beamCount());
  CHECK(std::none_of(scan.triangles.begin(), scan.triangles.end(), [](uint32_t t) { return t != kNoTriangle; }));
  CHECK(std::all_of(scan.ranges.begin(), scan.ranges.end(), [](float range) { return std::isnan(range); }));
}

TEST_CASE("ray tracing reports which buffer does not fit") {
  const auto way = GENERATE(VulkanWay::rayQuery, VulkanWay::rayTracingPipeline);
  const Scene scene = test::sceneOf(test::ball(50, 100, 8));
  REQUIRE_THROWS_WITH(makeOrSkip(scene, {}, way, Motion::none, 1 << 16),
                      ContainsSubstring("cannot allocate") && ContainsSubstring("'triangles'"));
}
