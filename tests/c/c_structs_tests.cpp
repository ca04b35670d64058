// SPDX-License-Identifier: Apache-2.0
// Handles, structs and options of the C interface: wrong ones are errors, and structs of older headers are understood.
#include <algorithm>
#include <cstddef>
#include <string>

#include "c/fails.hpp"
#include "c/floor_and_wall.hpp"
#include "folder.hpp"

namespace gnosphere::test {

TEST_CASE("C: a null, destroyed or foreign handle, a null pointer and a wrong struct are errors that say so") {
  gno_scene scene = makeScene();
  gno_scene_counts counts = gno_scene_counts_init();
  CHECK(fails(gno_scene_get_counts(nullptr, &counts), "the handle of the scene is null"));
  CHECK(fails(gno_scene_get_counts(reinterpret_cast<gno_scene>(&counts), &counts), "no scene"));
  CHECK(fails(gno_sensor_destroy(reinterpret_cast<gno_sensor>(scene)), "of a scene, not of a"));
  CHECK(fails(gno_scene_get_counts(scene, nullptr), "gno_scene_counts is null"));
  counts.struct_size += 8;  // of a newer library
  CHECK(fails(gno_scene_get_counts(scene, &counts), "gno_scene_counts::struct_size"));
  CHECK(fails(gno_scene_load(nullptr, nullptr, &scene), "file is null"));
  CHECK(fails(gno_scene_create(nullptr), "scene is null"));
  CHECK(fails(gno_sensor_builtin("VLP-16", nullptr), "sensor is null"));
  uint64_t bytes = 0;
  gno_layout layout = gno_layout_init();
  layout.stride = 12;
  CHECK(fails(gno_layout_bytes_for(&layout, uint64_t{1} << 62, &bytes), "no size in 64 bits"));
  CHECK(fails(gno_scene_load("/nowhere.glb", nullptr, &scene), "nowhere.glb", GNO_FILE));
  gno_mesh mesh = squareMesh();
  mesh.positions = nullptr;
  CHECK(fails(gno_scene_add_mesh(scene, &mesh, nullptr), "positions is null"));
  gno_material material = gno_material_init();
  material.alpha_mode = 9;
  CHECK(fails(gno_scene_add_material(scene, &material, nullptr), "alpha_mode is 9"));
  gno_simulator simulator = nullptr;
  gno_request request = gno_request_init();
  CHECK(fails(gno_simulator_create(scene, &request, 1, nullptr, &simulator), "sensor is null"));
  CHECK(fails(gno_simulator_create(scene, nullptr, 1, nullptr, &simulator), "sensors is null"));
  gno_options options = gno_options_init();
  options.device = "no such device";
  CHECK(fails(gno_simulator_create(scene, nullptr, 0, &options, &simulator), "no such device"));
  options.device = "reference";
  options.device_uuid[3] = 7;  // of no device
  CHECK(gno_simulator_create(scene, nullptr, 0, &options, &simulator) != GNO_OK);
  CHECK(simulator == nullptr);

  simulator = makeSimulator(scene, "clean", {});
  gno_shot shot = gno_shot_init();
  gno_scan scan = nullptr;
  shot.sensor = 4;
  CHECK(fails(gno_simulator_scan(simulator, &shot, &scan), "sensor 4"));
  shot.sensor = 0;
  CHECK(gno_simulator_scan(simulator, &shot, &scan) == GNO_OK);
  gno_column column = gno_column_init();
  CHECK(fails(gno_scan_get_column(scan, GNO_FIELD_NORMAL, &column), "normal"));
  CHECK(fails(gno_scan_get_column(scan, 4711, &column), "4711"));
  CHECK(gno_scan_destroy(scan) == GNO_OK);
  CHECK(fails(gno_scan_destroy(scan), "destroyed"));
  CHECK(fails(gno_simulator_scan(simulator, &shot, &scan), "destroyed"));
  CHECK(gno_simulator_destroy(simulator) == GNO_OK);
  CHECK(fails(gno_simulator_scan(simulator, &shot, &scan), "destroyed"));
  CHECK(gno_scene_destroy(scene) == GNO_OK);
  CHECK(fails(gno_scene_validate(scene), "destroyed"));
}

namespace {

/// A struct as a program has it that was compiled with an older header: it ends before `end`, and what follows in
/// memory is something else.
template <class T>
class Older {
 public:
  Older(const T& from, size_t end) : bytes_(sizeof(T), std::byte{0xa5}), size_(end) {
    std::memcpy(bytes_.data(), &from, end);
    std::memcpy(bytes_.data(), &end, sizeof end);
  }
  T* get() { return reinterpret_cast<T*>(bytes_.data()); }
  bool untouched() const {
    return std::all_of(bytes_.begin() + static_cast<std::ptrdiff_t>(size_), bytes_.end(),
                       [](std::byte byte) { return byte == std::byte{0xa5}; });
  }

 private:
  std::vector<std::byte> bytes_;
  size_t size_;
};

}  // namespace

TEST_CASE("C: structs of an older header are taken with defaults for what they lack, and filled as far as they go") {
  gno_scene scene = makeScene();
  gno_sensor sensor = nullptr;
  REQUIRE(gno_sensor_builtin("VLP-16", &sensor) == GNO_OK);
  gno_options options = onReference();
  gno_request request = gno_request_init();
  request.sensor = sensor;
  Older<gno_options> olderOptions(options, offsetof(gno_options, validation));
  gno_simulator simulator = nullptr, other = nullptr;
  // Two requests of an older size lie as far apart as their size says.
  const size_t requestSize = offsetof(gno_request, variable_weather);
  std::vector<std::byte> requests(2 * requestSize);
  request.struct_size = requestSize;
  for (size_t i = 0; i < 2; ++i) std::memcpy(requests.data() + i * requestSize, &request, requestSize);
  REQUIRE(gno_simulator_create(scene, reinterpret_cast<gno_request*>(requests.data()), 2, olderOptions.get(),
                               &simulator) == GNO_OK);
  request = gno_request_init();
  request.sensor = sensor;
  REQUIRE(gno_simulator_create(scene, &request, 1, &options, &other) == GNO_OK);
  CHECK(olderOptions.untouched());
  gno_shot shot = gno_shot_init();
  shot.pose.position[2] = 1.8;
  shot.sensor = 1;
  Older<gno_shot> olderShot(shot, offsetof(gno_shot, motion));
  gno_scan a = nullptr, b = nullptr;
  REQUIRE(gno_simulator_scan(simulator, olderShot.get(), &a) == GNO_OK);
  shot.sensor = 0;
  REQUIRE(gno_simulator_scan(other, &shot, &b) == GNO_OK);
  gno_counters whole = gno_counters_init();
  REQUIRE(gno_scan_get_counters(b, &whole) == GNO_OK);
  CHECK(whole.hits > 0);
  Older<gno_counters> older(gno_counters_init(), offsetof(gno_counters, triangles));
  REQUIRE(gno_scan_get_counters(a, older.get()) == GNO_OK);
  CHECK(older.untouched());
  CHECK(older.get()->hits == whole.hits);
  CHECK(older.get()->misses == whole.misses);
  CHECK(older.get()->struct_size == offsetof(gno_counters, triangles));
  // Instances of an older size, too, and options that end before their last member.
  const size_t instanceSize = offsetof(gno_instance, world);
  gno_instance instance = gno_instance_init();
  instance.struct_size = instanceSize;
  std::vector<std::byte> instances(2 * instanceSize);
  for (size_t i = 0; i < 2; ++i) std::memcpy(instances.data() + i * instanceSize, &instance, instanceSize);
  uint32_t added[2] = {};
  CHECK(gno_simulator_add_instances(other, reinterpret_cast<gno_instance*>(instances.data()), 2, added) == GNO_OK);
  CHECK(added[1] == added[0] + 1);
  const Folder folder;
  const std::string file = put(folder / "floor.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").string();
  gno_load_options load = gno_load_options_init();
  load.scale = 1000;
  Older<gno_load_options> olderLoad(load, offsetof(gno_load_options, scale));
  std::memcpy(reinterpret_cast<std::byte*>(olderLoad.get()) + offsetof(gno_load_options, scale), &load.scale,
              sizeof load.scale);
  gno_scene loaded = nullptr;
  REQUIRE(gno_scene_load(file.c_str(), olderLoad.get(), &loaded) == GNO_OK);
  gno_mesh mesh = gno_mesh_init();
  REQUIRE(gno_scene_get_mesh(loaded, 0, &mesh) == GNO_OK);
  CHECK(*std::max_element(mesh.positions, mesh.positions + 9) <= 1);
  CHECK(gno_scene_destroy(loaded) == GNO_OK);

  whole.struct_size = 4;
  CHECK(fails(gno_scan_get_counters(b, &whole), "which is no size of it"));
  for (const gno_scan scan : {a, b}) CHECK(gno_scan_destroy(scan) == GNO_OK);
  for (const gno_simulator each : {simulator, other}) CHECK(gno_simulator_destroy(each) == GNO_OK);
  CHECK(gno_sensor_destroy(sensor) == GNO_OK);
  CHECK(gno_scene_destroy(scene) == GNO_OK);
}

TEST_CASE("C: settings that an older program gets, changes and sets leave what it does not know") {
  gno_sensor sensor = nullptr;
  REQUIRE(gno_sensor_builtin("OS0-32", &sensor) == GNO_OK);
  gno_sensor_settings whole = gno_sensor_settings_init();
  REQUIRE(gno_sensor_get_settings(sensor, &whole) == GNO_OK);
  const double before = whole.range_at_10_percent;
  REQUIRE(before > 0);
  Older<gno_sensor_settings> older(gno_sensor_settings_init(), offsetof(gno_sensor_settings, range_at_10_percent));
  REQUIRE(gno_sensor_get_settings(sensor, older.get()) == GNO_OK);
  older.get()->name = "roof";
  REQUIRE(gno_sensor_set_settings(sensor, older.get()) == GNO_OK);
  REQUIRE(gno_sensor_get_settings(sensor, &whole) == GNO_OK);
  CHECK(std::string(whole.name) == "roof");
  CHECK(whole.range_at_10_percent == before);
  CHECK(gno_sensor_destroy(sensor) == GNO_OK);
}

TEST_CASE("C: an error in an array says which entry it is about") {
  gno_scene scene = makeScene();
  gno_sensor sensor = nullptr;
  REQUIRE(gno_sensor_builtin("VLP-16", &sensor) == GNO_OK);
  gno_options options = onReference();
  gno_request requests[2] = {gno_request_init(), gno_request_init()};
  requests[0].sensor = sensor;
  gno_simulator simulator = nullptr;
  CHECK(fails(gno_simulator_create(scene, requests, 2, &options, &simulator), "sensors[1]: the handle"));
  requests[1].sensor = sensor;
  requests[1].field_count = 1;
  CHECK(fails(gno_simulator_create(scene, requests, 2, &options, &simulator), "sensors[1]: fields is null"));
  REQUIRE(gno_simulator_create(scene, requests, 1, &options, &simulator) == GNO_OK);

  gno_shot shots[3] = {gno_shot_init(), gno_shot_init(), gno_shot_init()};
  gno_batch batch = nullptr;
  shots[2].motion_count = 1;
  CHECK(fails(gno_simulator_scan_batch(simulator, shots, 3, nullptr, 0, &batch), "shots[2]: gno_shot::motion is null"));
  shots[2] = gno_shot_init();
  shots[2].struct_size = 8;  // which an older library would take for that of a program that knows no pose
  CHECK(fails(gno_simulator_scan_batch(simulator, shots, 3, nullptr, 0, &batch), "shots[2]: its struct_size is 8"));
  gno_instance instances[2] = {gno_instance_init(), gno_instance_init()};
  instances[1].struct_size = 16;
  CHECK(fails(gno_simulator_add_instances(simulator, instances, 2, nullptr), "instances[1]: its struct_size is 16"));
  gno_beam_list lists[2] = {gno_beam_list_init(), gno_beam_list_init()};
  const double ahead[] = {1, 0, 0};
  lists[0].directions = ahead;
  lists[0].beam_count = 1;
  gno_sensor_settings settings = gno_sensor_settings_init();
  gno_sensor ofLists = nullptr;
  CHECK(fails(gno_sensor_create_list(&settings, lists, 2, &ofLists), "patterns[1]: gno_beam_list::directions is null"));
  CHECK(gno_simulator_destroy(simulator) == GNO_OK);
  CHECK(gno_sensor_destroy(sensor) == GNO_OK);
  CHECK(gno_scene_destroy(scene) == GNO_OK);
}

TEST_CASE("C: options are set by their names") {
  gno_options options = onReference();
  CHECK(gno_options_set(&options, "accuracy=exact") == GNO_OK);
  CHECK(gno_options_set(&options, "faces=front") == GNO_OK);
  const std::string both = options.assignments;
  CHECK(fails(gno_options_set(&options, "tuning.bining=lists"), "tuning.binning"));
  CHECK(fails(gno_options_set(&options, "faces=back"), "material, front or both"));
  CHECK(fails(gno_options_set(nullptr, "faces=front"), "gno_options is null"));
  CHECK(fails(gno_options_set(&options, nullptr), "assignment is null"));
  CHECK(options.assignments == both);
  gno_options again = gno_options_init();
  CHECK(gno_options_set(&again, "accuracy=exact") == GNO_OK);
  CHECK(gno_options_set(&again, "faces=front") == GNO_OK);
  CHECK(again.assignments == options.assignments);  // kept once
  CHECK(gno_options_set(&again, "accuracy=draft") == GNO_OK);
  CHECK(std::string(again.assignments) == "faces=front\naccuracy=draft");  // in place of the accuracy before

  // The materials reflect on both sides, unless the option says otherwise: from below the floor is seen from behind.
  gno_scene scene = makeScene();
  gno_sensor sensor = nullptr;
  REQUIRE(gno_sensor_builtin("VLP-16", &sensor) == GNO_OK);
  gno_request request = gno_request_init();
  request.sensor = sensor;
  uint64_t hits[2] = {};
  for (int i = 0; i < 2; ++i) {
    gno_simulator simulator = nullptr;
    REQUIRE(gno_simulator_create(scene, &request, 1, &options, &simulator) == GNO_OK);
    gno_shot shot = gno_shot_init();
    shot.pose.position[2] = -1.8;
    gno_counters counters = gno_counters_init();
    gno_scan scan = nullptr;
    REQUIRE(gno_simulator_scan(simulator, &shot, &scan) == GNO_OK);
    REQUIRE(gno_scan_get_counters(scan, &counters) == GNO_OK);
    hits[i] = counters.hits;
    CHECK(gno_scan_destroy(scan) == GNO_OK);
    CHECK(gno_simulator_destroy(simulator) == GNO_OK);
    options.assignments = nullptr;
  }
  CHECK(hits[0] < hits[1]);
  CHECK(gno_sensor_destroy(sensor) == GNO_OK);
  CHECK(gno_scene_destroy(scene) == GNO_OK);
}

}  // namespace gnosphere::test
