// SPDX-License-Identifier: Apache-2.0
// Memory runs out at every place of a call that changes a simulator: the call reports it, and the object is as before.
#include <catch2/generators/catch_generators.hpp>

#include "deformable.hpp"
#include "failure/injection.hpp"

namespace gnosphere::test {
namespace {

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

DeviceChoice::Kind everyKind() {
  const auto kind = GENERATE(DeviceChoice::Kind::reference, DeviceChoice::Kind::vulkan);
  if (kind == DeviceChoice::Kind::vulkan) needVulkan();
  return kind;
}

const char* nameOf(DeviceChoice::Kind kind) {
  return kind == DeviceChoice::Kind::reference ? "reference: " : "vulkan: ";
}

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
    failEach(std::string(nameOf(kind)) + name, Fails::memory, {call, undo, check});
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
      "removeMaterial", [&] { simulator.removeMaterial(added); },
      [&] { added = simulator.addMaterial(glass, &image); });
  added = simulator.addSensor({gridSensor(40, 4, -10, 10), Effects::none(), {}});
  each(
      "removeSensor", [&] { simulator.removeSensor(added); },
      [&] {
        added = simulator.addSensor({gridSensor(40, 4, -10, 10), Effects::none(), {}});
      });
}

}  // namespace gnosphere::test
