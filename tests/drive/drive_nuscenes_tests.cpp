// SPDX-License-Identifier: Apache-2.0
// The tables, labels and annotations of nuScenes, as its development kit reads them.
#include <algorithm>
#include <catch2/matchers/catch_matchers_floating_point.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include "drive_support.hpp"
#include "npy_rows.hpp"
#include "support.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::WithinAbs;

TEST_CASE("nuScenes: tables whose tokens lead somewhere, points with rings, annotations with the numbers of points") {
  const DriveFolder& folder = made();
  const auto table = [&](const std::string& name) {
    return Json::parse(folder.get("out/nuscenes/v1.0-drive/" + name + ".json"));
  };
  std::map<std::string, Json> byToken;
  for (const char* name : {"attribute", "calibrated_sensor", "category", "ego_pose", "instance", "log", "map", "sample",
                           "sample_annotation", "sample_data", "scene", "sensor", "visibility"})
    for (const Json& row : table(name)) byToken[std::string(name) + row["token"].get<std::string>()] = row;
  const auto has = [&](const std::string& name, const Json& token) {
    return token == "" || byToken.contains(name + token.get<std::string>());
  };
  CHECK(table("sample").size() == 2);  // frames 0 and 5
  CHECK(table("sample_data").size() == 15);
  for (const Json& data : table("sample_data")) {
    CHECK((has("sample", data["sample_token"]) && has("ego_pose", data["ego_pose_token"])));
    CHECK((has("calibrated_sensor", data["calibrated_sensor_token"]) && has("sample_data", data["next"]) &&
           has("sample_data", data["prev"])));
    const std::string file = data["filename"];
    CHECK(file.starts_with(data["is_key_frame"] ? "samples/" : "sweeps/"));
    // By the schema of nuScenes, a sweep points to the sample that follows closest in time; the last ones have none.
    const Json& sample = byToken["sample" + data["sample_token"].get<std::string>()];
    CHECK((data["is_key_frame"] || sample["next"] == "" || sample["timestamp"] > data["timestamp"]));
    const std::string points = folder.get("out/nuscenes/" + file);
    REQUIRE(points.size() > 0);
    REQUIRE(points.size() % 20 == 0);
    for (size_t i = 0; i < points.size(); i += 20) {
      const float ring = at<float>(points, i + 16);
      CHECK((ring >= 0 && ring <= 7 && ring == std::floor(ring)));
    }
  }
  bool car = false;
  for (const Json& note : table("sample_annotation")) {
    CHECK((has("sample", note["sample_token"]) && has("instance", note["instance_token"]) &&
           has("visibility", note["visibility_token"]) && has("attribute", note["attribute_tokens"][0])));
    CHECK(note["num_lidar_pts"] > 0);
    const Json& instance = byToken["instance" + note["instance_token"].get<std::string>()];
    if (byToken["category" + instance["category_token"].get<std::string>()]["name"] != "car") continue;
    car = true;
    CHECK(note["size"] == Json::array({2.0, 4.0, 1.5}));  // width, length, height
    CHECK(note["rotation"] == Json::array({1.0, 0.0, 0.0, 0.0}));
    const double time = byToken["sample" + note["sample_token"].get<std::string>()]["timestamp"].get<double>() / 1e6;
    // The car is where it is when the scans that begin with the sample hit it.
    const double after = (note["translation"][0].get<double>() - 3) / 5 - (time - 1700000000);
    CHECK(after > 1e-3);
    CHECK(after < 0.1);
  }
  CHECK(car);
}

TEST_CASE("nuScenes: samples, scans and annotations are chained in the order of their times, and counted") {
  const DriveFolder& folder = made();
  const auto table = [&](const std::string& name) {
    return Json::parse(folder.get("out/nuscenes/v1.0-drive/" + name + ".json"));
  };
  // The chains of a table: each goes on as long as there is a next row, which names this one as its previous.
  const auto chainsOf = [&](const std::string& name) {
    std::map<std::string, Json> rows;
    for (const Json& row : table(name)) rows[row["token"]] = row;
    std::vector<std::vector<Json>> chains;
    size_t chained = 0;
    for (const auto& [token, row] : rows) {
      if (row["prev"] != "") continue;
      std::vector<Json>& chain = chains.emplace_back(std::vector{row});
      while (chain.back()["next"] != "" && chain.size() <= rows.size()) {
        const Json next = rows.at(chain.back()["next"]);
        CHECK(next["prev"] == chain.back()["token"]);
        chain.push_back(next);
      }
      chained += chain.size();
    }
    CHECK(chained == rows.size());
    std::ranges::sort(chains, std::greater<>(), [](const auto& chain) { return chain.size(); });
    return chains;
  };
  constexpr int64_t kStart = 1700000000000000;  // us
  const auto samples = chainsOf("sample");
  REQUIRE(samples.size() == 1);
  REQUIRE(samples[0].size() == 2);
  CHECK((samples[0][0]["timestamp"] == kStart && samples[0][1]["timestamp"] == kStart + 500000));
  const Json scene = table("scene")[0];
  CHECK((scene["nbr_samples"] == 2 && scene["first_sample_token"] == samples[0][0]["token"] &&
         scene["last_sample_token"] == samples[0][1]["token"]));

  std::map<std::string, Json> mounts, egos;
  for (const Json& row : table("calibrated_sensor")) mounts[row["token"]] = row;
  for (const Json& row : table("ego_pose")) egos[row["token"]] = row;
  const auto scans = chainsOf("sample_data");
  REQUIRE(scans.size() == 2);
  REQUIRE((scans[0].size() == 10 && scans[1].size() == 5));
  size_t keys = 0, ofFirst = 0;
  for (const bool side : {false, true})
    for (size_t i = 0; i < scans[side].size(); ++i) {
      const Json& scan = scans[side][i];
      const int64_t after = side ? 50000 + 200000 * int64_t(i) : 100000 * int64_t(i);
      CHECK(scan["timestamp"] == kStart + after);
      CHECK(scan["calibrated_sensor_token"] == scans[side][0]["calibrated_sensor_token"]);
      CHECK_THAT(egos.at(scan["ego_pose_token"])["translation"][0].get<double>(),
                 WithinAbs(-2 + 4e-6 * static_cast<double>(after), 1e-9));
      keys += scan["is_key_frame"].get<bool>();
      ofFirst += scan["sample_token"] == samples[0][0]["token"];
    }
  CHECK(keys == 3);     // the sensor at the side starts no scan in the frame 5
  CHECK(ofFirst == 2);  // what follows belongs to the second sample, which is the last one, too
  // The mount of the sensor at the side is a pitch of 10 degrees, and then a yaw of 90.
  const Json& mount = mounts.at(scans[1][0]["calibrated_sensor_token"]);
  CHECK(mount["translation"] == Json::array({1.0, 0.5, 1.0}));
  const double pitch = 5 * std::numbers::pi / 180,
               wanted[] = {std::cos(pitch), -std::sin(pitch), std::sin(pitch), std::cos(pitch)};
  for (size_t i = 0; i < 4; ++i)
    CHECK_THAT(mount["rotation"][i].get<double>(), WithinAbs(std::sqrt(0.5) * wanted[i], 1e-12));

  const auto notes = chainsOf("sample_annotation");
  const Json instances = table("instance");
  REQUIRE(notes.size() == 2);  // the person is there in the second sample alone
  REQUIRE((notes[0].size() == 2 && notes[1].size() == 1 && instances.size() == 2));
  CHECK(
      (notes[0][0]["sample_token"] == samples[0][0]["token"] && notes[0][1]["sample_token"] == samples[0][1]["token"]));
  for (const auto& chain : notes) {
    const auto instance =
        std::ranges::find_if(instances, [&](const Json& row) { return row["token"] == chain[0]["instance_token"]; });
    REQUIRE(instance != instances.end());
    for (const Json& note : chain) CHECK(note["instance_token"] == chain[0]["instance_token"]);
    CHECK(((*instance)["nbr_annotations"] == chain.size() &&
           (*instance)["first_annotation_token"] == chain.front()["token"] &&
           (*instance)["last_annotation_token"] == chain.back()["token"]));
  }
}

TEST_CASE("nuScenes: the visibility of an annotation is one of four bins") {
  const DriveFolder folder;
  Json json = quietDrive();
  json["weather"] = json["actors"] = Json::array();
  json["classes"] = Json::object();
  json["duration"] = 0.1;
  json["ego"]["trajectory"] = {{"waypoints", {waypoint(0, 0, 0, 0)}}};
  json["sensors"] = {json["sensors"][0]};
  json["sensors"][0]["sensor"]["columns"] = 720;
  json["sensors"][0]["effects"] = {{"divergence", {{"use", "off"}}}};
  json["scenes"] = {{{"file", "floor.obj"}}};
  json["outputs"] = {{{"format", "nuscenes"}, {"keyframes", 1}}};
  // In each direction a car stands across, whose side is 7 m away and 4 m long; a wall 4 m away leaves a share of it.
  const double shares[] = {0.3, 0.5, 0.7, 0.9}, half = std::atan2(2, 7);
  for (int i = 0; i < 4; ++i) {
    const double angle = i * std::numbers::pi / 2, c = std::cos(angle), s = std::sin(angle);
    const double end = 4 * std::tan(half - 2 * half * shares[i]);
    std::string wall;
    for (const auto& [left, up] : {std::pair(-3.0, -1.0), {end, -1.0}, {end, 4.0}, {-3.0, 4.0}})
      wall += "v " + std::to_string(4 * c - left * s) + " " + std::to_string(4 * s + left * c) + " " +
              std::to_string(up) + "\n";
    const std::string name = "car-" + std::to_string(i);
    put(folder / (name + ".obj"), wall + "f 1 2 3\nf 1 3 4\n");
    json["scenes"].push_back({{"file", name + ".obj"}});
    json["classes"][name] = {{"id", i + 1}};
    Json place = waypoint(0, 8 * c, 8 * s, 0.75);
    place["yaw_deg"] = 90 * i + 90;
    json["actors"].push_back({{"name", name},
                              {"model", "cube"},
                              {"class", name},
                              {"size", {4, 2, 1.5}},
                              {"trajectory", {{"waypoints", {place}}}}});
  }
  REQUIRE(folder.run(json).finished);
  const auto table = [&](const std::string& name) {
    std::map<std::string, Json> rows;
    for (const Json& row : Json::parse(folder.get("out/nuscenes/v1.0-drive/" + name + ".json")))
      rows[row["token"]] = row;
    return rows;
  };
  const auto instances = table("instance"), categories = table("category");
  std::map<std::string, std::string> bins;
  for (const auto& [token, note] : table("sample_annotation"))
    bins[categories.at(instances.at(note["instance_token"])["category_token"])["name"]] = note["visibility_token"];
  CHECK(bins == std::map<std::string, std::string>{{"car-0", "1"}, {"car-1", "2"}, {"car-2", "3"}, {"car-3", "4"}});
}

TEST_CASE("nuScenes: times of a pose file of nuScenes come back to the microsecond") {
  const DriveFolder folder;
  put(folder / "ego_pose.json",
      R"([{"timestamp": 1532402927647951, "rotation": [1, 0, 0, 0], "translation": [0, 0, 0]},
          {"timestamp": 1532402927747951, "rotation": [1, 0, 0, 0], "translation": [1, 0, 0]}])");
  Json json = smallDrive();
  json["actors"] = Json::array();
  json["ego"]["trajectory"] = {{"file", "ego_pose.json"}, {"format", "nuscenes"}};
  json["outputs"] = {{{"format", "nuscenes"}, {"sensors", {"top"}}}};
  REQUIRE(folder.run(json).finished);
  for (const char* table : {"sample", "sample_data", "ego_pose"})
    CHECK(Json::parse(folder.get("out/nuscenes/v1.0-drive/" + std::string(table) + ".json"))[0]["timestamp"] ==
          1532402927647951);
}

TEST_CASE("nuScenes: with lidarseg every point of a key frame has the index of its category") {
  const DriveFolder folder;
  Json json = smallDrive();
  json["duration"] = 0.3;
  json["weather"] = {{{"time", 0}, {"rain", 50}}};
  json["classes"]["noise"] = {{"id", 7}};
  json["outputs"] = {{{"format", "nuscenes"}, {"keyframes", 2}, {"lidarseg", true}, {"sensors", {"top"}}},
                     json["outputs"][0]};
  REQUIRE(folder.run(json).finished);
  const auto table = [&](const std::string& name) {
    return Json::parse(folder.get("out/nuscenes/v1.0-drive/" + name + ".json"));
  };
  std::map<std::string, uint8_t> indices;
  for (const Json& row : table("category")) {
    CHECK(row["index"] == indices.size());
    indices[row["name"]] = row["index"];
  }
  CHECK(indices == std::map<std::string, uint8_t>{{"noise", 0}, {"car", 1}, {"ground", 2}, {"person", 3}});
  const std::map<uint16_t, uint8_t> ids = {{10, 1}, {40, 2}, {30, 3}};
  std::map<std::string, Json> scans;
  for (const Json& row : table("sample_data")) scans[row["token"]] = row;
  const Json labels = table("lidarseg");
  REQUIRE(labels.size() == 2);
  std::set<uint8_t> found;
  for (const Json& row : labels) {
    const Json& scan = scans.at(row["sample_data_token"]);
    CHECK(scan["is_key_frame"] == true);
    CHECK(row["filename"] == "lidarseg/v1.0-drive/" + row["token"].get<std::string>() + "_lidarseg.bin");
    const std::string bytes = folder.get("out/nuscenes/" + row["filename"].get<std::string>());
    CHECK(bytes.size() == folder.get("out/nuscenes/" + scan["filename"].get<std::string>()).size() / 20);
    const std::vector<Row> rows =
        rowsOf(folder.get(scan["timestamp"] == 0 ? "out/npy/top/000000.npy" : "out/npy/top/000002.npy"));
    REQUIRE(bytes.size() == rows.size());
    for (size_t i = 0; i < rows.size(); ++i) {
      const auto own = ids.find(rows[i].category);
      CHECK(static_cast<uint8_t>(bytes[i]) == (own == ids.end() ? 0 : own->second));
      found.insert(static_cast<uint8_t>(bytes[i]));
    }
  }
  CHECK(found == std::set<uint8_t>{0, 1, 2});
  // The labels need no other output that asks for classes.
  json["outputs"].erase(1);
  REQUIRE(folder.run(json, "alone").finished);
  const Json own = Json::parse(folder.get("alone/nuscenes/v1.0-drive/lidarseg.json"));
  REQUIRE(own.size() == 2);
  for (size_t i = 0; i < 2; ++i)
    CHECK(folder.get("alone/nuscenes/" + own[i]["filename"].get<std::string>()) ==
          folder.get("out/nuscenes/" + labels[i]["filename"].get<std::string>()));
}

TEST_CASE("nuScenes: annotations have the attributes that nuScenes has for their categories") {
  const DriveFolder folder;
  Json json = quietDrive();
  json["weather"] = Json::array();
  const Json actor = json["actors"][0];
  json["actors"] = Json::array();
  const auto add = [&](const std::string& name, const std::string& category, double speed, double until) {
    json["classes"][category] = {{"id", 1 + json["actors"].size()}};
    Json added = actor;
    added["name"] = name;
    added["class"] = category;
    const double angle = 1.25 * static_cast<double>(json["actors"].size()), x = 6 * std::cos(angle),
                 y = 6 * std::sin(angle);
    added["size"] = {1, 1, 1.5};
    added["trajectory"]["waypoints"] = {waypoint(0, x, y, 0.75), waypoint(until, x + speed * until, y, 0.75)};
    if (until < 1) added["trajectory"]["waypoints"].push_back(waypoint(1, x + speed * until, y, 0.75));
    json["actors"].push_back(added);
  };
  add("drives", "vehicle.car", 1, 1);
  add("stops", "vehicle.truck", 1, 0.3);
  add("parks", "vehicle.bus.rigid", 0, 1);
  add("rides", "vehicle.bicycle", 1, 1);
  add("walks", "human.pedestrian.adult", 1, 1);
  json["outputs"] = {{{"format", "nuscenes"}, {"keyframes", 9}}};
  const auto attributesOf = [&](const std::string& out) {
    REQUIRE(folder.run(json, out).finished);
    const auto table = [&](const std::string& name) {
      std::map<std::string, Json> rows;
      for (const Json& row : Json::parse(folder.get(out + "/nuscenes/v1.0-drive/" + name + ".json")))
        rows[row["token"]] = row;
      return rows;
    };
    const auto attributes = table("attribute"), instances = table("instance"), categories = table("category"),
               samples = table("sample");
    std::map<std::string, std::string> found;
    for (const auto& [token, note] : table("sample_annotation")) {
      if (samples.at(note["sample_token"])["next"] != "") continue;
      std::string& names = found[categories.at(instances.at(note["instance_token"])["category_token"])["name"]];
      for (const Json& attribute : note["attribute_tokens"])
        names += attributes.at(attribute)["name"].get<std::string>();
    }
    return found;
  };
  CHECK(attributesOf("one") == std::map<std::string, std::string>{{"vehicle.car", "vehicle.moving"},
                                                                  {"vehicle.truck", "vehicle.stopped"},
                                                                  {"vehicle.bus.rigid", "vehicle.parked"},
                                                                  {"vehicle.bicycle", ""},
                                                                  {"human.pedestrian.adult", "pedestrian.moving"}});
  json["actors"] = Json::array();
  add("stands", "human.pedestrian.child", 0, 1);
  add("lies", "movable_object.barrier", 0, 1);
  add("waits", "car", 0, 1);
  add("moves", "van", 1, 1);
  CHECK(attributesOf("two") == std::map<std::string, std::string>{{"human.pedestrian.child", "pedestrian.standing"},
                                                                  {"movable_object.barrier", ""},
                                                                  {"car", "standing"},
                                                                  {"van", "moving"}});
}

TEST_CASE("nuScenes: of two lidars that see an actor, the output's first one has the box, and the best view counts") {
  const DriveFolder folder;
  put(folder / "wall.obj", "v 2 -9 0\nv 2 9 0\nv 2 9 0.5\nv 2 -9 0.5\nf 1 2 3\nf 1 3 4\n");
  Json json = quietDrive();
  json["weather"] = Json::array();
  json["duration"] = 0.1;
  json["ego"]["trajectory"] = {{"waypoints", {waypoint(0, 0, 0, 0)}}};
  json["scenes"].push_back({{"file", "wall.obj"}, {"class", "ground"}});
  json["actors"] = {json["actors"][0]};
  json["actors"][0]["trajectory"]["waypoints"] = {waypoint(0, 8, 0, 0.75), waypoint(1, 13, 0, 0.75)};
  json["sensors"][0]["sensor"]["columns"] = 720;
  json["sensors"][0]["effects"] = "auto";
  // The lower lidar looks over the wall with three of its channels.
  json["sensors"][1]["mount"] = {{"position", {0, 0, 0.3}}};
  json["sensors"][1]["sensor"]["elevation_deg"] = {0, 2, 4, 6, 8, 9};
  json["outputs"] = {{{"format", "nuscenes"}}, {{"format", "boxes"}}};
  REQUIRE(folder.run(json).finished);
  const Json top = Json::parse(folder.get("out/boxes/top/000000.jsonl")),
             side = Json::parse(folder.get("out/boxes/side/000000.jsonl")),
             notes = Json::parse(folder.get("out/nuscenes/v1.0-drive/sample_annotation.json"));
  REQUIRE(notes.size() == 1);
  REQUIRE(top["points"].get<uint64_t>() > side["points"].get<uint64_t>());
  REQUIRE(top["visibility"] == 1);
  REQUIRE(side["visibility"].get<double>() < 0.8);
  REQUIRE(top["world_frame"]["position"] != side["world_frame"]["position"]);
  CHECK(notes[0]["num_lidar_pts"] == top["points"].get<uint64_t>() + side["points"].get<uint64_t>());
  CHECK(notes[0]["translation"] == top["world_frame"]["position"]);
  CHECK(notes[0]["visibility_token"] == "4");

  json["outputs"][0]["sensors"] = {"side", "top"};
  REQUIRE(folder.run(json, "sides").finished);
  const Json others = Json::parse(folder.get("sides/nuscenes/v1.0-drive/sample_annotation.json"));
  CHECK(others[0]["num_lidar_pts"] == notes[0]["num_lidar_pts"]);
  CHECK(others[0]["translation"] == side["world_frame"]["position"]);
  CHECK(others[0]["visibility_token"] == "4");

  // Where the first sensor has not hit the actor, the one with most points has the box.
  json["sensors"].push_back(json["sensors"][0]);
  json["sensors"][2]["name"] = "up";
  json["sensors"][2]["mount"] = {{"position", {0, 0, 9}}};
  json["outputs"][0]["sensors"] = {"up", "side", "top"};
  json["sensors"][2]["sensor"]["elevation_deg"] = {0, 20};
  REQUIRE(folder.run(json, "ups").finished);
  CHECK(Json::parse(folder.get("ups/nuscenes/v1.0-drive/sample_annotation.json"))[0]["translation"] ==
        top["world_frame"]["position"]);
}
