// SPDX-License-Identifier: Apache-2.0
// The C interface tells the same as C++ of the library, its lists, fields and devices, and of scenes with images.
#include <gnosphere.h>

#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <cstring>
#include <gnosphere/gnosphere.hpp>
#include <string>
#include <vector>

#include "c/fails.hpp"
#include "c/floor_and_wall.hpp"
#include "folder.hpp"

namespace gnosphere::test {

TEST_CASE("C: the library has the version of its headers") {
  CHECK(gno_version() == GNO_VERSION);
}

TEST_CASE("C: the names of sensors, effects and presets are those of C++, in its order") {
  std::vector<std::string> sensors;
  for (const Sensor& sensor : builtinSensors()) sensors.push_back(sensor.name);
  const struct {
    gno_status (*list)(const char* const**, size_t*);
    const std::vector<std::string>& expected;
  } lists[] = {{gno_sensor_names, sensors}, {gno_effect_names, effectNames()}, {gno_effect_presets, effectPresets()}};
  for (const auto& [list, expected] : lists) {
    const char* const* names = nullptr;
    size_t count = 0;
    REQUIRE(list(&names, &count) == GNO_OK);
    CHECK(count > 4);
    CHECK(std::vector<std::string>(names, names + count) == expected);
    CHECK(fails(list(nullptr, &count), "names is null"));
    CHECK(fails(list(&names, nullptr), "count is null"));
  }
}

TEST_CASE("C: the heads of the catalogue are those of C++, and each mode of a head makes a sensor") {
  size_t count = 0;
  REQUIRE(gno_catalogue_count(&count) == GNO_OK);
  REQUIRE(count == sensorCatalogue().size());
  gno_catalogue_head head = gno_catalogue_head_init();
  for (size_t i = 0; i < count; ++i) {
    const CatalogueHead& expected = sensorCatalogue()[i];
    REQUIRE(gno_catalogue_get(i, &head) == GNO_OK);
    CHECK((head.name == expected.name && head.product == expected.product));
    CHECK((head.source == expected.source && head.remarks == expected.remarks));
    CHECK(head.range_at_10_percent == expected.rangeAt10Percent);
    const std::string modes = head.modes;
    CHECK(static_cast<size_t>(std::ranges::count(modes, ',')) + 1 == expected.modes.size());
    CHECK(modes.starts_with(expected.modes.front()));
    CHECK(modes.ends_with(expected.modes.back()));
  }
  gno_sensor sensor = nullptr;
  const std::string last = std::string(head.name) + ":" + sensorCatalogue().back().modes.back();
  REQUIRE(gno_sensor_builtin(last.c_str(), &sensor) == GNO_OK);
  CHECK(gno_sensor_destroy(sensor) == GNO_OK);
  CHECK(fails(gno_catalogue_get(count, &head), ("head " + std::to_string(count) + " does not exist").c_str()));
  CHECK(fails(gno_catalogue_get(0, nullptr), "gno_catalogue_head is null"));
}

TEST_CASE("C: fields are described and parsed as in C++") {
  gno_field_description described = gno_field_description_init();
  for (size_t i = 0; i < kFieldCount; ++i) {
    const FieldInfo expected = fieldInfo(static_cast<Field>(i));
    REQUIRE(gno_field_describe(static_cast<gno_field>(i), &described) == GNO_OK);
    CHECK(std::strcmp(described.name, expected.name) == 0);
    CHECK(described.components == expected.components);
  }
  for (const auto& [field, type] : {std::pair{GNO_FIELD_NORMAL, GNO_F32}, std::pair{GNO_FIELD_CAUSE, GNO_U8},
                                    std::pair{GNO_FIELD_CLASS_ID, GNO_U16}, std::pair{GNO_FIELD_TRIANGLE, GNO_U32}}) {
    REQUIRE(gno_field_describe(field, &described) == GNO_OK);
    CHECK(described.type == type);
  }
  CHECK(
      fails(gno_field_describe(static_cast<gno_field>(kFieldCount), &described), std::to_string(kFieldCount).c_str()));
  gno_field fields[3] = {77, 77, 77};
  size_t count = 0;
  REQUIRE(gno_fields_parse("x, normal,TIME", fields, 2, &count) == GNO_OK);
  CHECK(count == 3);
  CHECK((fields[0] == GNO_FIELD_X && fields[1] == GNO_FIELD_NORMAL && fields[2] == 77));
  REQUIRE(gno_fields_parse("x,y", nullptr, 0, &count) == GNO_OK);  // to learn how many there are
  CHECK(count == 2);
  CHECK(fails(gno_fields_parse("x,colour", fields, 3, &count), "'colour'"));
  CHECK(fails(gno_fields_parse(nullptr, fields, 3, &count), "names is null"));
  CHECK(fails(gno_fields_parse("x", nullptr, 3, &count), "fields is null"));
}

TEST_CASE("C: the devices of the machine are those of C++") {
  std::string why;
  const std::vector<DeviceInfo> expected = listDevices(&why);
  const gno_device_info* devices = nullptr;
  size_t count = 0;
  const char* problem = nullptr;
  REQUIRE(gno_devices(&devices, &count, &problem) == GNO_OK);
  REQUIRE(count == expected.size());
  CHECK(problem == why);
  for (size_t i = 0; i < count; ++i) {
    INFO(expected[i].name);
    CHECK((devices[i].name == expected[i].name && devices[i].type == expected[i].type));
    CHECK((devices[i].driver == expected[i].driver && devices[i].api_version == expected[i].apiVersion));
    CHECK(devices[i].max_buffer_bytes == expected[i].maxBufferBytes);
    CHECK(devices[i].subgroup_size == expected[i].subgroupSize);
    CHECK((devices[i].usable != 0) == expected[i].usable);
    CHECK(devices[i].reason == expected[i].reason);
    CHECK(std::equal(expected[i].uuid.begin(), expected[i].uuid.end(), devices[i].uuid));
  }
  REQUIRE(gno_devices(&devices, &count, nullptr) == GNO_OK);
  CHECK(fails(gno_devices(nullptr, &count, nullptr), "devices is null"));
}

TEST_CASE("C: a material with holes comes out of a scene and its file as it went in") {
  const gno_scene scene = makeScene();
  const uint8_t alpha[] = {0, 255, 128, 64, 7, 9};
  gno_alpha_image image = gno_alpha_image_init();
  image.width = 3;
  image.height = 2;
  image.alpha = alpha;
  image.wrap_u = GNO_WRAP_CLAMP;
  image.wrap_v = GNO_WRAP_MIRROR;
  uint32_t index = 9;
  REQUIRE(gno_scene_add_alpha_image(scene, &image, &index) == GNO_OK);
  CHECK(index == 0);
  gno_material leaf = gno_material_init();
  leaf.name = "leaf";
  leaf.alpha_mode = GNO_ALPHA_MASK;
  leaf.alpha_cutoff = 0.25f;
  leaf.alpha_image = index;
  REQUIRE(gno_scene_add_material(scene, &leaf, nullptr) == GNO_OK);
  const float uvs[] = {0, 0, 1, 0, 1, 1, 0, 1};
  const gno_mesh_part part = {0, 2, 1};
  gno_mesh mesh = squareMesh();
  mesh.uvs = uvs;
  mesh.parts = &part;
  mesh.part_count = 1;
  REQUIRE(gno_scene_add_mesh(scene, &mesh, nullptr) == GNO_OK);
  gno_instance instance = gno_instance_init();
  instance.mesh = 1;
  REQUIRE(gno_scene_add_instance(scene, &instance, nullptr) == GNO_OK);
  REQUIRE(gno_scene_validate(scene) == GNO_OK);

  const Folder folder;
  const std::string file = (folder / "leaf.glb").string();
  REQUIRE(gno_scene_write_glb(scene, file.c_str()) == GNO_OK);
  const Scene read = loadScene(file);
  REQUIRE(read.materials.size() == 2);
  REQUIRE(read.meshes.size() == 2);
  CHECK(read.meshes[1].uvs == std::vector<float>(uvs, uvs + 8));
  CHECK(read.instances.size() == 3);
  REQUIRE(read.alphaImages.size() == 1);
  CHECK(read.alphaImages[0].alpha == std::vector<uint8_t>(alpha, alpha + 6));
  gno_scene loaded = nullptr;
  REQUIRE(gno_scene_load(file.c_str(), nullptr, &loaded) == GNO_OK);
  for (const gno_scene each : {scene, loaded}) {
    gno_scene_counts counts = gno_scene_counts_init();
    REQUIRE(gno_scene_get_counts(each, &counts) == GNO_OK);
    CHECK((counts.alpha_images == 1 && counts.unread_images == 0));
    gno_alpha_image got = gno_alpha_image_init();
    REQUIRE(gno_scene_get_alpha_image(each, 0, &got) == GNO_OK);
    REQUIRE((got.width == 3 && got.height == 2));
    CHECK(std::equal(alpha, alpha + 6, got.alpha));
    CHECK((got.wrap_u == GNO_WRAP_CLAMP && got.wrap_v == GNO_WRAP_MIRROR));
    gno_material material = gno_material_init();
    REQUIRE(gno_scene_get_material(each, 1, &material) == GNO_OK);
    CHECK((material.alpha_mode == GNO_ALPHA_MASK && material.alpha_cutoff == 0.25f && material.alpha_image == 0));
    CHECK(fails(gno_scene_get_alpha_image(each, 1, &got), "alpha image 1 does not exist"));
    CHECK(gno_scene_destroy(each) == GNO_OK);
  }
}

TEST_CASE("C: images, files of scenes and sensor files that cannot be are errors") {
  const gno_scene scene = makeScene();
  gno_alpha_image image = gno_alpha_image_init();
  image.width = 3;
  image.height = 2;
  CHECK(fails(gno_scene_add_alpha_image(scene, &image, nullptr), "gno_alpha_image::alpha is null"));
  const uint8_t alpha[6] = {};
  image.alpha = alpha;
  image.wrap_v = 3;
  CHECK(fails(gno_scene_add_alpha_image(scene, &image, nullptr), "gno_alpha_image::wrap_v is 3"));
  const Folder folder;
  CHECK(fails(gno_scene_write_glb(scene, (folder / "a.obj").string().c_str()), "scenes are written as .glb"));
  CHECK(fails(gno_scene_write_glb(scene, (folder / "no/a.glb").string().c_str()), "a.glb", GNO_FILE));
  CHECK(fails(gno_scene_write_glb(scene, nullptr), "file is null"));
  CHECK(folder.fileCount() == 0);
  CHECK(gno_scene_destroy(scene) == GNO_OK);

  const std::string head = put(folder / "head.json", toJson(builtinSensor("VLP-16"))).string();
  gno_sensor sensor = nullptr;
  REQUIRE(gno_sensor_load(head.c_str(), nullptr, &sensor) == GNO_OK);
  gno_sensor_size size = gno_sensor_size_init();
  REQUIRE(gno_sensor_get_size(sensor, &size) == GNO_OK);
  CHECK((size.width == 1800 && size.height == 16));
  CHECK(gno_sensor_destroy(sensor) == GNO_OK);
  gno_sensor_file_options options = gno_sensor_file_options_init();
  options.columns = 900;
  CHECK(fails(gno_sensor_load(head.c_str(), &options, &sensor), "--columns does not apply"));
  CHECK(fails(gno_sensor_load((folder / "none.json").string().c_str(), nullptr, &sensor), "none.json", GNO_FILE));
  CHECK(fails(gno_sensor_load(nullptr, nullptr, &sensor), "file is null"));
}

}  // namespace gnosphere::test
