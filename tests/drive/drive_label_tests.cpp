// SPDX-License-Identifier: Apache-2.0
// Whether the boxes of a drive are where its points are, move as these do, and say how much of an actor is seen.
#include <array>
#include <catch2/matchers/catch_matchers_floating_point.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <initializer_list>
#include <set>
#include <sstream>
#include <tuple>

#include "base/quaternion.hpp"
#include "base/units.hpp"
#include "base/vector.hpp"
#include "bits.hpp"
#include "cpu_time.hpp"
#include "drive/pose_math.hpp"
#include "drive/world.hpp"
#include "drive_support.hpp"
#include "npy_rows.hpp"
#include "sensor/beams.hpp"
#include "support.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::WithinAbs;

namespace {

Json car(const char* name, const std::vector<Json>& waypoints) {
  return {{"name", name},
          {"model", "cube"},
          {"class", "car"},
          {"size", {4, 2, 1.5}},
          {"trajectory", {{"waypoints", waypoints}}}};
}

Json facing(Json stamp, double yaw) {
  stamp["yaw_deg"] = yaw;
  return stamp;
}

/// A drive without weather, whose one sensor stands at the origin and hits nothing but actors.
Json actorDrive() {
  Json json = smallDrive();
  json["weather"] = Json::array();
  json["ego"]["trajectory"]["waypoints"] = {waypoint(0, 0, 0, 0), waypoint(1, 0, 0, 0)};
  json["sensors"] = {json["sensors"][0]};
  json["sensors"][0]["sensor"]["columns"] = 360;
  json["sensors"][0]["effects"] = {{"divergence", {{"use", "off"}}}};
  json["scenes"] = {{{"file", "floor.obj"}, {"class", "ground"}, {"pose", {{"position", {0, 0, -0.5}}}}}};
  json["actors"] = Json::array();
  json["outputs"].push_back({{"format", "boxes"}});
  return json;
}

/// By name, the boxes of a scan of the sensor "top".
std::map<std::string, Json> boxesOf(const DriveFolder& folder, int scan, const std::string& out = "out") {
  std::istringstream lines(folder.get(out + "/boxes/top/00000" + std::to_string(scan) + ".jsonl"));
  std::map<std::string, Json> boxes;
  for (std::string line; std::getline(lines, line);) boxes[Json::parse(line)["name"]] = Json::parse(line);
  return boxes;
}

Vec3 vectorOf(const Json& list) {
  return {list[0], list[1], list[2]};
}

bool isIn(const Vec3& inBox, const Vec3& size, double margin) {
  return std::abs(inBox.x) <= size.x / 2 + margin && std::abs(inBox.y) <= size.y / 2 + margin &&
         std::abs(inBox.z) <= size.z / 2 + margin;
}

}  // namespace

TEST_CASE("a box's visibility does not depend on fog before it, nor on returns that are lost") {
  const DriveFolder folder;
  Json json = actorDrive();
  json["duration"] = 0.1;
  json["sensors"][0]["sensor"]["columns"] = 720;
  // A wall hides the lower part of one car, and all of the other one is seen.
  json["models"]["wall"] = {{"file", "cube.obj"}};
  json["actors"] = {car("hidden", {facing(waypoint(0, 8, 0, 0.75), 90)}),
                    car("free", {facing(waypoint(0, -8, 0, 0.75), 90)}), car("wall", {waypoint(0, 4, 0, 0.5)})};
  json["actors"][2]["size"] = {0.2, 8, 1.4};
  const auto visibilities = [&](const std::string& out, const Json& effects) {
    json["sensors"][0]["effects"] = effects;
    folder.run(json, out);
    std::map<std::string, Json> boxes = boxesOf(folder, 0, out);
    REQUIRE((boxes.contains("hidden") && boxes.contains("free")));
    return std::pair<double, double>(boxes["hidden"]["visibility"], boxes["free"]["visibility"]);
  };
  const auto [hidden, free] = visibilities("clear", "auto");
  CHECK(hidden > 0.2);
  CHECK(hidden < 0.8);
  CHECK(free == 1);
  const Json fog = {{"visibility", 30}};
  for (const auto& [out, effects] :
       std::map<std::string, Json>{{"two", {{"fog", fog}, {"returns", {{"count", 2}}}}},
                                   {"last", {{"fog", fog}, {"returns", {{"mode", "last"}}}}},
                                   {"strongest", {{"fog", fog}, {"returns", {{"mode", "strongest"}}}}},
                                   {"dropped", {{"drop-out", {{"general_rate", 0.5}}}}}}) {
    INFO(out);
    const auto [seen, whole] = visibilities(out, effects);
    CHECK_THAT(seen, WithinAbs(hidden, 0.12));
    CHECK(whole == 1);
  }
}

TEST_CASE("a car behind glass is seen") {
  const DriveFolder folder;
  Json json = actorDrive();
  json["duration"] = 0.1;
  json["sensors"][0]["effects"] = {{"returns", {{"count", 2}}}};
  json["actors"] = {car("behind", {facing(waypoint(0, 8, 0, 0.75), 90)})};
  folder.run(json, "clear");
  putPane(folder);
  json["scenes"].push_back({{"file", "pane.glb"}, {"class", "ground"}});
  folder.run(json, "glass");
  const Json clear = boxesOf(folder, 0, "clear")["behind"], behind = boxesOf(folder, 0, "glass")["behind"];
  CHECK(clear["visibility"] == 1);
  CHECK(behind["visibility"] == 1);
  CHECK(behind["points"].get<uint64_t>() > 0);
}

TEST_CASE("actors that no beam has hit have boxes where an output asks for all") {
  const DriveFolder folder;
  // Two corners of a large box: nearly all beams pass between them.
  std::string corners;
  for (const double side : {-0.5, 0.5})
    for (int corner = 0; corner < 3; ++corner)
      corners += "v " + std::to_string(side + (corner == 1 ? 1e-4 : 0)) + " " +
                 std::to_string(side + (corner == 2 ? 1e-4 : 0)) + " " + std::to_string(side) + "\n";
  put(folder / "corners.obj", corners + "f 1 2 3\nf 4 5 6\n");
  put(folder / "wall.obj", "v 4 -3 -1\nv 4 3 -1\nv 4 3 5\nv 4 -3 5\nf 1 2 3\nf 1 3 4\n");
  Json json = actorDrive();
  json["duration"] = 0.3;
  json["scenes"].push_back({{"file", "wall.obj"}, {"class", "ground"}});
  json["models"]["corners"] = {{"file", "corners.obj"}};
  json["actors"] = {car("hidden", {facing(waypoint(0, 8, 0, 0.75), 90), facing(waypoint(1, 8, 1, 0.75), 90)}),
                    car("seen", {facing(waypoint(0, -8, 0, 0.75), 0)}),
                    car("beyond", {facing(waypoint(0, 0, 62.2, 0.75), 0)}),
                    car("partly within reach", {facing(waypoint(0, 0, 60.9, 0.75), 0)}),
                    car("above", {facing(waypoint(0, 0, 3, 20), 0)}),
                    car("gone", {facing(waypoint(0.5, -5, 5, 0.75), 0)}),
                    car("ignored", {facing(waypoint(0, 0, 5, 0.75), 0)}),
                    car("hollow", {facing(waypoint(0, 0, -6, 0.75), 0)})};
  json["actors"][5]["outside"] = "gone";
  json["actors"][7]["model"] = "corners";
  json["sensors"][0]["ignores"] = {"ignored"};
  folder.run(json, "hit");
  json["outputs"].back()["all_actors"] = true;
  folder.run(json, "all");
  CHECK(boxesOf(folder, 2, "hit").size() == 1);
  std::map<std::string, Json> boxes = boxesOf(folder, 2, "all");
  REQUIRE(boxes.size() == 5);
  CHECK(boxes["seen"] == boxesOf(folder, 2, "hit")["seen"]);
  CHECK(boxes["seen"]["points"] > 0);
  for (const char* name : {"hidden", "partly within reach", "above", "hollow"}) {
    INFO(name);
    CHECK(boxes[name]["points"] == 0);
    CHECK(boxes[name]["class"] == "car");
  }
  CHECK(boxes["hidden"]["visibility"] == 0);
  CHECK(boxes["hollow"]["visibility"] == 1);
  // Nothing lies behind the ones far away and far up that would tell.
  CHECK_FALSE(boxes["partly within reach"].contains("visibility"));
  CHECK_FALSE(boxes["above"].contains("visibility"));
  CHECK(boxes["above"]["time"] == 0);
  // The head turns clockwise from behind, so it looks ahead halfway through its scan.
  const double time = boxes["hidden"]["time"];
  CHECK_THAT(time, WithinAbs(0.05, 0.01));
  CHECK_THAT(boxes["hidden"]["world_frame"]["position"][1].get<double>(), WithinAbs(0.2 + time, 1e-9));
  CHECK_THAT(boxes["hidden"]["velocity"][1].get<double>(), WithinAbs(1, 1e-9));

  // A channel may see farther than its sensor, and a thing closely before a box counts as a part of it.
  json["sensors"][0]["sensor"]["range_max"] = {60, 60, 60, 60, 60, 60, 60, 70};
  folder.run(json, "far");
  CHECK(boxesOf(folder, 2, "far").contains("beyond"));
  for (const auto& [out, x] : {std::pair("plate", "6.95"), std::pair("wall", "6.8")}) {
    const std::string at = std::string("v ") + x;
    put(folder / "wall.obj", at + " -3 -1\n" + at + " 3 -1\n" + at + " 3 5\n" + at + " -3 5\nf 1 2 3\nf 1 3 4\n");
    folder.run(json, out);
    CHECK(boxesOf(folder, 2, out)["hidden"]["visibility"] == (out[0] == 'p' ? 1 : 0));
  }

  json["outputs"][0]["all_actors"] = true;
  CHECK_THROWS_WITH(folder.read(json), ContainsSubstring("outputs[0].all_actors: is only for boxes"));
}

TEST_CASE("visibility counts each beam where the sensor and the actor are when it fires") {
  const DriveFolder folder;
  Json json = actorDrive();
  json["duration"] = 0.3;
  // The turn starts ahead, where one half of a car is seen at the start of a scan and the other half at its end.
  Json& rigged = json["sensors"][0];
  rigged["sensor"]["columns"] = 1440;
  rigged["sensor"]["azimuth_start_deg"] = 0;
  rigged["mount"] = {{"position", {0, 0, 0.7}}};
  json["scenes"] = {{{"file", "floor.obj"}, {"class", "ground"}, {"pose", {{"position", {0, 0, -0.5}}}}}};
  put(folder / "wall.obj", "v 40 -40 -1\nv 40 40 -1\nv 40 40 9\nv 40 -40 9\nf 1 2 3\nf 1 3 4\n");
  json["scenes"].push_back({{"file", "wall.obj"}, {"class", "ground"}});
  const Vec3 size = {4, 2, 1.5};
  json["outputs"] = {{{"format", "npy"}, {"fields", "range,beam,time,instance"}},
                     {{"format", "boxes"}, {"all_actors", true}}};
  rigged["sensor"]["elevation_deg"] = {-4, -3, -2, -1, 0, 1, 2, 3};
  for (const auto& [ego, actor, turn] : {std::array{20.0, 0.0, 0.0}, {0.0, -15.0, 0.0}, {20.0, 15.0, 60.0}}) {
    json["ego"]["trajectory"]["waypoints"] = {facing(waypoint(0, 0, 0, 0), 0), facing(waypoint(1, ego, 0, 0), turn)};
    json["actors"] = {car("near", {facing(waypoint(0, 11, -1.1, 0.75), 0)}),
                      car("far", {facing(waypoint(0, 22, 0, 0.75), 0), facing(waypoint(1, 22 + actor, 0, 0.75), 0)}),
                      car("behind", {facing(waypoint(0, 40.4, 0, 0.75), 90)})};
    json["actors"][2]["size"] = {6, 0.5, 1.5};
    for (const bool deskew : {false, true}) {
      CAPTURE(ego, actor, turn, deskew);
      rigged["effects"] = {{"divergence", {{"use", "off"}}}, {"sensor-motion", {{"deskew", deskew}}}};
      const std::string out = "out" + std::to_string(static_cast<int>(100 + ego + actor)) + (deskew ? "d" : "");
      folder.run(json, out);
      const Sensor sensor = folder.read(json).sensors[0].sensor;
      for (const int scan : {0, 2}) {
        const std::map<std::string, Json> boxes = boxesOf(folder, scan, out);
        REQUIRE(boxes.contains("far"));
        const auto object = boxes.at("far")["object"].get<uint32_t>();
        const std::string bytes = folder.get(out + "/npy/top/00000" + std::to_string(scan) + ".npy");
        double through = 0, seen = 0;
        for (size_t row = 10 + at<uint16_t>(bytes, 8); row + 16 <= bytes.size(); row += 16) {
          const auto range = at<float>(bytes, row);
          const double time = 0.1 * scan + at<float>(bytes, row + 8);
          const Vec3 along =
              drive::yawPitchRoll(turn * kDegree * time, 0, 0) * directionOf(sensor, at<uint32_t>(bytes, row + 4));
          // From the sensor to the middle of the car.
          const Vec3 way = {22 + actor * time - ego * time, 0, 0.75 - 0.7};
          double near = 0, far = INFINITY;
          for (const auto& [step, middle, length] :
               {std::tuple(along.x, way.x, size.x), std::tuple(along.y, way.y, size.y),
                std::tuple(along.z, way.z, size.z)}) {
            const double a = (middle - length / 2) / step, b = (middle + length / 2) / step;
            near = std::max(near, std::min(a, b));
            far = std::min(far, std::max(a, b));
          }
          if (near > far) continue;
          ++through;
          seen += at<uint32_t>(bytes, row + 12) == object || range >= near - 0.1;
        }
        REQUIRE(through > 100);
        CHECK(seen > 0.3 * through);
        CHECK(seen < 0.9 * through);
        CHECK_THAT(boxes.at("far")["visibility"].get<double>(), WithinAbs(seen / through, 0.004));
        CHECK(boxes.at("behind")["visibility"] == 0);
      }
    }
  }
}

TEST_CASE("an actor of which only the edges of beams meet anything has points and no visibility") {
  const DriveFolder folder;
  Json json = actorDrive();
  json["duration"] = 0.1;
  json["epoch"] = 1700000000;
  json["sensors"][0]["effects"] = {{"divergence", {{"use", "on"}, {"horizontal", 0.04}, {"vertical", 0.04}}}};
  // A pole between two columns, which are 1 degree apart: the middles of beams pass it by.
  const double azimuth = 30.5 * kDegree;
  json["actors"] = {car("pole", {facing(waypoint(0, 8 * std::cos(azimuth), 8 * std::sin(azimuth), 1), 30.5)})};
  json["actors"][0]["size"] = {0.06, 0.06, 2};
  json["outputs"] = {{{"format", "boxes"}}, {{"format", "nuscenes"}, {"keyframes", 1}}};
  REQUIRE(folder.run(json).finished);
  const Json pole = boxesOf(folder, 0).at("pole");
  CHECK(pole["points"] > 0);
  CHECK_FALSE(pole.contains("visibility"));
  const Json notes = Json::parse(folder.get("out/nuscenes/v1.0-drive/sample_annotation.json"));
  REQUIRE(notes.size() == 1);
  CHECK(notes[0]["visibility_token"] == "4");
}

TEST_CASE("the velocity of an actor is taken within its trajectory, and it stands before and after that") {
  const DriveFolder folder;
  Json json = smallDrive();
  const std::vector<Json> way = {waypoint(0.25, 0, 3, 0.75), waypoint(0.65, 4, 3, 0.75)};
  json["actors"] = {car("held", way), car("gone", way), car("standing", {waypoint(0.3, 1, 1, 1)})};
  json["actors"][1]["outside"] = "gone";
  const drive::Drive drive = folder.read(json);
  const drive::World world(drive);
  const auto speed = [&](size_t actor, double begin, double end) {
    const drive::World::Placement placement = world.placementOf(actor, begin, end, begin);
    CHECK(placement.isMoving() == (placement.velocity.x > 0.1));
    CHECK((placement.velocity.y == 0 && placement.velocity.z == 0));
    return placement.velocity.x;
  };
  // Without motion within the scan.
  for (const double time : {0.25, 0.26, 0.3, 0.6, 0.64, 0.65})
    for (const size_t actor : {size_t{0}, size_t{1}}) CHECK_THAT(speed(actor, time, time), WithinAbs(10, 1e-9));
  for (const double time : {0.0, 0.2, 0.24, 0.66, 0.7, 0.9}) CHECK(speed(0, time, time) == 0);
  // With motion within the scan, an actor that arrives in the scan is slower there.
  for (const size_t actor : {size_t{0}, size_t{1}}) CHECK_THAT(speed(actor, 0.25, 0.35), WithinAbs(10, 1e-9));
  CHECK_THAT(speed(0, 0.6, 0.7), WithinAbs(5, 1e-9));
  CHECK_THAT(speed(1, 0.6, 0.7), WithinAbs(10, 1e-9));
  CHECK_THAT(speed(1, 0.65, 0.75), WithinAbs(10, 1e-9));
  // One that is gone then goes on as it came to its end.
  for (const auto& [begin, end] : {std::pair(0.6, 0.7), std::pair(0.65, 0.75), std::pair(0.649, 0.749)})
    for (const double time : {begin, 0.7, end}) {
      CAPTURE(begin, time);
      CHECK_THAT(world.placementOf(1, begin, end, time).pose.position.x, WithinAbs(10 * (time - 0.25), 1e-9));
      CHECK_THAT(world.placementOf(1, begin, end, time).velocity.x, WithinAbs(10, 1e-9));
      CHECK(world.movesWithin(1, begin, end));
    }
  CHECK(speed(0, 0.1, 0.2) == 0);
  for (const double time : {0.1, 0.3, 0.5}) CHECK(speed(2, time, time) == 0);
}

TEST_CASE("an actor that is gone after a scan has points as fast as its box") {
  const DriveFolder folder;
  Json json = actorDrive();
  json["sensors"][0]["effects"] = {{"divergence", {{"use", "off"}}}};
  for (const double last : {0.345, 0.3}) {  // in the middle of the scan 3, and where it begins
    CAPTURE(last);
    json["actors"] = {car("leaves", {waypoint(0, -6, -7, 0.75), waypoint(last, -3, -7, 0.75)})};
    json["actors"][0]["outside"] = "gone";
    json["outputs"] = {{{"format", "npy"}, {"fields", "x,y,z,range,velocity,instance"}}, {{"format", "boxes"}}};
    const std::string out = "out" + std::to_string(static_cast<int>(1000 * last));
    folder.run(json, out);
    const Json box = boxesOf(folder, 3, out)["leaves"];
    CHECK_THAT(box["velocity"][0].get<double>(), WithinAbs(3 / last, 1e-6));
    const std::string bytes = folder.get(out + "/npy/top/000003.npy");
    constexpr size_t kStep = 8 * 4, kVelocity = 4 * 4, kInstance = 7 * 4;
    size_t points = 0;
    for (size_t row = 10 + at<uint16_t>(bytes, 8); row < bytes.size(); row += kStep) {
      if (at<uint32_t>(bytes, row + kInstance) != box["object"]) continue;
      ++points;
      CHECK_THAT(at<float>(bytes, row + kVelocity), WithinAbs(3 / last, 1e-3));
    }
    CHECK(points > 10);
    CHECK_FALSE(boxesOf(folder, 4, out).contains("leaves"));
  }
}

TEST_CASE("boxes fit the points of actors that turn, stop or leave within a scan") {
  const DriveFolder folder;
  Json json = actorDrive();
  json["sensors"][0]["effects"] = {{"divergence", {{"use", "off"}}}, {"sensor-motion", {{"deskew", true}}}};
  // At 0.345 s, in the middle of the scan 3.
  json["actors"] = {car("turns", {facing(waypoint(0, 5, -10, 0.75), 0), facing(waypoint(0.345, 5, -5, 0.75), 0),
                                  facing(waypoint(0.7, 0, -5, 0.75), 0)}),
                    car("stops", {waypoint(0, -12, 5, 0.75), waypoint(0.345, -3, 5, 0.75)}),
                    car("leaves", {waypoint(0, -12, -7, 0.75), waypoint(0.345, -3, -7, 0.75)})};
  json["actors"][2]["outside"] = "gone";
  folder.run(json);
  for (const int scan : {2, 3}) {
    INFO("scan " << scan);
    const std::map<std::string, Json> boxes = boxesOf(folder, scan);
    REQUIRE(boxes.size() == 3);
    for (const auto& [name, box] : boxes) {
      INFO(name);
      const auto q = box["sensor_frame"]["orientation"].get<std::array<double, 4>>();
      const Pose toBox = drive::inverse({vectorOf(box["sensor_frame"]["position"]), {q[0], q[1], q[2], q[3]}});
      uint64_t points = 0;
      for (const Row& row : rowsOf(folder.get("out/npy/top/00000" + std::to_string(scan) + ".npy"))) {
        if (row.instance != box["object"]) continue;
        ++points;
        // The actor moves on between its returns.
        const Vec3 drift = (row.time - box["time"].get<double>()) * vectorOf(box["velocity"]);
        const Vec3 inBox = drive::operator*(toBox, Vec3{row.x, row.y, row.z} - drift);
        CHECK(isIn(inBox, {4, 2, 1.5}, 0.05));
      }
      CHECK(points > 10);
    }
  }
}

TEST_CASE("nuScenes: the points of a sample lie in its boxes, although the vehicle drives") {
  const DriveFolder folder;
  Json json = actorDrive();
  json["duration"] = 0.3;
  json["epoch"] = 1700000000;
  json["ego"]["trajectory"]["waypoints"] = {facing(waypoint(0, 0, 0, 0), 0), facing(waypoint(1, 15, 0, 0), 60)};
  json["actors"] = {car("before", {waypoint(0, 10, -3, 0.75)}), car("behind", {facing(waypoint(0, -7, 2, 0.75), 30)}),
                    car("beside", {facing(waypoint(0, 2, 6, 0.75), 120)}),
                    car("passing", {waypoint(0, -3, -6, 0.75), waypoint(1, 7, -6, 0.75)})};
  for (const bool deskew : {false, true}) {
    INFO("deskew " << deskew);
    json["sensors"][0]["effects"] = {{"divergence", {{"use", "off"}}}, {"sensor-motion", {{"deskew", deskew}}}};
    json["outputs"] = {{{"format", "nuscenes"}, {"keyframes", 1}}};
    const std::string out = deskew ? "deskewed" : "fired";
    folder.run(json, out);
    const auto table = [&](const std::string& name) {
      return Json::parse(folder.get(out + "/nuscenes/v1.0-drive/" + name + ".json"));
    };
    const auto poseOf = [](const Json& row) {
      const auto q = row["rotation"].get<std::array<double, 4>>();
      return Pose{vectorOf(row["translation"]), {q[1], q[2], q[3], q[0]}};
    };
    std::map<std::string, Pose> vehicles;
    for (const Json& row : table("ego_pose")) vehicles[row["token"]] = poseOf(row);
    const Pose mount = poseOf(table("calibrated_sensor")[0]);
    size_t notes = 0;
    for (const Json& data : table("sample_data")) {
      const std::string points = folder.get(out + "/nuscenes/" + data["filename"].get<std::string>());
      const Pose sensor = drive::operator*(vehicles.at(data["ego_pose_token"]), mount);
      for (const Json& note : table("sample_annotation")) {
        if (note["sample_token"] != data["sample_token"]) continue;
        ++notes;
        const Pose toBox = drive::operator*(drive::inverse(poseOf(note)), sensor);
        const bool moving = note["attribute_tokens"][0] == table("attribute")[0]["token"];
        uint64_t inside = 0;
        for (size_t i = 0; i < points.size(); i += 20) {
          const Vec3 point = {at<float>(points, i), at<float>(points, i + 4), at<float>(points, i + 8)};
          inside += isIn(drive::operator*(toBox, point), {4, 2, 1.5}, moving ? 0.05 : 0.02);
        }
        const auto wanted = note["num_lidar_pts"].get<uint64_t>();
        CHECK(inside <= wanted);
        CHECK(static_cast<double>(inside) >= (moving ? 0.8 : 1) * static_cast<double>(wanted));
      }
    }
    CHECK(notes == 12);
    // Points that the format has compensated are where the simulator puts them.
    for (const Json& data : table("sample_data")) {
      const std::string file = "/nuscenes/" + data["filename"].get<std::string>();
      const std::string points = folder.get(out + file), fired = folder.get("fired" + file);
      REQUIRE(points.size() == fired.size());
      float most = 0;
      for (size_t i = 0; i < points.size(); i += 20)
        for (size_t k = i; k < i + 12; k += 4)
          most = std::max(most, std::abs(at<float>(points, k) - at<float>(fired, k)));
      CHECK(most < 1e-3);
    }
  }
}

TEST_CASE("instances of a scene whose classes have boxes are actors that stand") {
  const DriveFolder folder;
  // Two parked cars, of which the y axis of the file points up and z is the longer side, and a wall that is none.
  std::string parked = "# boxes 2 m wide, 1.5 m high and 4 m long\n";
  int vertices = 0;
  const auto box = [&](const std::string& name, double x, double z) {
    parked += "o " + name + "\n";
    for (const auto& [dx, dy, dz] : std::initializer_list<std::array<double, 3>>{
             {-1, 0, -2}, {1, 0, -2}, {1, 1.5, -2}, {-1, 1.5, -2}, {-1, 0, 2}, {1, 0, 2}, {1, 1.5, 2}, {-1, 1.5, 2}})
      parked += "v " + std::to_string(x + dx) + " " + std::to_string(dy) + " " + std::to_string(z + dz) + "\n";
    for (const auto& [a, b, c] : std::initializer_list<std::array<int, 3>>{{1, 3, 2},
                                                                           {1, 4, 3},
                                                                           {5, 6, 7},
                                                                           {5, 7, 8},
                                                                           {1, 2, 6},
                                                                           {1, 6, 5},
                                                                           {2, 3, 7},
                                                                           {2, 7, 6},
                                                                           {3, 4, 8},
                                                                           {3, 8, 7},
                                                                           {4, 1, 5},
                                                                           {4, 5, 8}})
      parked += "f " + std::to_string(vertices + a) + " " + std::to_string(vertices + b) + " " +
                std::to_string(vertices + c) + "\n";
    vertices += 8;
  };
  box("car 1", 5, -6);
  box("car 2", -5, -6);
  box("wall", 0, 8);
  put(folder / "parked.obj", parked);
  Json json = actorDrive();
  json["duration"] = 0.1;
  json["scenes"].push_back({{"file", "parked.obj"},
                            {"up", "y"},
                            {"pose", {{"yaw_pitch_roll_deg", {20, 0, 0}}}},
                            {"instances", {{"car*", "car"}, {"wall*", "ground"}}},
                            {"boxes", {"car", "person"}}});
  json["actors"] = {car("car 1", {waypoint(0, -8, -3, 0.75)})};
  json["outputs"].push_back({{"format", "semantickitti"}});
  folder.run(json);
  const std::map<std::string, Json> boxes = boxesOf(folder, 0);
  REQUIRE(boxes.size() == 3);
  const std::vector<Row> rows = rowsOf(folder.get("out/npy/top/000000.npy"));
  const std::string labels = folder.get("out/semantickitti/sequences/00/labels/000000.label");
  REQUIRE(labels.size() == 4 * rows.size());
  std::map<uint32_t, size_t> ofActor;
  for (size_t i = 0; i < rows.size(); ++i) {
    const auto label = at<uint32_t>(labels, 4 * i);
    CHECK((label & 0xffff) == (label >> 16 == 0 ? 40 : 10));
    ++ofActor[label >> 16];
  }
  CHECK(ofActor.size() == 4);
  for (const char* name : {"car 1 (2)", "car 2"}) {
    INFO(name);
    REQUIRE(boxes.contains(name));
    const Json& parkedBox = boxes.at(name);
    const Vec3 size = vectorOf(parkedBox["size"]), middle = vectorOf(parkedBox["world_frame"]["position"]);
    CHECK_THAT(size.x, WithinAbs(4, 1e-5));
    CHECK_THAT(size.y, WithinAbs(2, 1e-5));
    CHECK_THAT(size.z, WithinAbs(1.5, 1e-5));
    CHECK_THAT(middle.z, WithinAbs(0.75, 1e-5));
    CHECK(parkedBox["moving"] == false);
    const auto q = parkedBox["sensor_frame"]["orientation"].get<std::array<double, 4>>();
    const Pose toBox = drive::inverse({vectorOf(parkedBox["sensor_frame"]["position"]), {q[0], q[1], q[2], q[3]}});
    for (const Row& row : rows)
      if (row.instance == parkedBox["object"])
        CHECK(isIn(drive::operator*(toBox, Vec3{row.x, row.y, row.z}), size, 0.01));
  }
}

TEST_CASE("labels of SemanticKITTI lead to objects.json and classes.json") {
  const DriveFolder folder;
  Json json = smallDrive();
  json["outputs"].push_back({{"format", "semantickitti"}});
  json["scenes"].push_back({{"file", "floor.obj"}, {"pose", {{"position", {0, 0, -1}}}}});
  REQUIRE(folder.run(json).finished);
  std::map<uint32_t, Json> objects;  // by label
  for (const Json& object : Json::parse(folder.get("out/objects.json"))) {
    CHECK(object.contains("label") == object["actor"].get<bool>());
    if (object.contains("label")) CHECK(objects.emplace(object["label"].get<uint32_t>(), object).second);
  }
  CHECK(objects.size() == 2);
  const Json classes = Json::parse(folder.get("out/classes.json"));
  CHECK(classes.dump() == R"({"car":10,"ground":40,"person":30,"moving-car":252,"moving-person":254})");
  std::set<std::string> seen;
  for (int scan = 0; scan < 10; ++scan) {
    CAPTURE(scan);
    const std::vector<Row> rows = rowsOf(folder.get("out/npy/top/00000" + std::to_string(scan) + ".npy"));
    const std::string labels =
        folder.get("out/semantickitti/sequences/00/labels/00000" + std::to_string(scan) + ".label");
    REQUIRE(labels.size() == 4 * rows.size());
    for (size_t i = 0; i < rows.size(); ++i) {
      const uint32_t label = at<uint32_t>(labels, 4 * i), actor = label >> 16;
      if (actor == 0) continue;
      REQUIRE(objects.contains(actor));
      CHECK(objects[actor]["object"] == rows[i].instance);
      for (const auto& [name, id] : classes.items())
        if (id == (label & 0xffff)) seen.insert(name);
    }
  }
  CHECK(seen == std::set<std::string>{"moving-car", "person"});

  // A class that the drive file states keeps its number and its name.
  json["classes"] = {{"ground", {{"id", 40}}},
                     {"car", {{"id", 10}, {"moving_id", 252}}},
                     {"person", {{"id", 30}, {"moving_id", 254}}},
                     {"moving-car", {{"id", 7}}},
                     {"stroller", {{"id", 254}}}};
  json["duration"] = 0.1;
  folder.run(json, "own");
  CHECK(Json::parse(folder.get("own/classes.json")).dump() ==
        R"({"car":10,"ground":40,"moving-car":7,"person":30,"stroller":254})");
}

TEST_CASE("a run warns of sensors that have no scan in samples of nuScenes, and of boxes that no instance has") {
  const DriveFolder folder;
  Json json = quietDrive();
  json["outputs"] = {{{"format", "nuscenes"}, {"keyframes", 2}}};
  CHECK(folder.read(json).warnings.empty());  // the side has 5 scans a second from 0.05 s on
  json["outputs"][0]["keyframes"] = 1;
  json["scenes"][0]["boxes"] = {"person"};
  const std::vector<std::string> warnings = folder.read(json).warnings;
  REQUIRE(warnings.size() == 2);
  CHECK(warnings[0].starts_with("outputs[0]: 'side' starts no scan in 5 of 10 samples"));
  CHECK(warnings[1] == "scenes[0].boxes: no instance has any of these classes");
}

TEST_CASE("boxes fit the points of their actor in the frame of the scan, skewed and de-skewed") {
  for (const bool deskew : {false, true}) {
    INFO("deskew " << deskew);
    const DriveFolder folder;
    Json json = smallDrive();
    json["weather"] = Json::array();
    json["sensors"][0]["effects"] = {{"sensor-motion", {{"deskew", deskew}}}};
    // A wall of 1 m hides the lower part of the car.
    json["models"]["wall"] = {{"file", "cube.obj"}};
    json["actors"][2] = {{"name", "wall"},
                         {"model", "wall"},
                         {"class", "ground"},
                         {"size", {30, 0.2, 1}},
                         {"trajectory", {{"waypoints", {waypoint(0, 0, 1.5, 0.5)}}}}};
    json["outputs"][1] = {{"format", "boxes"}};
    folder.run(json);
    for (const std::string scan : {"top/000001", "top/000004"}) {
      INFO(scan);
      std::istringstream lines(folder.get("out/boxes/" + scan + ".jsonl"));
      std::map<std::string, Json> boxes;
      for (std::string line; std::getline(lines, line);) boxes[Json::parse(line)["name"]] = Json::parse(line);
      REQUIRE(boxes.contains("car-1"));
      const Json& car = boxes["car-1"];
      const auto p = car["sensor_frame"]["position"].get<std::array<double, 3>>();
      const auto q = car["sensor_frame"]["orientation"].get<std::array<double, 4>>();
      const Pose toBox = drive::inverse({{p[0], p[1], p[2]}, {q[0], q[1], q[2], q[3]}});
      uint64_t points = 0;
      std::vector<float> times;
      for (const Row& row : rowsOf(folder.get("out/npy/" + scan + ".npy"))) {
        if (row.instance != car["object"]) continue;
        ++points;
        times.push_back(row.time);
        const Vec3 inBox = drive::operator*(toBox, Vec3{row.x, row.y, row.z});
        // The sensor passes the car at up to 9 m/s; the beams that hit it are at most 0.02 s from their median.
        CHECK(std::abs(inBox.x) < 2 + 0.2);
        CHECK(std::abs(inBox.y) < 1 + 0.2);
        CHECK(std::abs(inBox.z) < 0.75 + 0.2);
      }
      CHECK(car["points"] == points);
      // The car is at x = 3 + 5 t, and the sensor at -2 + 4 t, or where the scan began if it is de-skewed.
      std::nth_element(times.begin(), times.begin() + times.size() / 2, times.end());
      const double begin = 0.1 * (scan.back() - '0'), after = times[times.size() / 2];
      CHECK_THAT(car["time"].get<double>(), WithinAbs(after, 1e-6));
      const double carX = 3 + 5 * (begin + after);
      CHECK_THAT(car["world_frame"]["position"][0].get<double>(), WithinAbs(carX, 1e-6));
      CHECK_THAT(p[0], WithinAbs(carX - (-2 + 4 * (begin + (deskew ? 0 : after))), 1e-6));
      CHECK(car["moving"] == true);
      CHECK_THAT(car["velocity"][0].get<double>(), WithinAbs(5, 1e-6));
      CHECK(car["size"] == Json::array({4.0, 2.0, 1.5}));
      CHECK(car["visibility"] > 0.1);
      CHECK(car["visibility"] < 0.9);
      CHECK(boxes["wall"]["visibility"] == 1.0);
      CHECK(boxes["wall"]["moving"] == false);
    }
  }
}
