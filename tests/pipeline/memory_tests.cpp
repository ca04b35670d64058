// SPDX-License-Identifier: Apache-2.0
// Memory of a scene and a sensor on the device.
#include "support.hpp"
#include "town/town.hpp"

namespace gnosphere::test {

TEST_CASE("a town and an HDL-64E stay within their bytes per triangle, instance and beam") {
  needVulkan();
  const Scene scene = makeTown({.triangles = 300'000});
  const Sensor sensor = builtinSensor("HDL-64E");
  TestOptions options = vulkanOptions();
  options.validation = false;  // for speed
  Simulator simulator = makeSimulator(scene, sensor, options);
  for (double x : {-40.0, 0.0, 40.0}) simulator.scan({{x, 0, 1.8}, {}});
  const MemoryUse use = simulator.memory();
  CHECK(use.scene <= 32 * scene.uniqueTriangleCount() + 64 * scene.instances.size());
  CHECK(use.sensor + use.work <= 32 * sensor.beamCount());
  CHECK(use.sensor + use.work >= 8 * sensor.beamCount());  // at least one word
}

TEST_CASE("the list of visible clusters has room for those in range, and is shared by all sensors") {
  needVulkan();
  Scene scene = sceneOf(ball(40, 40, 5));
  for (int i = 1; i < 200; ++i) scene.instances.push_back({"", 0, translation(100.0 * i, 0, 0)});
  const Sensor near = gridSensor(100, 4, -10, 10, 30), far = gridSensor(100, 4, -10, 10, 1e5);
  Simulator one = makeSimulator(scene, {near, far}, vulkanOptions());
  one.scan({}, 0);
  const uint64_t oneBall = one.memory().scene;
  one.scan({}, 1);
  const uint64_t all = one.memory().scene;
  CHECK(all > oneBall + 199 * 8);  // a cluster and more per ball
  one.scan({{500, 1, 0}, {}}, 0);
  one.scan({{900, 1, 0}, {}}, 1);
  CHECK(one.memory().scene == all);
}

}  // namespace gnosphere::test
