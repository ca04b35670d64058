// SPDX-License-Identifier: Apache-2.0
// The C interface against the C++ one: the same scans.
#include <gnosphere.h>

#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <cstring>
#include <filesystem>
#include <gnosphere/gnosphere.hpp>
#include <string>
#include <thread>

#include "c/fails.hpp"
#include "c/floor_and_wall.hpp"
#include "folder.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

namespace {

Scene sameScene() {
  Scene scene;
  scene.materials = {{}};
  Mesh mesh;
  mesh.name = "square";
  mesh.positions.assign(std::begin(kFloor), std::end(kFloor));
  mesh.indices.assign(std::begin(kSquare), std::end(kSquare));
  mesh.parts = {{0, 2, 0}};
  scene.meshes = {mesh};
  Instance floor, wall;
  floor.classId = 7;
  wall.transform = {{0, 0, 1, 8, 0, 1, 0, 0, -1, 0, 0, 0}};
  scene.instances = {floor, wall};
  return scene;
}

/// Compares a column of a C scan with that of a C++ scan, byte by byte.
template <class T>
bool sameColumn(gno_scan scan, gno_field field, const Scan& expected) {
  gno_column column = gno_column_init();
  REQUIRE(gno_scan_get_column(scan, field, &column) == GNO_OK);
  const auto view = expected.column<T>(static_cast<Field>(field));
  if (column.entries != view.size() || column.stride != view.stride()) return false;
  const auto* values = static_cast<const T*>(column.values);
  for (size_t i = 0; i < view.size(); ++i)
    if (std::memcmp(&values[i * column.stride], &view[i], sizeof(T)) != 0) return false;
  return true;
}

}  // namespace

TEST_CASE("C: a scene from arrays scans as the same scene does in C++, in every field and after every change") {
  gno_scene scene = makeScene();
  gno_simulator simulator =
      makeSimulator(scene, "auto", {GNO_FIELD_INTENSITY, GNO_FIELD_NORMAL, GNO_FIELD_CLASS_ID, GNO_FIELD_TIME});
  SimulatorOptions options;
  options.device = DeviceChoice::Kind::reference;
  Simulator expected(
      sameScene(),
      {builtinSensor("VLP-16"), effectPreset("auto"), {Field::intensity, Field::normal, Field::classId, Field::time}},
      options);
  const auto compareAll = [&](const Shot& shot, const gno_shot& cShot, gno_scan& scan) {
    Scan wanted;
    expected.scanInto(shot, wanted);
    REQUIRE(gno_simulator_scan(simulator, &cShot, &scan) == GNO_OK);
    for (gno_field field : {GNO_FIELD_X, GNO_FIELD_Z, GNO_FIELD_RANGE, GNO_FIELD_INTENSITY, GNO_FIELD_NORMAL,
                            GNO_FIELD_TIME, GNO_FIELD_TOLERANCE})
      CHECK(sameColumn<float>(scan, field, wanted));
    CHECK(sameColumn<uint32_t>(scan, GNO_FIELD_INSTANCE, wanted));
    CHECK(sameColumn<uint16_t>(scan, GNO_FIELD_CLASS_ID, wanted));
    CHECK(sameColumn<uint8_t>(scan, GNO_FIELD_TIE, wanted));
    gno_counters counters = gno_counters_init();
    REQUIRE(gno_scan_get_counters(scan, &counters) == GNO_OK);
    CHECK(counters.hits == wanted.counters.hits);
    CHECK(counters.hits > 0);
  };
  gno_scan scan = nullptr;
  gno_shot cShot = gno_shot_init();
  cShot.pose = {{0, 0, 1.8}, {0, 0, 0.6, 0.8}};
  cShot.frame = 3;
  Shot shot;
  shot.pose = {{0, 0, 1.8}, {0, 0, 0.6, 0.8}};
  shot.frame = 3;
  compareAll(shot, cShot, scan);

  const gno_transform place = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1}};
  CHECK(gno_simulator_set_transform(simulator, 0, &place) == GNO_OK);
  expected.setTransform(0, {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1}});
  const uint32_t both[2] = {1, 0};
  const double placed[24] = {1, 0, 0, 0, 0, 1, 0, 0.5, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1.25};
  CHECK(gno_simulator_set_transforms(simulator, both, 2, placed, 12) == GNO_OK);
  expected.setTransforms(both, placed);
  const float pose[7] = {0, 0, 1.5f, 0, 0, 0, 1};
  CHECK(gno_simulator_set_transforms_float(simulator, both + 1, 1, pose, 7) == GNO_OK);
  expected.setTransforms({both + 1, 1}, pose);
  CHECK(fails(gno_simulator_set_transforms(simulator, both, 2, placed, 8), "12 or 7 numbers"));
  CHECK(gno_simulator_remove_instance(simulator, 1) == GNO_OK);
  expected.removeInstance(1);
  const uint8_t alpha[] = {0, 255};
  gno_alpha_image image = gno_alpha_image_init();
  image.width = 2;
  image.height = 1;
  image.alpha = alpha;
  gno_material leaf = gno_material_init();
  leaf.alpha_mode = GNO_ALPHA_MASK;
  size_t added = 99;
  CHECK(gno_simulator_add_material(simulator, &leaf, &image, &added) == GNO_OK);
  CHECK(added == 1);
  CHECK(gno_simulator_add_material(simulator, &leaf, nullptr, &added) == GNO_OK);
  CHECK(added == 2);
  Material leafHere;
  leafHere.alphaMode = AlphaMode::mask;
  const AlphaImage imageHere = {2, 1, {0, 255}};
  expected.addMaterial(leafHere, &imageHere);
  expected.addMaterial(leafHere);
  const float uvs[] = {0, 0, 1, 0, 1, 1, 0, 1};
  const gno_mesh_part parts[] = {{0, 1, 1}, {1, 1, 2}};
  gno_mesh mesh = squareMesh();
  mesh.uvs = uvs;
  mesh.parts = parts;
  mesh.part_count = 2;
  CHECK(gno_simulator_add_mesh(simulator, &mesh, &added) == GNO_OK);
  CHECK(added == 1);
  Mesh meshHere = sameScene().meshes[0];
  meshHere.uvs.assign(std::begin(uvs), std::end(uvs));
  meshHere.parts = {{0, 1, 1}, {1, 1, 2}};
  expected.addMesh(meshHere);
  gno_instance instance = gno_instance_init();
  instance.mesh = 1;
  instance.transform.rows[11] = 4;
  CHECK(gno_simulator_add_instance(simulator, &instance, &added) == GNO_OK);
  expected.addInstance(1, {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 4}});
  float moved[12];
  std::copy(std::begin(kFloor), std::end(kFloor), moved);
  moved[2] = 2;
  CHECK(gno_simulator_set_positions(simulator, 1, moved, 4) == GNO_OK);
  expected.setPositions(1, moved);
  gno_material dark = gno_material_init();
  dark.base_color[0] = 0.1f;
  CHECK(gno_simulator_set_material(simulator, 0, &dark, nullptr) == GNO_OK);
  Material darkHere;
  darkHere.baseColor[0] = 0.1f;
  expected.setMaterial(0, darkHere);
  CHECK(fails(gno_simulator_set_material(simulator, 5, &dark, nullptr), "material 5"));
  gno_scan before = scan, inTheWorld = nullptr;
  compareAll(shot, cShot, scan);
  REQUIRE(gno_scan_in_world(scan, &inTheWorld) == GNO_OK);
  Scan wanted;
  expected.scanInto(shot, wanted);
  wanted = inWorld(wanted);
  for (gno_field field : {GNO_FIELD_X, GNO_FIELD_Y, GNO_FIELD_Z, GNO_FIELD_NORMAL})
    CHECK(sameColumn<float>(inTheWorld, field, wanted));
  CHECK(gno_scan_destroy(inTheWorld) == GNO_OK);
  CHECK(fails(gno_scan_in_world(scan, nullptr), "in_world is null"));
  CHECK(before == scan);

  // The same rows, files and comparison.
  expected.scanInto(shot, wanted);
  gno_layout_value values[] = {{GNO_FIELD_X, 0, 0, GNO_F32}, {GNO_FIELD_INSTANCE, 0, 8, GNO_F64}};
  gno_layout layout = gno_layout_init();
  layout.values = values;
  layout.value_count = 2;
  layout.stride = 16;
  std::vector<std::byte> rows(wanted.ranges.size() * 16), same(rows.size());
  size_t count = 0;
  REQUIRE(gno_scan_pack(scan, &layout, rows.data(), rows.size(), &count) == GNO_OK);
  CHECK(count == pack(wanted, {{{Field::x, 0, 0}, {Field::instance, 0, 8, ValueType::f64}}, 16, false}, same));
  CHECK(rows == same);
  const test::Folder folder;
  REQUIRE(gno_scan_write(scan, (folder / "cloud.npy").string().c_str(), nullptr) == GNO_OK);
  gno_scan read = nullptr;
  REQUIRE(gno_scan_read((folder / "cloud.npy").string().c_str(), &read) == GNO_OK);
  gno_comparison comparison = gno_comparison_init();
  REQUIRE(gno_scan_compare(scan, read, 1e-3, &comparison) == GNO_OK);
  CHECK(comparison.hits == wanted.counters.hits);
  CHECK(comparison.missed + comparison.false_hits + comparison.wrong_owner + comparison.wrong_range == 0);

  CHECK(gno_scan_destroy(read) == GNO_OK);
  gno_cloud_options cloud = gno_cloud_options_init();
  const gno_field columns[] = {GNO_FIELD_RANGE, GNO_FIELD_BEAM};
  cloud.fields = columns;
  cloud.field_count = 2;
  cloud.ascii = 1;
  REQUIRE(wanted.counters.hits < wanted.ranges.size());
  for (const size_t points : {wanted.ranges.size(), wanted.counters.hits}) {
    cloud.compact = points == wanted.counters.hits;
    REQUIRE(gno_scan_write(scan, (folder / "cloud.pcd").string().c_str(), &cloud) == GNO_OK);
    const std::string text = test::bytesOf(folder / "cloud.pcd");
    CHECK(text.find("\nFIELDS range beam\n") != text.npos);
    CHECK(text.find("\nPOINTS " + std::to_string(points) + "\nDATA ascii\n") != text.npos);
  }
  CHECK(gno_scan_destroy(scan) == GNO_OK);
  CHECK(gno_simulator_destroy(simulator) == GNO_OK);
  CHECK(gno_scene_destroy(scene) == GNO_OK);
}

TEST_CASE("C: a comparison has every number that it has in C++") {
  // As many beams of each kind as its number says; a tie is a beam that the reference marks.
  const struct {
    int count;
    bool expected, found, sameOwner, tie;
    double error;
  } kinds[] = {{1, true, false, true, false, 0}, {2, false, true, true, false, 0}, {3, true, true, false, false, 0},
               {4, true, false, true, true, 0},  {5, false, true, true, true, 0},  {6, true, true, false, true, 0.25},
               {7, true, true, true, false, 0.5}};
  std::string first = "range,beam,triangle,instance,tie\n", second = first;
  const auto add = [](std::string& text, int beam, bool there, double range, int triangle, bool tie) {
    text += (there ? std::to_string(range) : "nan") + "," + std::to_string(beam) + "," +
            (there ? std::to_string(triangle) + ",0," : "4294967295,4294967295,") + (tie ? "1\n" : "0\n");
  };
  int beam = 0;
  for (const auto& kind : kinds)
    for (int i = 0; i < kind.count; ++i, ++beam) {
      add(first, beam, kind.expected, 10, 0, kind.tie);
      add(second, beam, kind.found, 10 + kind.error, kind.sameOwner ? 0 : 1, false);
    }
  const test::Folder folder;
  gno_scan a = nullptr, b = nullptr;
  REQUIRE(gno_scan_read(test::put(folder / "a.csv", first).string().c_str(), &a) == GNO_OK);
  REQUIRE(gno_scan_read(test::put(folder / "b.csv", second).string().c_str(), &b) == GNO_OK);
  gno_comparison c = gno_comparison_init();
  REQUIRE(gno_scan_compare(a, b, 1e-3, &c) == GNO_OK);
  CHECK((c.beams == 28 && c.hits == 21));
  CHECK((c.missed == 1 && c.false_hits == 2 && c.wrong_owner == 3 && c.wrong_range == 7));
  CHECK((c.tie_missed == 4 && c.tie_false_hits == 5 && c.tie_wrong_owner == 6));
  CHECK((c.ties == 15 && c.tie_differences == 15));
  CHECK((c.tie_error_max == 0.25 && c.range_error_max == 0.5 && c.hit_error_max == 0.5));
  CHECK((c.range_error_9999 == 0.5 && c.range_error_rms == 0.5));
  CHECK(gno_scan_destroy(a) == GNO_OK);
  CHECK(gno_scan_destroy(b) == GNO_OK);
}

TEST_CASE("C: a scene is joined to another, and added to a simulator, as in C++") {
  gno_scene town = makeScene(), car = makeScene();
  const gno_transform place = {{0, -1, 0, 3, 1, 0, 0, 2, 0, 0, 1, 0.5}};
  gno_simulator simulator = makeSimulator(town, "clean", {});
  uint32_t materials[1] = {}, meshes[1] = {}, instances[2] = {}, first = 0;
  REQUIRE(gno_simulator_add_scene(simulator, car, &place, materials, meshes, instances) == GNO_OK);
  CHECK((materials[0] == 1 && meshes[0] == 1 && instances[0] == 2 && instances[1] == 3));
  REQUIRE(gno_scene_join(town, car, &place, &first) == GNO_OK);
  CHECK(first == 2);
  gno_simulator joinedSimulator = makeSimulator(town, "clean", {});
  Transform placed;
  std::copy(std::begin(place.rows), std::end(place.rows), placed.rows.begin());
  Simulator expected(joined(sameScene(), sameScene(), placed), {builtinSensor("VLP-16"), Effects::none()}, []() {
    SimulatorOptions options;
    options.device = deviceByName("reference");
    return options;
  }());
  gno_shot shot = gno_shot_init();
  shot.pose.position[2] = 1.8;
  const Scan scan = expected.scan({{0, 0, 1.8}, {}});
  for (const gno_simulator each : {simulator, joinedSimulator}) {
    gno_scan got = nullptr;
    REQUIRE(gno_simulator_scan(each, &shot, &got) == GNO_OK);
    CHECK(sameColumn<float>(got, GNO_FIELD_RANGE, scan));
    CHECK(sameColumn<uint32_t>(got, GNO_FIELD_INSTANCE, scan));
    CHECK(gno_scan_destroy(got) == GNO_OK);
    CHECK(gno_simulator_destroy(each) == GNO_OK);
  }
  CHECK(std::ranges::count(scan.instances, 3u) > 0);
  REQUIRE(gno_scene_join(car, car, nullptr, nullptr) == GNO_OK);
  gno_scene_counts counts = gno_scene_counts_init();
  REQUIRE(gno_scene_get_counts(car, &counts) == GNO_OK);
  CHECK((counts.materials == 2 && counts.meshes == 2 && counts.instances == 4));
  CHECK(fails(gno_scene_join(car, nullptr, nullptr, nullptr), "the handle of the scene is null"));
  for (const gno_scene scene : {town, car}) CHECK(gno_scene_destroy(scene) == GNO_OK);
}

TEST_CASE("C: classes of materials and instances, by number and name, are what they were given as") {
  gno_scene scene = makeScene();
  gno_material material = gno_material_init();
  material.class_id = 65535;
  material.class_name = "road";
  gno_instance instance = gno_instance_init();
  instance.class_name = "house";
  REQUIRE(gno_scene_add_material(scene, &material, nullptr) == GNO_OK);
  REQUIRE(gno_scene_add_instance(scene, &instance, nullptr) == GNO_OK);
  material = gno_material_init();
  instance = gno_instance_init();
  REQUIRE(gno_scene_get_material(scene, 1, &material) == GNO_OK);
  REQUIRE(gno_scene_get_instance(scene, 2, &instance) == GNO_OK);
  CHECK(material.class_id == 65535);
  CHECK(std::strcmp(material.class_name, "road") == 0);
  CHECK(std::strcmp(instance.class_name, "house") == 0);
  REQUIRE(gno_scene_get_material(scene, 0, &material) == GNO_OK);
  CHECK((material.class_id == 0 && material.class_name[0] == 0));
  CHECK(gno_scene_destroy(scene) == GNO_OK);
}

TEST_CASE("C: sensors from JSON, grids and lists have the beams that C++ gives them") {
  gno_sensor sensor = nullptr, list = nullptr;
  gno_channel channels[2] = {};
  channels[1].elevation_deg = 3;
  channels[1].origin[2] = 0.1;
  gno_grid grid = gno_grid_init();
  grid.columns = 90;
  grid.channels = channels;
  grid.channel_count = 2;
  gno_sensor_settings settings = gno_sensor_settings_init();
  settings.name = "mine";
  settings.range_max = 50;
  settings.range_at_10_percent = 20;
  settings.scan_period = 0.2;
  REQUIRE(gno_sensor_create_grid(&settings, &grid, &sensor) == GNO_OK);
  gno_beam_list beams = gno_beam_list_init();
  REQUIRE(gno_sensor_get_beams(sensor, 0, &beams) == GNO_OK);
  Sensor expected;
  expected.columns = 90;
  expected.channels = {{}, {3, 0, {0, 0, 0.1}}};
  expected.rangeMax = 50;
  const BeamList wanted = beamsOf(expected);
  REQUIRE(beams.beam_count == wanted.size());
  for (size_t i = 0; i < wanted.size(); ++i)
    REQUIRE((beams.directions[3 * i] == wanted.directions[i].x && beams.origins[3 * i + 2] == wanted.origins[i].z));

  // The beams of the grid as a list, through JSON and back.
  REQUIRE(gno_sensor_create_list(&settings, &beams, 1, &list) == GNO_OK);
  const char* json = nullptr;
  REQUIRE(gno_sensor_to_json(list, &json) == GNO_OK);
  gno_sensor again = nullptr;
  REQUIRE(gno_sensor_from_json(json, &again) == GNO_OK);
  gno_sensor_size size = gno_sensor_size_init();
  REQUIRE(gno_sensor_get_size(again, &size) == GNO_OK);
  CHECK((size.beams == 180 && size.patterns == 1));
  gno_sensor_settings got = gno_sensor_settings_init();
  REQUIRE(gno_sensor_get_settings(again, &got) == GNO_OK);
  CHECK((got.range_max == 50 && got.range_at_10_percent == 20 && got.scan_period == 0.2));
  for (gno_sensor each : {sensor, list, again}) CHECK(gno_sensor_destroy(each) == GNO_OK);

  gno_effects effects = nullptr;
  REQUIRE(gno_effects_create(&effects) == GNO_OK);
  CHECK(gno_effects_assign(effects, "fog.visibility=200") == GNO_OK);
  CHECK(gno_effects_set_seed(effects, 5) == GNO_OK);
  REQUIRE(gno_effects_to_json(effects, &json) == GNO_OK);
  CHECK(effectsFromJson(json, "").fog.visibility == 200);
  CHECK(effectsFromJson(json, "").seed == 5);
  CHECK(gno_effects_destroy(effects) == GNO_OK);
}

TEST_CASE("C: the effects of one of the lidars in a file of CARLA") {
  const test::Folder folder;
  const std::string file =
      test::put(folder / "objects.json", R"([{"type": "sensor.lidar.ray_cast", "id": "top", "noise_stddev": 0.02},
                                       {"type": "sensor.lidar.ray_cast", "id": "low", "noise_seed": 9}])")
          .string();
  gno_effects effects = nullptr;
  CHECK(fails(gno_effects_load(file.c_str(), &effects), "the effects of the lidars top, low differ", GNO_FORMAT));
  REQUIRE(gno_effects_load_mode(file.c_str(), "low", &effects) == GNO_OK);
  const char* json = nullptr;
  REQUIRE(gno_effects_to_json(effects, &json) == GNO_OK);
  CHECK(effectsFromJson(json, "").seed == 9);
  CHECK(gno_effects_destroy(effects) == GNO_OK);
}

TEST_CASE("C: a sensor file from memory, and the parts of an accuracy") {
  const std::string json = toJson(builtinSensor("VLP-16"));
  gno_sensor sensor = nullptr;
  REQUIRE(gno_sensor_read(json.data(), json.size(), "head.json", nullptr, &sensor) == GNO_OK);
  gno_sensor_size size = gno_sensor_size_init();
  REQUIRE(gno_sensor_get_size(sensor, &size) == GNO_OK);
  CHECK(size.beams == 28800);
  const char* report = nullptr;
  REQUIRE(gno_sensor_get_report(sensor, &report) == GNO_OK);
  CHECK(std::string(report).find(readSensorFile(json, "head.json").family) == 0);
  CHECK(gno_sensor_destroy(sensor) == GNO_OK);
  const std::string beams = "azimuth,elevation\n0,0\n1,0\n2,0\n3,0\n";
  gno_sensor_file_options options = gno_sensor_file_options_init();
  options.beams_per_scan = 2;
  REQUIRE(gno_sensor_read(beams.data(), beams.size(), "beams.csv", &options, &sensor) == GNO_OK);
  REQUIRE(gno_sensor_get_size(sensor, &size) == GNO_OK);
  CHECK((size.beams == 2 && size.patterns == 2));
  CHECK(gno_sensor_destroy(sensor) == GNO_OK);
  CHECK(fails(gno_sensor_read("{", 1, "bad.json", nullptr, &sensor), "bad.json", GNO_FORMAT));
  CHECK(fails(gno_sensor_read(nullptr, 1, "bad.json", nullptr, &sensor), "bytes is null"));
}

TEST_CASE("C: a run hands its scans to a function, which may end it but not call the simulator") {
  gno_scene scene = makeScene();
  gno_simulator simulator = makeSimulator(scene, "clean", {});
  struct Received {
    gno_simulator simulator;
    size_t shots, hits;
    gno_scan kept;
  } received{simulator, 0, 0, nullptr};
  const auto receive = [](size_t shot, gno_scan scan, void* user) -> int32_t {
    auto& to = *static_cast<Received*>(user);
    gno_counters counters = gno_counters_init();
    gno_scan_get_counters(scan, &counters);
    to.hits += counters.hits;
    to.kept = scan;
    fails(gno_simulator_remove_instance(to.simulator, 0), "must not call it");
    fails(gno_simulator_destroy(to.simulator), "must not call it");
    fails(gno_scan_destroy(scan), "belongs to the library");
    ++to.shots;
    return shot == 1;
  };
  gno_shot shots[3] = {gno_shot_init(), gno_shot_init(), gno_shot_init()};
  for (gno_shot& shot : shots) shot.pose.position[2] = 1.8;
  CHECK(gno_simulator_scan_all(simulator, shots, 3, receive, &received) == GNO_CANCELLED);
  CHECK(received.shots == 2);
  CHECK(received.hits > 0);
  gno_scan_info info = gno_scan_info_init();
  CHECK(fails(gno_scan_get_info(received.kept, &info), "destroyed"));
  CHECK(gno_simulator_scan_all(simulator, shots, 1, receive, &received) == GNO_OK);  // the next run is a run like any
  CHECK(gno_simulator_destroy(simulator) == GNO_OK);
  CHECK(gno_scene_destroy(scene) == GNO_OK);
}

TEST_CASE("C: a function that receives warnings must not call the simulator that warns") {
  gno_scene scene = makeScene();
  gno_sensor sensor = nullptr;
  REQUIRE(gno_sensor_builtin("VLP-16", &sensor) == GNO_OK);
  struct Warned {
    gno_simulator simulator = nullptr;
    int count = 0, refused = 0;
  } warned;
  gno_options options = onReference();
  options.user = &warned;
  options.warn = [](const char*, void* user) {
    auto& to = *static_cast<Warned*>(user);
    ++to.count;
    to.refused += fails(gno_simulator_remove_sensor(to.simulator, 0), "must not call it");
  };
  gno_request request = gno_request_init();
  request.sensor = sensor;
  REQUIRE(gno_simulator_create(scene, &request, 1, &options, &warned.simulator) == GNO_OK);
  gno_stamp stamps[2] = {};
  for (gno_stamp& stamp : stamps) stamp.pose.orientation[3] = 1;
  stamps[1].time = 0.1;
  stamps[1].pose.position[0] = 1;
  gno_shot shot = gno_shot_init();
  shot.motion = stamps;
  shot.motion_count = 2;
  gno_scan scan = nullptr;
  CHECK(gno_simulator_scan(warned.simulator, &shot, &scan) == GNO_OK);
  CHECK(warned.count == 1);
  CHECK(warned.refused == 1);
  CHECK(gno_simulator_scan(warned.simulator, &shot, &scan) == GNO_OK);  // the simulator still has its sensor
  CHECK(gno_scan_destroy(scan) == GNO_OK);
  CHECK(gno_simulator_destroy(warned.simulator) == GNO_OK);
  CHECK(gno_sensor_destroy(sensor) == GNO_OK);
  CHECK(gno_scene_destroy(scene) == GNO_OK);
}

TEST_CASE("C: the sentence of an error belongs to its thread, and threads may share a simulator") {
  CHECK(gno_scene_destroy(nullptr) == GNO_INVALID_ARGUMENT);
  const std::string mine = gno_last_error();
  gno_scene scene = makeScene();
  gno_simulator simulator = makeSimulator(scene, "clean", {});
  const auto work = [&](bool& good) {
    good = std::string(gno_last_error()).empty();
    gno_scan scan = nullptr;
    gno_shot shot = gno_shot_init();
    shot.pose.position[2] = 1.8;
    for (int i = 0; i < 3; ++i) good &= gno_simulator_scan(simulator, &shot, &scan) == GNO_OK;
    gno_counters counters = gno_counters_init();
    good &= gno_scan_get_counters(scan, &counters) == GNO_OK && counters.hits > 0;
    good &= gno_scan_destroy(scan) == GNO_OK;
  };
  bool goodFirst = false, goodSecond = false;
  std::thread first([&] { work(goodFirst); }), second([&] { work(goodSecond); });
  first.join();
  second.join();
  CHECK((goodFirst && goodSecond));
  CHECK(gno_last_error() == mine);
  CHECK(gno_simulator_destroy(simulator) == GNO_OK);
  CHECK(gno_scene_destroy(scene) == GNO_OK);
}
