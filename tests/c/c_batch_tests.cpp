// SPDX-License-Identifier: Apache-2.0
// Batches and worlds of the C interface have the values of those of C++.
#include <gnosphere.h>

#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <cstring>
#include <gnosphere/gnosphere.hpp>

#include "c/wall.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

namespace {

Sensor ahead() {
  Sensor sensor;
  sensor.name = "ahead";
  sensor.columns = 30;
  sensor.azimuthStartDeg = -30;
  sensor.azimuthSpanDeg = 60;
  sensor.rangeMax = 100;
  sensor.channels = {{-5, 0}, {0, 0}, {5, 0}};
  return sensor;
}

Scene wall() {
  Scene scene;
  scene.materials.emplace_back();
  Mesh mesh;
  mesh.positions.assign(std::begin(kWall), std::end(kWall));
  mesh.indices.assign(std::begin(kSquare), std::end(kSquare));
  mesh.parts = {{0, 2, 0}};
  scene.meshes.push_back(mesh);
  return scene;
}

gno_simulator makeSimulator() {
  const gno_scene scene = sceneWithWall();
  gno_sensor sensor = nullptr;
  REQUIRE(gno_sensor_from_json(toJson(ahead()).c_str(), &sensor) == GNO_OK);
  const gno_simulator simulator = simulatorOf(scene, sensor, "clean");
  CHECK(gno_scene_destroy(scene) == GNO_OK);
  return simulator;
}

}  // namespace

TEST_CASE("C: a batch of worlds has the values of C++, and errors that name the shot") {
  gno_simulator simulator = makeSimulator();
  gno_instance instances[3] = {gno_instance_init(), gno_instance_init(), gno_instance_init()};
  for (int i = 0; i < 3; ++i) {
    instances[i].transform.rows[3] = 10.0 * i;
    instances[i].world = static_cast<uint32_t>(i + 1);
  }
  uint32_t indices[3] = {};
  REQUIRE(gno_simulator_add_instances(simulator, instances, 3, indices) == GNO_OK);
  CHECK(indices[2] == 2);
  const uint32_t gone[] = {2, 0, 2};
  CHECK(gno_simulator_remove_instances(simulator, gone, 3) == GNO_INVALID_ARGUMENT);
  CHECK(std::strcmp(gno_last_error(), "entry 2: instance 2 stands in an entry before it, too; name it once") == 0);
  CHECK(gno_simulator_remove_instances(simulator, nullptr, 1) == GNO_INVALID_ARGUMENT);
  CHECK(gno_simulator_remove_instances(simulator, gone, 2) == GNO_OK);
  const gno_instance back[] = {instances[2], instances[0]};
  REQUIRE(gno_simulator_add_instances(simulator, back, 2, indices + 1) == GNO_OK);
  CHECK((indices[1] == 2 && indices[2] == 0));
  gno_shot shots[4] = {gno_shot_init(), gno_shot_init(), gno_shot_init(), gno_shot_init()};
  for (int i = 0; i < 4; ++i) shots[i].world = static_cast<uint32_t>(3 - i);
  const gno_field fields[] = {GNO_FIELD_INSTANCE};
  gno_batch batch = nullptr;
  REQUIRE(gno_simulator_scan_batch(simulator, shots, 4, fields, 1, &batch) == GNO_OK);
  const gno_batch first = batch;
  REQUIRE(gno_simulator_scan_batch(simulator, shots, 4, fields, 1, &batch) == GNO_OK);
  CHECK(batch == first);
  gno_batch_info info = gno_batch_info_init();
  REQUIRE(gno_batch_get_info(batch, &info) == GNO_OK);
  CHECK(info.views == 4);
  CHECK(info.beams == 90);
  CHECK(info.entries == 360);
  CHECK(std::strcmp(info.sensor, "ahead") == 0);

  Scene scene = wall();
  for (int i = 0; i < 3; ++i) {
    Instance instance;
    instance.transform.rows[3] = 10.0 * i;
    instance.world = static_cast<uint32_t>(i + 1);
    scene.instances.push_back(instance);
  }
  SimulatorOptions options;
  options.device = DeviceChoice::Kind::reference;
  Simulator same(scene, SensorRequest(ahead(), Effects::none()), options);
  std::vector<Shot> wanted(4);
  for (size_t i = 0; i < 4; ++i) wanted[i].world = static_cast<uint32_t>(3 - i);
  const Batch expected = same.scanBatch(wanted);
  gno_column column = gno_column_init();
  REQUIRE(gno_batch_get_column(batch, GNO_FIELD_RANGE, &column) == GNO_OK);
  REQUIRE(column.entries == 360);
  CHECK(std::memcmp(column.values, expected.ranges().data(), expected.ranges().size_bytes()) == 0);
  REQUIRE(gno_batch_get_column(batch, GNO_FIELD_INSTANCE, &column) == GNO_OK);
  CHECK(std::memcmp(column.values, expected.instances().data(), expected.instances().size_bytes()) == 0);
  CHECK(static_cast<const uint32_t*>(column.values)[0] == 2);
  CHECK(gno_batch_get_column(batch, GNO_FIELD_X, &column) == GNO_INVALID_ARGUMENT);
  gno_counters counters = gno_counters_init();
  REQUIRE(gno_batch_get_counters(batch, &counters) == GNO_OK);
  CHECK(counters.hits == expected.counters.hits);
  CHECK(counters.hits == 270);  // world 0 is empty

  const uint32_t ignored[] = {0, 2};
  shots[0].ignored_instances = ignored;  // the shot of instance 2
  shots[0].ignored_instance_count = 2;
  REQUIRE(gno_simulator_scan_batch(simulator, shots, 4, fields, 1, &batch) == GNO_OK);
  REQUIRE(gno_batch_get_counters(batch, &counters) == GNO_OK);
  CHECK(counters.hits == 180);
  shots[0].ignored_instance_count = 0;

  // An instance that comes alone goes into its world, too.
  gno_instance near = gno_instance_init();
  near.transform.rows[3] = -2;
  near.world = 9;
  size_t index = 0;
  REQUIRE(gno_simulator_add_instance(simulator, &near, &index) == GNO_OK);
  REQUIRE(gno_simulator_scan_batch(simulator, shots, 4, fields, 1, &batch) == GNO_OK);
  REQUIRE(gno_batch_get_counters(batch, &counters) == GNO_OK);
  CHECK(counters.hits == 270);
  shots[0].world = 9;
  REQUIRE(gno_simulator_scan_batch(simulator, shots, 1, fields, 1, &batch) == GNO_OK);
  REQUIRE(gno_batch_get_column(batch, GNO_FIELD_INSTANCE, &column) == GNO_OK);
  CHECK(static_cast<const uint32_t*>(column.values)[0] == index);

  shots[2].pose.position[1] = std::nan("");
  CHECK(gno_simulator_scan_batch(simulator, shots, 4, fields, 1, &batch) == GNO_INVALID_ARGUMENT);
  CHECK(std::strstr(gno_last_error(), "shot 2: ") != nullptr);
  CHECK(gno_simulator_scan_batch(simulator, shots, 4, fields, 1, nullptr) == GNO_INVALID_ARGUMENT);
  CHECK(gno_batch_destroy(batch) == GNO_OK);
  CHECK(gno_batch_destroy(batch) == GNO_INVALID_ARGUMENT);
  CHECK(gno_simulator_destroy(simulator) == GNO_OK);
}
