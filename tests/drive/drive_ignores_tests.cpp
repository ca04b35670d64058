// SPDX-License-Identifier: Apache-2.0
// Sensors of drives that do not see some of the actors, above all the vehicle that carries them.
#include <catch2/matchers/catch_matchers_exception.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <regex>
#include <set>

#include "drive_support.hpp"
#include "npy_rows.hpp"
#include "problem.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;

namespace {

/// The small drive with a body of the vehicle, which encloses both sensors.
Json driveWithBody() {
  Json json = smallDrive();
  json["duration"] = 0.3;
  json["actors"].push_back({{"name", "ego-body"},
                            {"model", "cube"},
                            {"class", "car"},
                            {"size", {4, 2, 2}},
                            {"trajectory", {{"waypoints", {waypoint(0, -2, 0, 1.2), waypoint(1, 2, 0, 1.2)}}}}});
  return json;
}

/// The objects that the first scan of a sensor has met.
std::set<uint32_t> objectsOf(const DriveFolder& folder, const std::string& sensor, const std::string& out = "out") {
  std::set<uint32_t> objects;
  for (const Row& row : rowsOf(folder.get(out + "/npy/" + sensor + "/000000.npy"))) objects.insert(row.instance);
  return objects;
}

}  // namespace

TEST_CASE("a sensor does not see the actors that it ignores, and other sensors do") {
  const DriveFolder folder;
  Json json = driveWithBody();
  folder.run(json, "seen");
  CHECK(objectsOf(folder, "top", "seen") == std::set<uint32_t>{3});
  CHECK(objectsOf(folder, "side", "seen") == std::set<uint32_t>{3});
  json["sensors"][0]["ignores"] = {"ego-body"};
  folder.run(json);
  CHECK(objectsOf(folder, "top") == std::set<uint32_t>{0, 1});
  CHECK(objectsOf(folder, "side") == std::set<uint32_t>{3});
  json["sensors"][0]["ignores"] = {"ego-body", "car-1", "ego-body"};
  folder.run(json, "floor");
  CHECK(objectsOf(folder, "top", "floor") == std::set<uint32_t>{0});
}

TEST_CASE("a surface nearer than the least range is seen through, or hides what is behind it if the drive says so") {
  const DriveFolder folder;
  Json json = driveWithBody();
  json["sensors"][0]["sensor"]["range"]["min"] = 3;  // the corners of the body are 2.7 m away
  folder.run(json, "through");
  CHECK(objectsOf(folder, "top", "through") == std::set<uint32_t>{0, 1});
  json["sensors"][0]["near_hits"] = "hide";
  folder.run(json, "hidden");
  CHECK(objectsOf(folder, "top", "hidden").empty());
  json["sensors"][0]["sensor"]["near_hits"] = "hide";
  json["sensors"][0]["near_hits"] = "see_through";
  folder.run(json);
  CHECK(folder.get("out/npy/top/000000.npy") == folder.get("through/npy/top/000000.npy"));
}

TEST_CASE("a run warns of sensors that start within the box of an actor, unless they ignore it") {
  const DriveFolder folder;
  Json json = driveWithBody();
  json["sensors"][1]["effects"] = "auto";
  const auto warnings = [&] { return folder.read(json).warnings; };
  REQUIRE(warnings().size() == 2);
  CHECK(warnings()[0] ==
        "sensors[0]: 'top' starts within the box of the actor 'ego-body', and sees it from inside; \"ignores\": "
        "[\"ego-body\"] leaves the actor out of its scans");
  CHECK_THAT(warnings()[1], ContainsSubstring("sensors[1]: 'side'"));
  json["sensors"][0]["ignores"] = {"ego-body"};
  CHECK(warnings().size() == 1);
  json["actors"][2]["size"] = {4, 2, 1};  // up to 1.7 m, below the sensor on the roof and above the other one
  json["sensors"][0].erase("ignores");
  REQUIRE(warnings().size() == 1);
  CHECK_THAT(warnings()[0], ContainsSubstring("'side'"));
  json["actors"][2]["trajectory"]["waypoints"][0]["time"] = 0.5;
  json["actors"][2]["outside"] = "gone";
  CHECK(warnings().empty());
}

TEST_CASE("all instances of an ignored actor are ignored, and so is an actor that a scene has had") {
  const DriveFolder folder;
  Scene scene;
  scene.materials.emplace_back();
  Mesh mesh;
  mesh.positions = {0, -1, -1, 0, 1, -1, 0, 0, 1};
  mesh.indices = {0, 1, 2};
  mesh.parts = {{0, 1, 0}};
  scene.meshes = {mesh};
  for (const double x : {2.0, 3.0, -3.0})
    scene.instances.push_back({"plate", 0, {{1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, 0}}});
  writeGlb(scene, folder / "plates.glb");
  Json json = driveWithBody();
  json["models"]["plates"] = {{"file", "plates.glb"}};
  json["actors"][2]["model"] = "plates";
  json["actors"][2].erase("size");
  json["actors"][2]["trajectory"]["waypoints"] = {waypoint(0, -2, 0, 1.8), waypoint(1, 2, 0, 1.8)};
  folder.run(json, "seen");
  CHECK(objectsOf(folder, "top", "seen").contains(3));
  json["sensors"][0]["ignores"] = {"ego-body"};
  folder.run(json);
  CHECK_FALSE(objectsOf(folder, "top").contains(3));
  scene.instances = {{"parked", 0, {{1, 0, 0, 3, 0, 1, 0, 0, 0, 0, 1, 1}}, 10}};
  writeGlb(scene, folder / "parked.glb");
  json["scenes"].push_back({{"file", "parked.glb"}, {"boxes", {"car"}}});
  folder.run(json, "parked");
  CHECK(objectsOf(folder, "top", "parked").contains(6));
  json["sensors"][0]["ignores"] = {"ego-body", "parked"};
  folder.run(json, "neither");
  CHECK_FALSE(objectsOf(folder, "top", "neither").contains(6));
}

TEST_CASE("with an ignored actor every format has the files of a drive where it is out of reach") {
  const DriveFolder folder;
  Json json = driveWithBody();
  json["outputs"] = everyOutput();
  for (Json& output : json["outputs"]) output["sensors"] = {"top"};
  json["epoch"] = 1.7e9;
  Json away = json;
  away["actors"][2]["trajectory"]["waypoints"] = {waypoint(0, 0, 900, 0)};
  folder.run(away, "away");
  json["sensors"][0]["ignores"] = {"ego-body"};
  folder.run(json);
  const auto wanted = filesOf(folder / "away");
  const std::regex token("[0-9a-f]{32}");
  size_t compared = 0;
  for (const auto& [name, bytes] : filesOf(folder / "out")) {
    if (name.starts_with("manifest")) continue;    // it has the hash of the drive file
    if (name.find("_gt_") != name.npos) continue;  // it has where all actors are, whoever sees them
    INFO(name);
    REQUIRE(wanted.contains(name));
    if (name.ends_with(".json"))  // nuScenes has hashes of the drive file in its tokens
      CHECK(std::regex_replace(bytes, token, "") == std::regex_replace(wanted.at(name), token, ""));
    else
      CHECK(bytes == wanted.at(name));
    ++compared;
  }
  CHECK(compared > 40);
}

TEST_CASE("an unknown name in ignores is refused, and other ones make another drive") {
  const DriveFolder folder;
  Json json = driveWithBody();
  json["sensors"][1]["ignores"] = {"car-1", "ego"};
  const std::string problem = problemOf([&] { folder.read(json); }, ErrorCode::format);
  CHECK(problem.find('\n') == std::string::npos);
  CHECK_THAT(problem,
             ContainsSubstring("sensors[1].ignores[1]: 'ego' is unknown; there are car-1, ego-body, person-1"));
  json["sensors"][1]["ignores"] = "car-1";
  CHECK_THAT(problemOf([&] { folder.read(json); }, ErrorCode::format),
             ContainsSubstring("sensors[1].ignores: must be a list"));
  json["sensors"][1]["ignores"] = {"car-1"};
  folder.run(json);
  json["sensors"][1]["ignores"] = Json::array();
  CHECK_THROWS_WITH(folder.run(json), ContainsSubstring("holds frames of another drive"));
}
