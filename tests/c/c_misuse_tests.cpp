// SPDX-License-Identifier: Apache-2.0
// Mistakes of programs in C are errors with a sentence, and not crashes: functions that change what is in use or that
// throw, calls in a process that was forked, and structs whose numbers cannot be.
#include <gnosphere.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <future>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "c/fails.hpp"
#include "c/wall.hpp"

namespace gnosphere::test {
namespace {

/// A scene with a wall that is placed once, and what a simulator of it on the reference needs.
struct Wall {
  gno_scene scene = sceneWithWall();
  gno_sensor sensor = nullptr;
  gno_request request = gno_request_init();
  gno_options options = gno_options_init();

  Wall() {
    const gno_instance instance = gno_instance_init();
    REQUIRE(gno_scene_add_instance(scene, &instance, nullptr) == GNO_OK);
    REQUIRE(gno_sensor_builtin("VLP-16", &sensor) == GNO_OK);
    request.sensor = sensor;
    options.device = "reference";
  }
  ~Wall() {
    CHECK(gno_sensor_destroy(sensor) == GNO_OK);
    CHECK(gno_scene_destroy(scene) == GNO_OK);
  }
  gno_status create(gno_simulator& simulator) { return gno_simulator_create(scene, &request, 1, &options, &simulator); }
};

/// A table with a row that no material takes, of which gno_simulator_create() warns.
gno_material_table tableOfNothing() {
  gno_material_table table = nullptr;
  REQUIRE(gno_material_table_load(nullptr, &table) == GNO_OK);
  REQUIRE(gno_material_table_add(table, "nothing", 0.5f, 0.5f, -1, -1, -1) == GNO_OK);
  return table;
}

}  // namespace

TEST_CASE("C: a function that receives warnings cannot change the scene that is being read") {
  Wall wall;
  struct Warned {
    gno_scene scene;
    int count = 0;
  } warned{wall.scene};
  wall.options.materials = tableOfNothing();
  wall.options.user = &warned;
  wall.options.warn = [](const char*, void* user) {
    auto& to = *static_cast<Warned*>(user);
    ++to.count;
    const gno_instance instance = gno_instance_init();
    const gno_node node = gno_node_init();
    const gno_transform root = instance.transform;
    fails(gno_scene_add_instance(to.scene, &instance, nullptr), "this scene is in use");
    fails(gno_scene_add_node(to.scene, &node, nullptr), "must not change it");
    fails(gno_scene_set_animation_root(to.scene, &root), "must not change it");
    gno_scene_counts counts = gno_scene_counts_init();
    CHECK(gno_scene_get_counts(to.scene, &counts) == GNO_OK);
    CHECK(counts.instances == 1);
  };
  gno_simulator simulator = nullptr;
  REQUIRE(wall.create(simulator) == GNO_OK);
  CHECK(warned.count == 1);
  const gno_instance instance = gno_instance_init();
  CHECK(gno_scene_add_instance(wall.scene, &instance, nullptr) == GNO_OK);
  CHECK(gno_simulator_destroy(simulator) == GNO_OK);
  CHECK(gno_material_table_destroy(wall.options.materials) == GNO_OK);
}

TEST_CASE("C: a function that receives scans may read a scene that another thread adds to the simulator") {
  Wall wall;
  gno_simulator simulator = nullptr;
  REQUIRE(wall.create(simulator) == GNO_OK);
  gno_scene car = sceneWithWall();
  struct Reading {
    gno_scene scene;
    gno_simulator simulator;
    std::thread adding;
    gno_status added = GNO_OK, read = GNO_OK;
  } reading = {car, simulator, {}};
  const auto receive = [](size_t, gno_scan, void* user) -> int32_t {
    auto& to = *static_cast<Reading*>(user);
    to.adding = std::thread(
        [&to] { to.added = gno_simulator_add_scene(to.simulator, to.scene, nullptr, nullptr, nullptr, nullptr); });
    std::this_thread::sleep_for(std::chrono::milliseconds(200));  // the other thread waits for the simulator now
    gno_scene_counts counts = gno_scene_counts_init();
    to.read = gno_scene_get_counts(to.scene, &counts);
    return 0;
  };
  const gno_shot shot = gno_shot_init();
  CHECK(gno_simulator_scan_all(simulator, &shot, 1, receive, &reading) == GNO_OK);
  reading.adding.join();
  CHECK(reading.added == GNO_OK);
  CHECK(reading.read == GNO_OK);
  CHECK(gno_simulator_destroy(simulator) == GNO_OK);
  CHECK(gno_scene_destroy(car) == GNO_OK);
}

TEST_CASE("C: a scan that is lent to a function cannot be the result of another simulator") {
  Wall wall;
  gno_simulator simulators[2] = {};
  for (gno_simulator& simulator : simulators) REQUIRE(wall.create(simulator) == GNO_OK);
  const gno_shot shot = gno_shot_init();
  const auto receive = [](size_t, gno_scan scan, void* user) -> int32_t {
    gno_scan into = scan;
    const gno_shot again = gno_shot_init();
    fails(gno_simulator_scan(static_cast<gno_simulator>(user), &again, &into), "this scan is in use");
    std::thread([&] {
      gno_status status = gno_simulator_scan(static_cast<gno_simulator>(user), &again, &into);
      if (status == GNO_INVALID_ARGUMENT) into = nullptr;
    }).join();
    CHECK(into == nullptr);
    gno_scan_info info = gno_scan_info_init();
    CHECK(gno_scan_get_info(scan, &info) == GNO_OK);
    CHECK(info.entries == 28800);
    return 0;
  };
  CHECK(gno_simulator_scan_all(simulators[0], &shot, 1, receive, simulators[1]) == GNO_OK);
  gno_scan scan = nullptr;
  CHECK(gno_simulator_scan(simulators[1], &shot, &scan) == GNO_OK);
  CHECK(gno_simulator_scan(simulators[0], &shot, &scan) == GNO_OK);
  CHECK(gno_scan_destroy(scan) == GNO_OK);
  for (const gno_simulator simulator : simulators) CHECK(gno_simulator_destroy(simulator) == GNO_OK);
}

TEST_CASE("C: an exception of a function of the caller is told as one, and the simulator goes on") {
  Wall wall;
  wall.options.materials = tableOfNothing();
  wall.options.warn = [](const char*, void*) { throw std::runtime_error("no ink"); };
  gno_simulator simulator = nullptr;
  CHECK(fails(wall.create(simulator), "gno_options::warn has thrown the exception 'no ink'", GNO_CANCELLED));
  CHECK(simulator == nullptr);
  wall.options.warn = nullptr;
  REQUIRE(wall.create(simulator) == GNO_OK);
  const gno_shot shot = gno_shot_init();
  const auto receive = [](size_t, gno_scan, void* user) -> int32_t {
    if (!user) throw 7;
    return 0;
  };
  CHECK(fails(gno_simulator_scan_all(simulator, &shot, 1, receive, nullptr), "must not throw", GNO_CANCELLED));
  CHECK(gno_simulator_scan_all(simulator, &shot, 1, receive, &wall) == GNO_OK);
  CHECK(gno_simulator_destroy(simulator) == GNO_OK);
  CHECK(gno_material_table_destroy(wall.options.materials) == GNO_OK);
}

TEST_CASE("C: a process that was forked is told to make simulators of its own, and can") {
  Wall wall;
  gno_simulator simulator = nullptr;
  REQUIRE(wall.create(simulator) == GNO_OK);
  const pid_t child = fork();
  if (child == 0) {
    alarm(100);
    const gno_shot shot = gno_shot_init();
    const gno_transform place = gno_instance_init().transform;
    gno_scan scan = nullptr;
    gno_batch batch = nullptr;
    int wrong = 0;
    const auto refused = [&](gno_status status) {
      wrong += status != GNO_INVALID_ARGUMENT || !std::strstr(gno_last_error(), "made by another process");
    };
    refused(gno_simulator_scan(simulator, &shot, &scan));
    refused(gno_simulator_scan_batch(simulator, &shot, 1, nullptr, 0, &batch));
    refused(gno_simulator_set_transform(simulator, 0, &place));
    wrong += gno_simulator_destroy(simulator) != GNO_OK;
    wrong += wall.create(simulator) != GNO_OK || gno_simulator_scan(simulator, &shot, &scan) != GNO_OK;
    _exit(wrong);
  }
  int status = -1;
  REQUIRE(waitpid(child, &status, 0) == child);
  CHECK(status == 0);
  CHECK(gno_simulator_destroy(simulator) == GNO_OK);
}

TEST_CASE("C: a forked process does not wait for a call of its parent, in which another thread was at the fork") {
  Wall wall;
  gno_simulator simulator = nullptr;
  REQUIRE(wall.create(simulator) == GNO_OK);
  struct Receiving {
    std::promise<void> begun, mayEnd;
  } receiving;
  std::thread scanning([&] {
    const gno_shot shot = gno_shot_init();
    const auto receive = [](size_t, gno_scan, void* user) -> int32_t {
      auto& to = *static_cast<Receiving*>(user);
      to.begun.set_value();
      to.mayEnd.get_future().wait();
      return 0;
    };
    CHECK(gno_simulator_scan_all(simulator, &shot, 1, receive, &receiving) == GNO_OK);
  });
  receiving.begun.get_future().wait();
  const pid_t child = fork();
  if (child == 0) {
    alarm(10);
    const gno_shot shot = gno_shot_init();
    gno_scan scan = nullptr;
    int wrong = gno_simulator_scan(simulator, &shot, &scan) != GNO_INVALID_ARGUMENT;
    wrong += gno_simulator_destroy(simulator) != GNO_OK;
    wrong += gno_simulator_destroy(simulator) != GNO_INVALID_ARGUMENT;  // the handle is gone
    _exit(wrong);
  }
  receiving.mayEnd.set_value();
  scanning.join();
  int status = -1;
  REQUIRE(waitpid(child, &status, 0) == child);
  CHECK(status == 0);
  CHECK(gno_simulator_destroy(simulator) == GNO_OK);
}

TEST_CASE("C: a forked process finds its handles, whatever other threads did with theirs at the fork") {
  const gno_scene scene = sceneWithWall();
  std::jthread busy([](const std::stop_token& stop) {
    gno_effects effects = nullptr;
    while (!stop.stop_requested()) gno_effects_set_seed(effects, 1);  // looks for the handle, which is null
  });
  for (int i = 0; i < 200; ++i) {
    const pid_t child = fork();
    if (child == 0) {
      alarm(10);
      _exit(gno_scene_validate(scene) != GNO_OK);
    }
    int status = -1;
    REQUIRE(waitpid(child, &status, 0) == child);
    REQUIRE(status == 0);
  }
  CHECK(gno_scene_destroy(scene) == GNO_OK);
}

TEST_CASE("C: a struct that would end within a pointer or a number is refused") {
  Wall wall;
  gno_simulator simulator = nullptr;
  REQUIRE(gno_options_set(&wall.options, "accuracy=exact") == GNO_OK);
  const size_t whole = wall.options.struct_size;
  for (size_t size = 9; size < whole; ++size) {
    wall.options.struct_size = size;
    if (size % 8 == 0)
      REQUIRE(gno_simulator_create(wall.scene, nullptr, 0, &wall.options, &simulator) == GNO_OK);
    else
      REQUIRE(fails(gno_simulator_create(wall.scene, nullptr, 0, &wall.options, &simulator), "which is no size of it"));
    if (size % 8 == 0) REQUIRE(gno_simulator_destroy(simulator) == GNO_OK);
  }
}

TEST_CASE("C: counts that overflow, numbers that are not finite and indices of nothing are named") {
  const gno_scene scene = sceneWithWall();
  gno_mesh mesh = gno_mesh_init();
  mesh.positions = kWall;
  mesh.vertex_count = 4;
  mesh.indices = kSquare;
  // Three times each of these numbers is small in 64 bits, or the number itself is in 32.
  for (const size_t count : {size_t{1} << 63, SIZE_MAX / 3 + 1, SIZE_MAX / 12 + 1}) {
    mesh.triangle_count = count;
    CHECK(fails(gno_scene_add_mesh(scene, &mesh, nullptr), "more than memory can hold"));
    mesh.triangle_count = 2;
    mesh.vertex_count = count;
    CHECK(fails(gno_scene_add_mesh(scene, &mesh, nullptr), "more than memory can hold"));
    mesh.vertex_count = 4;
  }
  mesh.triangle_count = (size_t{1} << 32) + 2;
  CHECK(fails(gno_scene_add_mesh(scene, &mesh, nullptr), "gno_mesh::triangle_count is 4294967298"));

  mesh.triangle_count = 2;
  mesh.origin[1] = std::nan("");
  REQUIRE(gno_scene_add_mesh(scene, &mesh, nullptr) == GNO_OK);
  CHECK(fails(gno_scene_validate(scene), "mesh 1: its origin is not finite"));
  CHECK(gno_scene_destroy(scene) == GNO_OK);

  const gno_scene other = sceneWithWall();
  gno_scene_counts counts = gno_scene_counts_init();
  gno_instance instance = gno_instance_init();
  instance.mesh = 3;
  REQUIRE(gno_scene_add_instance(other, &instance, nullptr) == GNO_OK);
  CHECK(fails(gno_scene_get_counts(other, &counts), "instance 0: mesh 3 does not exist"));
  CHECK(gno_scene_destroy(other) == GNO_OK);

  const gno_scene third = sceneWithWall();
  gno_material material = gno_material_init();
  material.metallic = std::nanf("");
  REQUIRE(gno_scene_add_material(third, &material, nullptr) == GNO_OK);
  gno_optics optics[2];
  size_t count = 0;
  CHECK(fails(gno_scene_get_optics(third, nullptr, 905, optics, 2, &count), "material 1: its metallic factor"));
  CHECK(gno_scene_destroy(third) == GNO_OK);
}

TEST_CASE("C: a layout without values, and a batch without shots where sensor 0 is gone, are named") {
  Wall wall;
  gno_simulator simulator = nullptr;
  REQUIRE(wall.create(simulator) == GNO_OK);
  gno_request request = wall.request;
  const gno_layout none = gno_layout_init();
  request.layout = &none;
  CHECK(fails(gno_simulator_add_sensor(simulator, &request, nullptr), "gno_request::layout has no values"));
  REQUIRE(gno_simulator_add_sensor(simulator, &wall.request, nullptr) == GNO_OK);
  REQUIRE(gno_simulator_remove_sensor(simulator, 0) == GNO_OK);
  gno_batch batch = nullptr;
  CHECK(fails(gno_simulator_scan_batch(simulator, nullptr, 0, nullptr, 0, &batch), "a batch without shots"));
  CHECK(gno_simulator_destroy(simulator) == GNO_OK);
}

TEST_CASE("C: rows whose bytes have no number are refused with a sentence that says so") {
  Wall wall;
  gno_simulator simulator = nullptr;
  REQUIRE(wall.create(simulator) == GNO_OK);
  const gno_shot shot = gno_shot_init();
  gno_scan scan = nullptr;
  REQUIRE(gno_simulator_scan(simulator, &shot, &scan) == GNO_OK);
  const gno_layout_value value = {GNO_FIELD_RANGE, 0, 0, GNO_F32, 0};
  gno_layout layout = gno_layout_init();
  layout.values = &value;
  layout.value_count = 1;
  layout.stride = size_t{1} << 63;
  float rows[4];
  size_t count = 0;
  CHECK(fails(gno_scan_pack(scan, &layout, rows, sizeof rows, &count), "have no size in 64 bits"));
  CHECK(gno_scan_destroy(scan) == GNO_OK);
  CHECK(gno_simulator_destroy(simulator) == GNO_OK);
}

}  // namespace gnosphere::test
