// SPDX-License-Identifier: Apache-2.0
// The C interface without memory: every function returns a status, and what its handles stand for stays what it is.
// Functions that read or write JSON are left out. The destructor of nlohmann::json needs memory, and without any the
// process ends.
#include <gnosphere.h>
#include <gnosphere_ros2.h>

#include <array>
#include <cstring>
#include <new>
#include <stdexcept>

#include "failure/injection.hpp"
#include "folder.hpp"
#include "support.hpp"

namespace gnosphere::test {
namespace {

void need(gno_status status) {
  if (status == GNO_OUT_OF_MEMORY) throw std::bad_alloc();
  if (status != GNO_OK) throw std::runtime_error("status " + std::to_string(status) + ": " + gno_last_error());
}

/// Handles of one of everything, and the scans and texts that they must give again.
class CSubject {
 public:
  CSubject() {
    need(gno_scene_create(&scene));
    const gno_material material = gno_material_init();
    need(gno_scene_add_material(scene, &material, nullptr));
    mesh.positions = kCorners;
    mesh.vertex_count = 4;
    mesh.indices = kTriangles;
    mesh.triangle_count = 2;
    need(gno_scene_add_mesh(scene, &mesh, nullptr));
    for (uint32_t world = 0; world < 4; ++world) {
      gno_instance instance = gno_instance_init();
      instance.transform.rows[11] = -2.0 - world;
      instance.world = world;
      need(gno_scene_add_instance(scene, &instance, nullptr));
    }
    need(gno_sensor_from_json(toJson(gridSensor(24, 4, -40, -10)).c_str(), &sensor));
    need(gno_effects_from_json(R"({"range-noise": {"sigma": 0.1}})", &effects));
    request.sensor = sensor;
    request.effects = effects;
    options.device = "reference";
    need(gno_simulator_create(scene, &request, 1, &options, &simulator));
    for (size_t i = 0; i < shots.size(); ++i) {
      shots[i] = gno_shot_init();
      shots[i].world = static_cast<uint32_t>(i);
      shots[i].pose.position[0] = 0.1 * static_cast<double>(i);
    }
    expected_ = results();
  }
  ~CSubject() {
    CHECK(gno_simulator_destroy(simulator) == GNO_OK);
    CHECK(gno_effects_destroy(effects) == GNO_OK);
    CHECK(gno_sensor_destroy(sensor) == GNO_OK);
    CHECK(gno_scene_destroy(scene) == GNO_OK);
  }
  void check() { CHECK(results() == expected_); }

  gno_scene scene = nullptr;
  gno_sensor sensor = nullptr;
  gno_effects effects = nullptr;
  gno_simulator simulator = nullptr;
  gno_request request = gno_request_init();
  gno_options options = gno_options_init();
  gno_mesh mesh = gno_mesh_init();
  std::array<gno_shot, 5> shots;

 private:
  static constexpr float kCorners[] = {-20, -20, 0, 20, -20, 0, 20, 20, 0, -20, 20, 0};
  static constexpr uint32_t kTriangles[] = {0, 1, 2, 0, 2, 3};

  std::string results() {
    gno_batch batch = nullptr;
    need(gno_simulator_scan_batch(simulator, shots.data(), shots.size(), nullptr, 0, &batch));
    gno_column ranges = gno_column_init();
    need(gno_batch_get_column(batch, GNO_FIELD_RANGE, &ranges));
    std::string bytes(static_cast<const char*>(ranges.values), ranges.entries * sizeof(float));
    need(gno_batch_destroy(batch));
    const char* text = nullptr;
    need(gno_effects_to_json(effects, &text));
    bytes += text;
    need(gno_sensor_to_json(sensor, &text));
    bytes += text;
    gno_scene_counts counts = gno_scene_counts_init();
    need(gno_scene_get_counts(scene, &counts));
    return bytes + std::to_string(counts.materials) + " " + std::to_string(counts.instances);
  }

  std::string expected_;
};

void each(const char* name, CSubject& subject, const std::function<gno_status()>& call,
          const std::function<void()>& undo) {
  failEach(std::string("C: ") + name, Fails::memory, {[&] { need(call()); }, undo, [&] { subject.check(); }});
}

}  // namespace

TEST_CASE("C: without memory gno_ros2_unavailable() says so") {
  bool fails = true;
  for (long n = 1; fails; ++n) {
    const char* why = nullptr;
    {
      const Injection injection(Fails::memory, n);
      why = gno_ros2_unavailable();
      fails = injection.fired();
    }
    REQUIRE(why);
    if (fails) CHECK(std::string(why) == "there is not enough memory");
  }
}

TEST_CASE("C: without memory batches fail, and many instances come and move together or not at all", "[combinations]") {
  CSubject subject;
  const gno_simulator simulator = subject.simulator;
  gno_batch batch = nullptr;
  each(
      "scan_batch", subject,
      [&] {
        return gno_simulator_scan_batch(simulator, subject.shots.data(), subject.shots.size(), nullptr, 0, &batch);
      },
      [&] {
        CHECK(gno_batch_destroy(batch) == GNO_OK);
        batch = nullptr;
      });
  std::array<gno_instance, 6> instances;
  for (size_t i = 0; i < instances.size(); ++i) {
    instances[i] = gno_instance_init();
    instances[i].world = static_cast<uint32_t>(i);
    instances[i].name = "a name that is too long to be kept within the string itself";
  }
  std::array<uint32_t, 6> indices = {};
  each(
      "add_instances", subject,
      [&] { return gno_simulator_add_instances(simulator, instances.data(), instances.size(), indices.data()); },
      [&] { CHECK(gno_simulator_remove_instances(simulator, indices.data(), indices.size()) == GNO_OK); });
  const uint32_t moved[] = {1, 2, 3};
  std::array<double, 21> there = {}, back = {};
  for (size_t i = 0; i < 3; ++i) {
    back[7 * i + 2] = -3.0 - static_cast<double>(i);
    there[7 * i + 2] = -1;
    there[7 * i + 6] = back[7 * i + 6] = 1;
  }
  each(
      "set_transforms", subject, [&] { return gno_simulator_set_transforms(simulator, moved, 3, there.data(), 7); },
      [&] { CHECK(gno_simulator_set_transforms(simulator, moved, 3, back.data(), 7) == GNO_OK); });
}

TEST_CASE("C: without memory simulators, scenes and effects stay what they are", "[combinations]") {
  CSubject subject;
  const gno_simulator simulator = subject.simulator;
  size_t index = 0;
  each(
      "add_sensor", subject, [&] { return gno_simulator_add_sensor(simulator, &subject.request, &index); },
      [&] { CHECK(gno_simulator_remove_sensor(simulator, index) == GNO_OK); });
  const gno_material material = gno_material_init();
  const uint8_t alpha[] = {0, 255, 0, 255};
  gno_alpha_image image = gno_alpha_image_init();
  image.width = image.height = 2;
  image.alpha = alpha;
  each(
      "add_material", subject, [&] { return gno_simulator_add_material(simulator, &material, &image, &index); },
      [&] { CHECK(gno_simulator_remove_material(simulator, index) == GNO_OK); });
  each("scene_validate", subject, [&] { return gno_scene_validate(subject.scene); }, {});
  gno_scene scene = nullptr;
  each(
      "a scene with one mesh", subject,
      [&] {
        const gno_status made = gno_scene_create(&scene);
        if (made != GNO_OK) return made;
        const gno_status added = gno_scene_add_mesh(scene, &subject.mesh, nullptr);
        if (added != GNO_OK) gno_scene_destroy(scene);
        return added;
      },
      [&] { CHECK(gno_scene_destroy(scene) == GNO_OK); });
  gno_effects effects = nullptr;
  each(
      "effects_preset", subject, [&] { return gno_effects_preset("carla", &effects); },
      [&] { CHECK(gno_effects_destroy(effects) == GNO_OK); });
  each(
      "effects_assign", subject, [&] { return gno_effects_assign(subject.effects, "fog.visibility=200"); },
      [&] {
        CHECK(gno_effects_destroy(subject.effects) == GNO_OK);
        CHECK(gno_effects_from_json(R"({"range-noise": {"sigma": 0.1}})", &subject.effects) == GNO_OK);
      });
}

TEST_CASE("C: without memory or room on the disk files are whole or as before", "[combinations]") {
  CSubject subject;
  const Folder folder;
  gno_scan scan = nullptr, read = nullptr;
  need(gno_simulator_scan(subject.simulator, subject.shots.data(), &scan));
  const auto each = [&](const char* name, const char* file, const std::function<gno_status(const char*)>& call) {
    const std::string path = (folder / file).string();
    need(call(path.c_str()));
    const std::string whole = bytesOf(path);
    for (const Fails what : {Fails::memory, Fails::files})
      failEach(std::string("C: ") + name + (what == Fails::files ? ", files" : ""), what,
               {[&] {
                  const gno_status status = call(path.c_str());
                  if (status == GNO_FILE) throw Error(ErrorCode::file, "");
                  need(status);
                },
                {},
                [&] { CHECK(bytesOf(path) == whole); }});
  };
  each("scan_write", "cloud.pcd", [&](const char* path) { return gno_scan_write(scan, path, nullptr); });
  each("scan_write_picture", "cloud.png", [&](const char* path) { return gno_scan_write_picture(scan, path); });
  const std::string cloud = (folder / "cloud.pcd").string();
  failEach("C: scan_read", Fails::memory,
           {[&] { need(gno_scan_read(cloud.c_str(), &read)); }, [&] { CHECK(gno_scan_destroy(read) == GNO_OK); }, {}});
  CHECK(gno_scan_destroy(scan) == GNO_OK);
}

}  // namespace gnosphere::test
