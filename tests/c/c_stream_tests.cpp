// SPDX-License-Identifier: Apache-2.0
// Batches of the C interface whose results stay on the device have the values of batches on the host.
#include <gnosphere_stream.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <future>
#include <thread>

#include "c/fails.hpp"
#include "c/wall.hpp"
#include "support.hpp"

namespace gnosphere::test {
namespace {

// A simulator of a wall for a sensor of 90 beams.
gno_simulator simulatorWith(const gno_options& options) {
  const gno_scene scene = sceneWithWall();
  const gno_instance instance = gno_instance_init();
  REQUIRE(gno_scene_add_instance(scene, &instance, nullptr) == GNO_OK);
  gno_sensor sensor = nullptr;
  REQUIRE(gno_sensor_from_json(toJson(gridSensor(30, 3, -5, 5)).c_str(), &sensor) == GNO_OK);
  const gno_simulator simulator = simulatorOf(scene, sensor, "clean", {GNO_FIELD_INSTANCE}, options);
  CHECK(gno_scene_destroy(scene) == GNO_OK);
  return simulator;
}

}  // namespace

TEST_CASE("C: triangles that face away, and those that are not in sight, are counted as such") {
  needVulkan();
  gno_options options = gno_options_init();
  options.cache = "off";
  REQUIRE(gno_options_set(&options, "faces=front") == GNO_OK);  // the wall looks along x
  const gno_simulator simulator = simulatorWith(options);
  gno_instance far = gno_instance_init();
  far.transform.rows[3] = 1e5;
  REQUIRE(gno_simulator_add_instance(simulator, &far, nullptr) == GNO_OK);
  const gno_shot shot = gno_shot_init();
  gno_scan scan = nullptr;
  REQUIRE(gno_simulator_scan(simulator, &shot, &scan) == GNO_OK);
  gno_counters counters = gno_counters_init();
  REQUIRE(gno_scan_get_counters(scan, &counters) == GNO_OK);
  CHECK((counters.triangles == 4 && counters.projected == 0 && counters.hits == 0));
  CHECK((counters.culled_by_cluster == 2 && counters.culled_by_face == 2));
  CHECK((counters.culled_by_range == 0 && counters.culled_hidden == 0 && counters.culled_between_beams == 0));
  CHECK(gno_scan_destroy(scan) == GNO_OK);
  CHECK(gno_simulator_destroy(simulator) == GNO_OK);
}

TEST_CASE("C: a simulator tells its device, plan, memory, clusters and times as in C++") {
  needVulkan();
  gno_options options = gno_options_init();
  options.cache = "off";
  REQUIRE(gno_options_set(&options, "tuning.stage_times=true") == GNO_OK);
  const gno_simulator simulator = simulatorWith(options);
  SimulatorOptions same;
  same.cache = "off";
  same.tuning.stageTimes = true;
  MeshBuilder wall;
  wall.quad({5, -20, -20}, {0, 40, 0}, {0, 0, 40});
  const SensorRequest request(gridSensor(30, 3, -5, 5), Effects::none(), {Field::instance});
  Simulator expected(sceneOf(wall.take()), request, same);

  gno_device_info device = gno_device_info_init();
  REQUIRE(gno_simulator_get_device(simulator, &device) == GNO_OK);
  CHECK((device.name == expected.device().name && device.usable != 0));
  const char* plan = nullptr;
  REQUIRE(gno_simulator_get_plan(simulator, 0, &plan) == GNO_OK);
  CHECK(plan == toJson(expected.plan(0)));
  CHECK(fails(gno_simulator_get_plan(simulator, 1, &plan), "sensor 1"));
  CHECK(fails(gno_simulator_get_plan(simulator, 0, nullptr), "json is null"));
  size_t clusters = 0;
  REQUIRE(gno_simulator_get_cluster_count(simulator, &clusters) == GNO_OK);
  CHECK(clusters == expected.clusterCount());
  CHECK(clusters > 0);
  gno_memory_use memory = gno_memory_use_init();
  REQUIRE(gno_simulator_get_memory(simulator, &memory) == GNO_OK);
  CHECK((memory.scene > 0 && memory.sensor > 0));
  CHECK((memory.scene == expected.memory().scene && memory.sensor == expected.memory().sensor));
  CHECK(memory.work == expected.memory().work);

  const gno_shot shots[2] = {gno_shot_init(), gno_shot_init()};
  gno_scan scan = nullptr;
  gno_batch batch = nullptr;
  REQUIRE(gno_simulator_scan(simulator, shots, &scan) == GNO_OK);
  REQUIRE(gno_simulator_scan_batch(simulator, shots, 2, nullptr, 0, &batch) == GNO_OK);
  const Timings times[2] = {expected.scan({}).timings, expected.scanBatch(std::vector<Shot>(2)).timings};
  gno_timings told[2] = {gno_timings_init(), gno_timings_init()};
  REQUIRE(gno_scan_get_timings(scan, &told[0]) == GNO_OK);
  REQUIRE(gno_batch_get_timings(batch, &told[1]) == GNO_OK);
  for (int i = 0; i < 2; ++i) {
    CHECK(told[i].wall_ms > 0);
    CHECK((told[i].gpu_ms > 0) == (times[i].gpuMs > 0));
    REQUIRE(told[i].stage_count == times[i].stages.size());
    for (size_t k = 0; k < told[i].stage_count; ++k) {
      CHECK(told[i].stages[k].name == times[i].stages[k].name);
      CHECK((told[i].stages[k].ms >= 0 && told[i].stages[k].ms < 1000 * told[i].wall_ms));
    }
  }
  CHECK(told[0].stage_count > 0);
  CHECK(gno_batch_destroy(batch) == GNO_OK);
  CHECK(gno_scan_destroy(scan) == GNO_OK);
  CHECK(gno_simulator_destroy(simulator) == GNO_OK);
}

TEST_CASE("C: streamed batches have the values of batches on the host, also after the simulator's handle is gone") {
  needVulkan();
  gno_options options = gno_options_init();
  options.cache = "off";
  const gno_simulator host = simulatorWith(options);
  REQUIRE(gno_options_set(&options, "results_on_device=true") == GNO_OK);
  const gno_simulator device = simulatorWith(options);
  gno_batch_stream_options many = gno_batch_stream_options_init();
  many.views = 3;
  many.to_host = 1;
  gno_batch_stream stream = nullptr;
  CHECK(fails(gno_batch_stream_create(host, &many, &stream), "results_on_device"));
  REQUIRE(gno_batch_stream_create(device, &many, &stream) == GNO_OK);

  gno_shot shots[3] = {gno_shot_init(), gno_shot_init(), gno_shot_init()};
  for (int i = 0; i < 3; ++i) shots[i].pose.position[0] = 0.5 * i;
  gno_batch batch = nullptr;
  REQUIRE(gno_simulator_scan_batch(host, shots, 3, nullptr, 0, &batch) == GNO_OK);
  uint64_t number = 7;
  REQUIRE(gno_batch_stream_submit(stream, shots, 3, &number) == GNO_OK);
  CHECK(number == 0);
  CHECK(gno_simulator_destroy(device) == GNO_OK);
  gno_streamed_batch streamed = gno_streamed_batch_init();
  REQUIRE(gno_batch_stream_wait(stream, number, &streamed) == GNO_OK);
  CHECK(streamed.views == 3);
  CHECK(streamed.complete != 0);
  REQUIRE(streamed.records != nullptr);
  const gno_result_places& places = *streamed.places;
  CHECK(places.rows_per_view == 90);
  const gno_layout& layout = *streamed.layout;
  REQUIRE(layout.value_count == 2);
  gno_result_places ofSensor = gno_result_places_init();
  REQUIRE(gno_batch_stream_get_places(stream, 0, &ofSensor) == GNO_OK);
  CHECK((ofSensor.records == places.records && ofSensor.bytes_per_view == places.bytes_per_view));
  CHECK((ofSensor.rows_per_view == 90 && ofSensor.bytes == places.bytes));
  gno_layout layoutOfSensor = gno_layout_init();
  REQUIRE(gno_batch_stream_get_layout(stream, 0, &layoutOfSensor) == GNO_OK);
  CHECK(layoutOfSensor.value_count == 2);
  for (size_t value = 0; value < 2; ++value) {
    gno_column column = gno_column_init();
    REQUIRE(gno_batch_get_column(batch, layout.values[value].field, &column) == GNO_OK);
    for (size_t view = 0; view < 3; ++view)
      CHECK(std::memcmp(
                static_cast<const char*>(column.values) + 360 * view,
                static_cast<const char*>(streamed.records) + view * places.bytes_per_view + layout.values[value].offset,
                360) == 0);
  }
  CHECK(streamed.headers[1].rows == 90);
  CHECK(streamed.headers[1].hits > 5);

  gno_exported_memory memory = gno_exported_memory_init();
  if (gno_batch_stream_export(stream, 1, &memory) == GNO_OK) {
    CHECK(memory.bytes >= places.bytes);
    CHECK(close(memory.fd) == 0);
  }
  uint64_t address = 0;
  CHECK(gno_batch_stream_get_cuda_address(stream, 0, &address, nullptr) != GNO_OK);
  CHECK(std::strstr(gno_last_error(), "CUDA cannot have the results") != nullptr);
  CHECK(fails(gno_batch_stream_wait(stream, 1, &streamed), "no batch 1"));
  shots[2].pose.position[1] = std::nan("");
  CHECK(fails(gno_batch_stream_submit(stream, shots, 3, &number), "shot 2"));
  CHECK(gno_batch_destroy(batch) == GNO_OK);
  CHECK(gno_batch_stream_destroy(stream) == GNO_OK);
  CHECK(gno_batch_stream_destroy(stream) == GNO_INVALID_ARGUMENT);
  CHECK(gno_simulator_destroy(host) == GNO_OK);
}

// If the two calls wait for each other, their threads never end, so nothing that they use belongs to the test.
TEST_CASE("C: a function that receives warnings may read a stream to which another thread submits") {
  needVulkan();
  struct Reading {
    gno_simulator simulator = nullptr;
    gno_batch_stream stream = nullptr;
    std::promise<void> warned;
    gno_status read = GNO_DEVICE;
  };
  static Reading& reading = *new Reading;
  gno_options options = gno_options_init();
  options.cache = "off";
  options.warn = [](const char*, void*) {
    reading.warned.set_value();
    std::this_thread::sleep_for(std::chrono::milliseconds(200));  // the other thread waits for the simulator now
    gno_streamed_batch batch = gno_streamed_batch_init();
    reading.read = gno_batch_stream_wait(reading.stream, 0, &batch);
  };
  REQUIRE(gno_options_set(&options, "results_on_device=true") == GNO_OK);
  reading.simulator = simulatorWith(options);
  gno_batch_stream_options one = gno_batch_stream_options_init();
  one.views = 1;
  REQUIRE(gno_batch_stream_create(reading.simulator, &one, &reading.stream) == GNO_OK);
  static const gno_shot shot = gno_shot_init();
  REQUIRE(gno_batch_stream_submit(reading.stream, &shot, 1, nullptr) == GNO_OK);

  static std::promise<gno_status> submitted, added;
  std::thread([] {
    reading.warned.get_future().wait();
    submitted.set_value(gno_batch_stream_submit(reading.stream, &shot, 1, nullptr));
  }).detach();
  std::thread([] {
    gno_sensor none = nullptr;  // of no beams, of which the simulator warns
    gno_sensor_settings settings = gno_sensor_settings_init();
    settings.range_max = 100;
    gno_grid grid = gno_grid_init();
    grid.columns = 30;
    gno_sensor_create_grid(&settings, &grid, &none);
    gno_request request = gno_request_init();
    request.sensor = none;
    added.set_value(gno_simulator_add_sensor(reading.simulator, &request, nullptr));
  }).detach();
  std::future<gno_status> statuses[] = {added.get_future(), submitted.get_future()};
  for (std::future<gno_status>& status : statuses)
    REQUIRE(status.wait_for(std::chrono::seconds(60)) == std::future_status::ready);
  CHECK(statuses[0].get() == GNO_INVALID_ARGUMENT);  // after the warning, as no results of it can stay on the device
  CHECK(statuses[1].get() == GNO_OK);
  CHECK(reading.read == GNO_OK);
  CHECK(gno_batch_stream_destroy(reading.stream) == GNO_OK);
  CHECK(gno_simulator_destroy(reading.simulator) == GNO_OK);
}

TEST_CASE("C: a streamed batch keeps its places and its layout, whatever sensor gets the index of its own") {
  needVulkan();
  gno_options options = gno_options_init();
  options.cache = "off";
  REQUIRE(gno_options_set(&options, "results_on_device=true") == GNO_OK);
  const gno_simulator simulator = simulatorWith(options);
  gno_batch_stream_options one = gno_batch_stream_options_init();
  one.views = 1;
  gno_batch_stream stream = nullptr;
  REQUIRE(gno_batch_stream_create(simulator, &one, &stream) == GNO_OK);
  const gno_shot shot = gno_shot_init();
  gno_streamed_batch batches[3] = {gno_streamed_batch_init(), gno_streamed_batch_init(), gno_streamed_batch_init()};
  for (uint64_t number = 0; number < 2; ++number) REQUIRE(gno_batch_stream_submit(stream, &shot, 1, nullptr) == GNO_OK);
  REQUIRE(gno_batch_stream_wait(stream, 0, &batches[0]) == GNO_OK);
  REQUIRE(gno_simulator_remove_sensor(simulator, 0) == GNO_OK);
  REQUIRE(gno_batch_stream_wait(stream, 1, &batches[1]) == GNO_OK);
  gno_sensor sensor = nullptr;
  REQUIRE(gno_sensor_from_json(toJson(gridSensor(4, 2, -5, 5)).c_str(), &sensor) == GNO_OK);
  gno_request request = gno_request_init();
  request.sensor = sensor;
  size_t index = 9;
  REQUIRE(gno_simulator_add_sensor(simulator, &request, &index) == GNO_OK);
  CHECK(index == 0);
  for (uint64_t number = 0; number < 2; ++number) {
    REQUIRE(gno_batch_stream_wait(stream, number, &batches[number]) == GNO_OK);
    CHECK(batches[number].places->rows_per_view == 90);
    REQUIRE(batches[number].layout->value_count == 2);
    CHECK(batches[number].layout->values[1].field == GNO_FIELD_INSTANCE);
  }
  REQUIRE(gno_batch_stream_submit(stream, &shot, 1, nullptr) == GNO_OK);
  REQUIRE(gno_batch_stream_wait(stream, 2, &batches[2]) == GNO_OK);
  CHECK(batches[2].places->rows_per_view % 8 == 0);
  CHECK(batches[2].layout->value_count == 1);
  CHECK(batches[1].layout->value_count == 2);
  CHECK(gno_batch_stream_destroy(stream) == GNO_OK);
  CHECK(gno_sensor_destroy(sensor) == GNO_OK);
  CHECK(gno_simulator_destroy(simulator) == GNO_OK);
}

}  // namespace gnosphere::test
