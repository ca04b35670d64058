// SPDX-License-Identifier: Apache-2.0
// Actors and scenes of a drive that show animations.
#include <algorithm>
#include <catch2/matchers/catch_matchers_floating_point.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <map>
#include <sstream>
#include <string>

#include "animation/panels.hpp"
#include "drive_support.hpp"
#include "npy_rows.hpp"
#include "problem.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::EndsWith;
using Catch::Matchers::StartsWith;
using Catch::Matchers::WithinAbs;

namespace {

/// A drive whose sensor stands, with two actors that show the panels: 5 m before it, and 5 m behind it at double speed.
Json panelDrive() {
  Json json = smallDrive();
  json["weather"] = Json::array();
  json["ego"]["trajectory"]["waypoints"] = {waypoint(0, 0, 0, 0), waypoint(1, 0, 0, 0)};
  json["sensors"] = {json["sensors"][0]};
  json["sensors"][0]["effects"] = "auto";
  json["models"] = {{"panels", {{"file", "panels.gltf"}, {"up", "z"}}}};
  const auto actor = [](const char* name, double x, const Json& animation) {
    return Json{{"name", name},
                {"model", "panels"},
                {"class", "car"},
                {"trajectory", {{"waypoints", {waypoint(0, x, 0, 0)}}}},
                {"animation", animation}};
  };
  json["actors"] = {actor("front", 5, {{"clip", "push"}, {"loop", false}}),
                    actor("back", -5, {{"clip", "push"}, {"speed", 2}, {"offset", 0.25}, {"loop", false}})};
  json["outputs"].push_back({{"format", "boxes"}});
  return json;
}

}  // namespace

TEST_CASE("nuScenes: a vehicle that a clip moves at another time has stopped") {
  const DriveFolder folder;
  put(folder / "panels.gltf", panels());
  Json json = panelDrive();
  json["classes"] = {{"ground", {{"id", 40}}}, {"vehicle.truck", {{"id", 10}}}, {"vehicle.car", {{"id", 11}}}};
  json["actors"][0]["class"] = "vehicle.truck";  // moves for a second
  json["actors"][1]["class"] = "vehicle.car";    // moves for 0.375 s
  json["outputs"] = {{{"format", "nuscenes"}, {"keyframes", 9}}};
  REQUIRE(folder.run(json).finished);
  const auto table = [&](const char* name) {
    std::map<std::string, Json> rows;
    for (const Json& row : Json::parse(folder.get(std::string("out/nuscenes/v1.0-drive/") + name + ".json")))
      rows[row["token"]] = row;
    return rows;
  };
  const auto attributes = table("attribute"), instances = table("instance"), categories = table("category"),
             samples = table("sample");
  std::map<std::string, std::string> first, last;  // attributes by category
  for (const auto& [token, note] : table("sample_annotation")) {
    REQUIRE(note["attribute_tokens"].size() == 1);
    const Json& category = categories.at(instances.at(note["instance_token"])["category_token"])["name"];
    (samples.at(note["sample_token"])["prev"] == "" ? first : last)[category] =
        attributes.at(note["attribute_tokens"][0])["name"].get<std::string>();
  }
  CHECK(first["vehicle.truck"] == "vehicle.moving");
  CHECK(last["vehicle.truck"] == "vehicle.moving");
  CHECK(first["vehicle.car"] == "vehicle.moving");
  CHECK(last["vehicle.car"] == "vehicle.stopped");
}

TEST_CASE("actors show their animations, each at its own time, and boxes follow their shape") {
  const DriveFolder folder;
  put(folder / "panels.gltf", panels());
  REQUIRE(folder.run(panelDrive()).finished);
  size_t soft = 0, rigid = 0, fronts = 0;
  for (int scan = 0; scan < 10; ++scan) {
    INFO("scan " << scan);
    const double start = 0.1 * scan;
    for (const Row& row : rowsOf(folder.get("out/npy/top/00000" + std::to_string(scan) + ".npy"))) {
      if (row.category != 10) continue;
      const bool front = row.instance == 1;
      const auto pushed = [&](double time) { return std::min(1.0, front ? time : 0.25 + 2 * time); };
      ++(row.y > 0 ? soft : rigid);
      // Both panels go straight from where they are at the scan's start to where they are at its end.
      const double place = front ? 5 : -5;
      const double share = row.time / 0.1, from = pushed(start), to = pushed(start + 0.1);
      CHECK_THAT(row.x, WithinAbs(place + from + share * (to - from), 1e-4));
    }
    std::istringstream boxes(folder.get("out/boxes/top/00000" + std::to_string(scan) + ".jsonl"));
    std::string line;
    size_t found = 0;
    while (std::getline(boxes, line)) {
      const Json box = Json::parse(line);
      ++found;
      fronts += box["name"] == "front";
      if (box["name"] == "front") {
        CHECK_THAT(box["world_frame"]["position"][0].get<double>(),
                   WithinAbs(5 + start + box["time"].get<double>(), 1e-5));
        // Only its animation moves the actor.
        CHECK_THAT(box["velocity"][0].get<double>(), WithinAbs(1, 1e-5));
        CHECK(box["moving"] == true);
      }
    }
    CHECK(found == 2);
  }
  CHECK(soft > 100);
  CHECK(rigid > 100);
  CHECK(fronts == 10);
}

TEST_CASE("a run warns of an animation that turns parts or limbs within a scan") {
  const DriveFolder folder;
  Json json = panelDrive();
  json["models"]["panels"]["file"] = "rotor.gltf";
  json["actors"] = {json["actors"][0]};
  const auto warnings = [&] {
    std::vector<std::string> texts;
    drive::RunOptions options = optionsFor(folder / "out");
    options.simulator.warn = [&](const std::string& text) { texts.push_back(text); };
    fs::remove_all(options.out);
    drive::run(folder.read(json), options);
    std::erase_if(texts, [](const std::string& text) { return text.find("within scan ") == text.npos; });
    return texts;
  };
  const auto check = [&](const std::string& of, const std::string& name) {
    for (const double speed : {1.0, 0.97, -0.8}) {
      CAPTURE(name, speed);
      json[Json::json_pointer(of)] = {{"clip", "spin"}, {"speed", speed}};
      const std::vector<std::string> texts = warnings();
      REQUIRE(texts.size() == 1);
      CHECK_THAT(texts[0],
                 StartsWith("within scan 0 of 'top' " + name +
                            " moves its parts, and its points, which go straight from where they are at the start to "
                            "where they are at the end of a scan, are up to 0.") &&
                     ContainsSubstring(speed == 0.97 ? " 0.39 m off" : " 0.4 m off") &&
                     EndsWith("; shorter scans keep nearer to them"));
    }
    json[Json::json_pointer(of)]["speed"] = 0.01;
    CHECK(warnings().empty());  // a tenth of a turn in a scan leads the tips 1 cm off
  };
  for (const bool skinned : {false, true}) {
    CAPTURE(skinned);
    put(folder / "rotor.gltf", rotor(skinned));
    check("/actors/0/animation", "the actor 'front'");
  }
  json["actors"] = Json::array();
  json["scenes"].push_back({{"file", "rotor.gltf"}, {"up", "z"}, {"pose", {{"position", {5, 0, 0}}}}});
  for (const bool skinned : {false, true}) {
    CAPTURE(skinned);
    put(folder / "rotor.gltf", rotor(skinned));
    check("/scenes/1/animation", "scenes[1]");
  }
}

TEST_CASE("an animation whose time is so large that it stands still has no detour, and is looked at in little time") {
  const DriveFolder folder;
  put(folder / "panels.gltf", panels());
  Json json = panelDrive();
  json["actors"][0]["animation"] = {{"clip", "push"}, {"offset", 1e17}};  // s, of which the next double is 16 s later
  const drive::Drive drive = folder.read(json);
  CHECK(drive::World(drive).detourOfActor(0, 0, 0.1).off == 0);
}

TEST_CASE("a scene of a drive shows an animation, with the same frames in any order") {
  const DriveFolder folder;
  put(folder / "panels.gltf", panels());
  Json json = panelDrive();
  json["actors"] = Json::array();
  json["scenes"].push_back({{"file", "panels.gltf"},
                            {"up", "z"},
                            {"class", "person"},
                            {"pose", {{"position", {5, 0, 0}}}},
                            {"animation", {{"clip", "push"}}}});
  REQUIRE(folder.run(json).finished);
  const drive::Drive drive = folder.read(json);
  drive::RunOptions options;
  options.out = folder / "late";
  options.simulator.device = DeviceChoice::Kind::reference;
  options.firstFrame = 7;
  options.endFrame = 8;
  drive::run(drive, options);
  const std::string bytes = folder.get("out/npy/top/000007.npy");
  CHECK(bytes == folder.get("late/npy/top/000007.npy"));
  size_t soft = 0;
  for (const Row& row : rowsOf(bytes)) {
    if (row.category != 30 || row.y < 0) continue;
    ++soft;
    CHECK_THAT(row.x, WithinAbs(5.7 + row.time, 1e-4));
  }
  CHECK(soft > 5);
}

TEST_CASE("the size of an actor is that of the first state of its clip") {
  const DriveFolder folder;
  put(folder / "panels.gltf", movedCube("scale", {0, 1}, {0.5f, 1, 2, 0.5f, 1, 1}));
  Json json = panelDrive();
  json["outputs"] = {{{"format", "boxes"}, {"all_actors", true}}};
  json["sensors"][0]["effects"] = "clean";
  json["actors"] = {json["actors"][0]};
  json["actors"][0]["animation"] = {{"clip", "move"}};
  json["actors"][0]["size"] = {0.5, 1, 1.8};
  REQUIRE(folder.read(json).warnings.empty());
  folder.run(json);
  const auto sizeIn = [&](int scan, const std::string& out) {
    return Json::parse(folder.get(out + "/boxes/top/00000" + std::to_string(scan) + ".jsonl"))["size"];
  };
  const auto check = [](const Json& size, double x, double y, double z) {
    CHECK_THAT(size[0].get<double>(), WithinAbs(x, 1e-6));
    CHECK_THAT(size[1].get<double>(), WithinAbs(y, 1e-6));
    CHECK_THAT(size[2].get<double>(), WithinAbs(z, 1e-6));
  };
  check(sizeIn(0, "out"), 0.5, 1, 1.8);
  check(sizeIn(5, "out"), 0.5, 1, 1.35);
  json["actors"][0]["animation"]["offset"] = 0.5;  // figures of a crowd are alike, wherever each is in its clip
  folder.run(json, "later");
  check(sizeIn(0, "later"), 0.5, 1, 1.35);
}

TEST_CASE("velocities are those of the way, without the bob of a short clip that loops") {
  const DriveFolder folder;
  Json json = panelDrive();
  json["outputs"] = {{{"format", "boxes"}, {"all_actors", true}}};
  json["actors"] = {json["actors"][0]};
  // Returns the greatest difference of velocities in m/s from a way of so much along x, and checks what moves.
  const auto greatest = [&](double speed, const Json& animation, const std::string& effects) {
    json["sensors"][0]["effects"] = effects;
    json["actors"][0]["animation"] = animation;
    json["actors"][0]["trajectory"]["waypoints"] = {waypoint(-1, 5 - speed, 0, 1), waypoint(2, 5 + 2 * speed, 0, 1)};
    fs::remove_all(folder / "out");
    folder.run(json);
    double most = 0;
    for (int scan = 0; scan < 10; ++scan) {
      const Json box = Json::parse(folder.get("out/boxes/top/00000" + std::to_string(scan) + ".jsonl"));
      const Json& v = box["velocity"];
      const Vec3 off = {v[0].get<double>() - speed, v[1].get<double>(), v[2].get<double>()};
      most = std::max(most, std::sqrt(off.x * off.x + off.y * off.y + off.z * off.z));
      const double own = std::abs(v[0].get<double>()) + std::abs(v[2].get<double>());
      CHECK(box["moving"] == (own > 0.1));
    }
    return most;
  };
  for (const std::string effects : {"auto", "clean"}) {
    CAPTURE(effects);
    put(folder / "panels.gltf", movedCube("translation", {0, 0.2f, 0.4f}, {0, 0, 0, 0.1f, 0, 0.1f, 0, 0, 0}));
    CHECK(greatest(1.5, {{"clip", "move"}}, effects) < 1e-9);
    CHECK(greatest(0, {{"clip", "move"}}, effects) < 1e-9);
    CHECK(greatest(0, {{"clip", "move"}, {"speed", -0.21}}, effects) < 1e-9);
    CHECK(greatest(1.5, {{"clip", "move"}, {"speed", 0.19}}, effects) > 0.1);  // it takes more than 2 s
    CHECK(greatest(1.5, {{"clip", "move"}, {"loop", false}}, effects) > 0.6);
    // A clip that moves its actor away moves it back when it begins anew.
    put(folder / "panels.gltf", movedCube("translation", {0, 1}, {0, 0, 0, 3, 0, 0}));
    CHECK(greatest(0, {{"clip", "move"}, {"offset", 0.35}}, effects) < 1e-9);
  }
}

TEST_CASE("a wrong animation in a drive file is told with its path and the nearest clip") {
  const DriveFolder folder;
  put(folder / "panels.gltf", panels());
  const auto refused = [&](const char* pointer, const Json& value, const std::string& words) {
    Json json = panelDrive();
    json[Json::json_pointer(pointer)] = value;
    CHECK_THAT(problemOf([&] { folder.read(json); }, ErrorCode::format), ContainsSubstring(words));
  };
  refused("/actors/0/animation/clip", "pusch", "actors[0].animation.clip: no clip is called 'pusch'; there is push");
  refused("/actors/0/animation/sped", 1, "actors[0].animation.sped: is an unknown word");
  refused("/actors/1/animation", Json::object(), "actors[1].animation.clip: is missing");
  refused("/scenes/0/animation", {{"clip", "push"}},
          "scenes[0].animation.clip: no clip is called 'push'; the scene has none");
}
