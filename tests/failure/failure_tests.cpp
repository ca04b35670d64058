// SPDX-License-Identifier: Apache-2.0
// Memory runs out, or a disk fails, at every place of every call: the call reports it, and the object is as before.
#include <gnosphere.h>

#include <filesystem>

#include "deformable.hpp"
#include "failure/injection.hpp"
#include "failure/kinds.hpp"
#include "folder.hpp"

namespace gnosphere::test {
namespace {

namespace fs = std::filesystem;

/// A floor, a limb that bends, and a material with holes.
Scene smallScene() {
  Random random(7);
  Scene scene = sceneOf(soup(5, 60, 30, 6));
  scene.meshes.push_back(limb(random, 3, 2, 1));
  scene.meshes.push_back(ball(6, 8, 2));
  scene.instances.push_back({"", 1, translation(5, 0, 0)});
  scene.instances.push_back({"", 2, translation(0, 6, 0)});
  return scene;
}

/// A simulator of every kind of device, and a scan that must stay what it is.
class Subject {
 public:
  explicit Subject(DeviceChoice::Kind kind)
      : simulator(smallScene(),
                  SensorRequest{gridSensor(60, 8, -20, 20), Effects::none(), {Field::classId, Field::normal}},
                  optionsFor(kind)) {
    shot.pose.position = {0.1, 0.2, 0.3};
    simulator.scanInto(shot, expected);
  }
  static SimulatorOptions optionsFor(DeviceChoice::Kind kind) {
    SimulatorOptions options;
    options.cache = "off";
    options.device.kind = kind;
    return options;
  }
  void check() {
    Scan scan;
    simulator.scanInto(shot, scan);
    CHECK(sameBytes(scan, expected));
  }

  Simulator simulator;
  Shot shot;
  Scan expected;
};

}  // namespace

TEST_CASE("without memory a simulator is not made, and nothing ends the process") {
  const Scene scene = smallScene();
  const SensorRequest request = {gridSensor(60, 8, -20, 20), Effects::none(), {Field::classId}};
  const SimulatorOptions options = Subject::optionsFor(DeviceChoice::Kind::reference);
  failEach("reference: Simulator", Fails::memory, {[&] { Simulator(scene, request, options); }, {}, {}});
}

TEST_CASE("without memory a change of the scene leaves the simulator as it was", "[combinations]") {
  const DeviceChoice::Kind kind = everyKind();
  Subject subject(kind);
  Simulator& simulator = subject.simulator;
  const auto check = [&] { subject.check(); };
  const auto each = [&](const char* name, const std::function<void()>& call, const std::function<void()>& undo) {
    failEach(nameOf(kind, name), Fails::memory, {call, undo, check});
  };
  size_t added = 0;
  Random random(3);
  const Scene scene = smallScene();
  Mesh named = scene.meshes[2];
  named.name = "a name that is too long to be kept within the string itself";
  each(
      "addMesh", [&] { added = simulator.addMesh(named); }, [&] { simulator.removeMesh(added); });
  each(
      "addMesh, deformable", [&] { added = simulator.addMesh(scene.meshes[1]); }, [&] { simulator.removeMesh(added); });
  each(
      "addInstance", [&] { added = simulator.addInstance(2, translation(500, 0, 0), 3); },
      [&] { simulator.removeInstance(added); });
  each(
      "setTransform", [&] { simulator.setTransform(1, translation(5, 1, 0)); },
      [&] { simulator.setTransform(1, translation(5, 0, 0)); });
  std::vector<float> moved = scene.meshes[2].positions;
  for (float& value : moved) value *= 1.5f;
  each(
      "setPositions", [&] { simulator.setPositions(2, moved); },
      [&] { simulator.setPositions(2, scene.meshes[2].positions); });
  const Deformation bent = bend(random, scene.meshes[1]);
  each(
      "setDeformation", [&] { simulator.setDeformation(1, bent); },
      [&] { simulator.setDeformation(1, scene.meshes[1].deformation); });
  Material glass;
  glass.name = "a material whose name does not fit into the string itself";
  const AlphaImage image = {2, 2, {0, 255, 0, 255}};
  each(
      "addMaterial", [&] { added = simulator.addMaterial(glass, &image); }, [&] { simulator.removeMaterial(added); });
  Scene part = sceneOf(named);
  for (MeshPart& run : part.meshes[0].parts) run.material = 0;
  part.materials = {glass, glass};
  part.materials[1].alphaMode = AlphaMode::mask;
  part.materials[1].alphaImage = 0;
  part.alphaImages = {image};
  part.instances[0].transform = translation(500, 0, 0);
  AddedScene parts;
  each(
      "addScene", [&] { parts = simulator.addScene(part, translation(0, 1, 0)); },
      [&] {
        for (const uint32_t instance : parts.instances) simulator.removeInstance(instance);
        for (const uint32_t mesh : parts.meshes) simulator.removeMesh(mesh);
        for (const uint32_t material : parts.materials) simulator.removeMaterial(material);
      });
  each(
      "addSensor",
      [&] {
        added = simulator.addSensor({gridSensor(40, 4, -10, 10), Effects::none(), {}});
      },
      [&] { simulator.removeSensor(added); });
  // Each trial of a removal begins with an object to remove.
  added = simulator.addMesh(named);
  each(
      "removeMesh", [&] { simulator.removeMesh(added); }, [&] { added = simulator.addMesh(named); });
  added = simulator.addInstance(2, translation(500, 0, 0));
  each(
      "removeInstance", [&] { simulator.removeInstance(added); },
      [&] { added = simulator.addInstance(2, translation(500, 0, 0)); });
  added = simulator.addMaterial(glass, &image);
  each(
      "setMaterial", [&] { simulator.setMaterial(added, glass, &image); }, [] {});
  each(
      "removeMaterial", [&] { simulator.removeMaterial(added); },
      [&] { added = simulator.addMaterial(glass, &image); });
  added = simulator.addSensor({gridSensor(40, 4, -10, 10), Effects::none(), {}});
  each(
      "removeSensor", [&] { simulator.removeSensor(added); },
      [&] {
        added = simulator.addSensor({gridSensor(40, 4, -10, 10), Effects::none(), {}});
      });
}

TEST_CASE("without memory or room on the disk no cloud is written by half, and reading says so") {
  const Subject subject(DeviceChoice::Kind::reference);
  const Folder folder;
  size_t files = 0;
  for (const char* ending : {"pcd", "ply", "npy", "csv", "bin"}) {
    ++files;
    const fs::path file = folder / (std::string("cloud.") + ending);
    writeCloud(subject.expected, file);
    const std::string whole = bytesOf(file);
    for (const Fails what : {Fails::memory, Fails::files}) {
      const std::string name = std::string(what == Fails::memory ? "memory" : "files") + ": writeCloud, " + ending;
      failEach(name, what,
               {[&] { writeCloud(subject.expected, file); },
                {},
                [&] {
                  CHECK(bytesOf(file) == whole);
                  CHECK(folder.fileCount() == files);
                }});
    }
    if (std::string(ending) == "bin") continue;
    failEach(std::string("memory: readCloud, ") + ending, Fails::memory, {[&] { (void)readCloud(file); }, {}, {}});
    failEach(std::string("files: readCloud, ") + ending, Fails::files, {[&] { (void)readCloud(file); }, {}, {}});
  }
}

TEST_CASE("C: without memory every function returns a status, and its handles stay what they are") {
  gno_scene scene = nullptr;
  REQUIRE(gno_scene_create(&scene) == GNO_OK);
  const float corners[] = {-20, -20, 0, 20, -20, 0, 20, 20, 0, -20, 20, 0};
  const uint32_t triangles[] = {0, 1, 2, 0, 2, 3};
  gno_mesh mesh = gno_mesh_init();
  mesh.positions = corners;
  mesh.vertex_count = 4;
  mesh.indices = triangles;
  mesh.triangle_count = 2;
  const gno_material material = gno_material_init();
  const gno_instance instance = gno_instance_init();
  REQUIRE(gno_scene_add_material(scene, &material, nullptr) == GNO_OK);
  REQUIRE(gno_scene_add_mesh(scene, &mesh, nullptr) == GNO_OK);
  REQUIRE(gno_scene_add_instance(scene, &instance, nullptr) == GNO_OK);
  gno_sensor sensor = nullptr;
  REQUIRE(gno_sensor_builtin("VLP-16", &sensor) == GNO_OK);
  gno_request request = gno_request_init();
  request.sensor = sensor;
  gno_options options = gno_options_init();
  options.device = "reference";
  gno_simulator simulator = nullptr;
  REQUIRE(gno_simulator_create(scene, &request, 1, &options, &simulator) == GNO_OK);
  gno_shot shot = gno_shot_init();
  shot.pose.position[2] = 1.8;
  uint64_t hits = 0;
  const auto receive = [](size_t, gno_scan scan, void* user) -> int32_t {
    gno_counters counters = gno_counters_init();
    gno_scan_get_counters(scan, &counters);
    *static_cast<uint64_t*>(user) = counters.hits;
    return 0;
  };
  const auto scanAll = [&] { return gno_simulator_scan_all(simulator, &shot, 1, receive, &hits); };
  REQUIRE(scanAll() == GNO_OK);
  const uint64_t expected = hits;
  const auto check = [&] {
    hits = 0;
    CHECK(scanAll() == GNO_OK);
    CHECK(hits == expected);
  };
  const auto each = [&](const char* name, const std::function<gno_status()>& call, const std::function<void()>& undo) {
    failEach(std::string("C: ") + name, Fails::memory,
             {[&] {
                const gno_status status = call();
                if (status == GNO_OUT_OF_MEMORY) throw std::bad_alloc();
                if (status != GNO_OK) throw std::runtime_error("status " + std::to_string(status));
              },
              undo, check});
  };
  each("scan_all", scanAll, {});
  gno_simulator made = nullptr;
  each(
      "simulator_create", [&] { return gno_simulator_create(scene, &request, 1, &options, &made); },
      [&] { gno_simulator_destroy(made); });
  gno_scan scan = nullptr;
  each(
      "scan", [&] { return gno_simulator_scan(simulator, &shot, &scan); },
      [&] {
        gno_scan_destroy(scan);
        scan = nullptr;
      });
  size_t index = 0;
  each(
      "add_mesh", [&] { return gno_simulator_add_mesh(simulator, &mesh, &index); },
      [&] { gno_simulator_remove_mesh(simulator, index); });
  gno_sensor other = nullptr;
  each(
      "sensor_builtin", [&] { return gno_sensor_builtin("HDL-64E", &other); }, [&] { gno_sensor_destroy(other); });
  CHECK(gno_simulator_destroy(simulator) == GNO_OK);
  CHECK(gno_sensor_destroy(sensor) == GNO_OK);
  CHECK(gno_scene_destroy(scene) == GNO_OK);
}

}  // namespace gnosphere::test
