// SPDX-License-Identifier: Apache-2.0
// Instances of scenes that become actors.
#include <catch2/matchers/catch_matchers_exception.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>

#include "cpu_time.hpp"
#include "drive/standing.hpp"
#include "drive_support.hpp"
#include "support.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;

namespace {

/// Writes parked.glb: so many triangles named "car", each an instance of class 10.
void putParked(const DriveFolder& folder, size_t count) {
  Scene scene;
  scene.meshes.resize(1);
  scene.meshes[0].positions = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  scene.meshes[0].indices = {0, 1, 2};
  scene.materials.resize(1);
  scene.meshes[0].parts = {{0, 1, 0}};
  for (size_t i = 0; i < count; ++i)
    scene.instances.push_back({"car", 0, {{1, 0, 0, double(i), 0, 1, 0, 0, 0, 0, 1, 1}}, 10});
  writeGlb(scene, folder / "parked.glb");
}

}  // namespace

TEST_CASE("actors that a scene has had share a model if they differ by their places and yaws alone") {
  const DriveFolder folder;
  MeshBuilder box;
  box.box({-1, -2, 0}, {1, 2, 1.5});
  Scene cars = sceneOf(box.take());
  cars.instances.clear();
  for (const double yaw : {0.3, 1.1, 2.7}) {
    const double c = std::cos(yaw), s = std::sin(yaw);
    cars.instances.push_back({"car", 0, {{c, -s, 0, 7 * yaw, s, c, 0, 5, 0, 0, 1, 0.3}}});
  }
  writeGlb(cars, folder / "cars.glb");
  Json json = smallDrive();
  json["actors"] = Json::array();
  json["scenes"].push_back({{"file", "cars.glb"}, {"instances", {{"car", "car"}}}, {"boxes", {"car"}}});
  const drive::Drive drive = folder.read(json);
  REQUIRE(drive.actors.size() == 3);
  CHECK(drive.models.size() == 2);  // with that of the drive file
}

TEST_CASE("the model of an actor that a scene has had has the materials of its mesh and their images, each once") {
  Scene scene;
  for (const uint8_t alpha : std::vector<uint8_t>{10, 20, 30}) scene.alphaImages.push_back({1, 1, {alpha}});
  for (const uint32_t image : {2u, kNoImage, 0u, 2u}) {
    scene.materials.emplace_back().alphaImage = image;
    scene.materials.back().name = "material " + std::to_string(scene.materials.size() - 1);
  }
  scene.meshes.resize(2);
  scene.meshes[1].positions = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  for (const uint32_t material : {3u, 1u, 0u, 3u, 2u}) {
    Mesh& mesh = scene.meshes[1];
    mesh.parts.push_back({static_cast<uint32_t>(mesh.parts.size()), 1, material});
    for (const uint32_t corner : {0u, 1u, 2u}) mesh.indices.push_back(corner);
  }
  scene.instances = {{"car", 1, {}, 10}};
  drive::StandingActors standing;
  drive::takeStanding(
      scene, [](const Instance&) { return std::optional<size_t>(0); }, standing);
  REQUIRE(standing.models.size() == 1);
  const Scene& model = standing.models[0];
  REQUIRE(model.materials.size() == 4);
  const std::pair<const char*, uint32_t> expected[] = {
      {"material 3", 0}, {"material 1", kNoImage}, {"material 0", 0}, {"material 2", 1}};
  for (size_t i = 0; i < 4; ++i) {
    CHECK(model.materials[i].name == expected[i].first);
    CHECK(model.materials[i].alphaImage == expected[i].second);
  }
  REQUIRE(model.alphaImages.size() == 2);
  CHECK(model.alphaImages[0].alpha == std::vector<uint8_t>{30});
  CHECK(model.alphaImages[1].alpha == std::vector<uint8_t>{10});
  const uint32_t parts[] = {0, 1, 2, 0, 3};
  for (size_t i = 0; i < 5; ++i) CHECK(model.meshes[0].parts[i].material == parts[i]);
  CHECK(scene.instances.empty());
}

TEST_CASE("thousands of instances of one name become actors with names of their own in little time") {
  const DriveFolder folder;
  constexpr size_t kMany = 12000;
  putParked(folder, kMany);
  Json json = smallDrive();
  json["scenes"].push_back({{"file", "parked.glb"}, {"boxes", {"car"}}});
  drive::Drive drive;
  CHECK(cpuSeconds([&] { drive = folder.read(json); }) < 1);
  REQUIRE(drive.actors.size() == kMany + 2);
  CHECK(drive.actors[2].name == "car");
  CHECK(drive.actors[3].name == "car (2)");
  CHECK(drive.actors.back().name == "car (" + std::to_string(kMany) + ")");
}

TEST_CASE("more actors than labels of SemanticKITTI have numbers for are refused before a run") {
  const DriveFolder folder;
  Json json = smallDrive();
  json["actors"] = Json::array();
  json["scenes"].push_back({{"file", "parked.glb"}, {"boxes", {"car"}}});
  putParked(folder, 65536);
  json["outputs"].push_back({{"format", "semantickitti"}});
  CHECK_THROWS_WITH(folder.read(json), ContainsSubstring("outputs[1].format: SemanticKITTI labels have 16 bits for the "
                                                         "number of an actor; there are 65536 actors"));
}

TEST_CASE("a scene of which no instance has boxes keeps its instances and their names") {
  const DriveFolder folder;
  put(folder / "floor.obj", std::string("o a floor that has more letters than a short string\n") + kFloor);
  Json json = smallDrive();
  json["scenes"][0]["boxes"] = {"person"};
  const std::vector<Instance> instances = folder.read(json).scenes[0].instances;
  REQUIRE(instances.size() == 1);
  CHECK(instances[0].name == "a floor that has more letters than a short string");
}
