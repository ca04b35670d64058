// SPDX-License-Identifier: Apache-2.0
// Tests of the traces of ASAM OSI. Traces are read with protozero, by the numbers that the .proto files of OSI 3.7.0
// give the fields.
#include <catch2/matchers/catch_matchers_floating_point.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <cstring>
#include <map>
#include <protozero/pbf_reader.hpp>
#include <tuple>

#include "drive_support.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::WithinAbs;
using protozero::pbf_reader;

namespace {

/// The only field of this number in a message; fails if there is none.
pbf_reader child(pbf_reader message, uint32_t tag) {
  REQUIRE(message.next(tag));
  return message.get_message();
}
double number(pbf_reader message, uint32_t tag) {
  REQUIRE(message.next(tag));
  return message.get_double();
}
uint64_t whole(pbf_reader message, uint32_t tag) {
  REQUIRE(message.next(tag));
  return message.get_uint64();
}
/// Seconds and nanoseconds of a Timestamp as nanoseconds.
int64_t timeOf(const pbf_reader& timestamp) {
  return static_cast<int64_t>(whole(timestamp, 1) * 1'000'000'000 + whole(timestamp, 2));
}

std::vector<std::string> messagesOf(const std::string& trace) {
  std::vector<std::string> messages;
  for (size_t at = 0; at < trace.size();) {
    uint32_t length = 0;
    REQUIRE(at + sizeof(length) <= trace.size());
    std::memcpy(&length, &trace[at], sizeof(length));
    REQUIRE(at + sizeof(length) + length <= trace.size());
    messages.push_back(trace.substr(at + sizeof(length), length));
    at += sizeof(length) + length;
  }
  return messages;
}

/// The small drive with the formats osi and kitti.
Json osiDrive() {
  Json json = smallDrive();
  json["sensors"][0]["effects"] = "auto";
  json["outputs"] = {{{"format", "osi"}}, {{"format", "kitti"}, {"sensors", {"top"}}}};
  json["epoch"] = 1700000000;
  return json;
}

Vec3 vectorOf(const pbf_reader& vector) {
  return {number(vector, 1), number(vector, 2), number(vector, 3)};
}

void checkVector(const Vec3& found, const Vec3& wanted) {
  CHECK_THAT(found.x, WithinAbs(wanted.x, 1e-6));
  CHECK_THAT(found.y, WithinAbs(wanted.y, 1e-6));
  CHECK_THAT(found.z, WithinAbs(wanted.z, 1e-6));
}

bool has(pbf_reader message, uint32_t tag) {
  return message.next(tag);
}

/// The stationary (4) or moving (5) objects of a GroundTruth by their numbers.
std::map<uint64_t, pbf_reader> objectsOf(pbf_reader truth, uint32_t tag) {
  std::map<uint64_t, pbf_reader> objects;
  while (truth.next(tag)) {
    const pbf_reader object = truth.get_message();
    CHECK(objects.emplace(whole(child(object, 1), 1), object).second);
  }
  return objects;
}

constexpr const char* kTruth = "out/osi/20231114T221320Z_gt_370_300_10_world.osi";

}  // namespace

TEST_CASE("OSI: SensorData with a lidar's header, mounting and detections, in a trace that is named for it") {
  const DriveFolder folder;
  Json json = osiDrive();
  json["weather"] = Json::array();
  REQUIRE(folder.run(json).finished);
  CHECK_FALSE(fs::exists(folder / "out/osi/parts"));
  const std::vector<std::string> side = messagesOf(folder.get("out/osi/20231114T221320Z_sd_370_300_5_side.osi")),
                                 top = messagesOf(folder.get("out/osi/20231114T221320Z_sd_370_300_10_top.osi"));
  REQUIRE(side.size() == 5);
  REQUIRE(top.size() == 10);

  const pbf_reader data(side[2]);  // at 0.05 s + 2 / 5 Hz
  CHECK((whole(child(data, 1), 1) == 3 && whole(child(data, 1), 2) == 7 && whole(child(data, 1), 3) == 0));
  const pbf_reader lidar = child(child(data, 26), 3), header = child(lidar, 1);
  CHECK(timeOf(child(header, 1)) == 1700000000'450000000);
  CHECK(whole(header, 2) == 2);
  CHECK(whole(header, 5) == 2);                               // DATA_QUALIFIER_AVAILABLE
  CHECK(timeOf(child(data, 9)) == timeOf(child(header, 1)));  // with the effects "clean" nothing moves within the scan
  const pbf_reader rolling(top[4]);
  CHECK(timeOf(child(rolling, 9)) == timeOf(child(rolling, 2)));
  CHECK(timeOf(child(rolling, 9)) == 1700000000'500000000);
  CHECK((timeOf(child(data, 2)) > timeOf(child(header, 1)) &&
         timeOf(child(data, 2)) <= timeOf(child(header, 1)) + 100'000'000));
  CHECK(whole(child(data, 5), 1) == 4);  // after the floor, the car and the person, the second sensor
  CHECK(whole(child(header, 7), 1) == 4);
  for (const pbf_reader& mounting : {child(data, 6), child(header, 3)}) {
    const pbf_reader position = child(mounting, 1), orientation = child(mounting, 2);
    CHECK((number(position, 1) == 1 && number(position, 2) == 0.5 && number(position, 3) == 1));
    CHECK_THAT(number(orientation, 1), WithinAbs(0, 1e-12));
    CHECK_THAT(number(orientation, 2), WithinAbs(10 * M_PI / 180, 1e-12));
    CHECK_THAT(number(orientation, 3), WithinAbs(M_PI / 2, 1e-12));
  }

  const std::string points = folder.get("out/kitti/sequences/00/velodyne/000004.bin");
  pbf_reader detections = child(child(pbf_reader(top[4]), 26), 3);
  CHECK(whole(child(detections, 1), 6) == points.size() / 16);
  std::map<uint64_t, int> objects;
  size_t count = 0;
  for (; detections.next(2); ++count) {
    REQUIRE(16 * (count + 1) <= points.size());
    float row[4];
    std::memcpy(row, &points[16 * count], sizeof(row));
    const pbf_reader detection = detections.get_message(), at = child(detection, 3);
    const double distance = number(at, 1), azimuth = number(at, 2), elevation = number(at, 3);
    CHECK_THAT(distance * std::cos(elevation) * std::cos(azimuth), WithinAbs(row[0], 1e-6));
    CHECK_THAT(distance * std::cos(elevation) * std::sin(azimuth), WithinAbs(row[1], 1e-6));
    CHECK_THAT(distance * std::sin(elevation), WithinAbs(row[2], 1e-6));
    CHECK_THAT(number(detection, 7), WithinAbs(100 * row[3], 1e-4));
    ++objects[whole(child(detection, 2), 1)];
    CHECK_FALSE(pbf_reader(detection).next(9));
    CHECK((whole(child(detection, 2), 1) == 0) == (row[2] < -1.79));  // the floor is object 0
  }
  CHECK(count == points.size() / 16);
  CHECK((objects.size() == 3 && objects.contains(1) && objects.contains(2)));
}

TEST_CASE("OSI: drops of rain are clutter that belongs to no object") {
  const DriveFolder folder;
  Json json = osiDrive();
  json["weather"] = {{{"time", 0}, {"rain", 80}}};
  folder.run(json);
  int drops = 0, surfaces = 0;
  for (const std::string& message : messagesOf(folder.get("out/osi/20231114T221320Z_sd_370_300_10_top.osi"))) {
    pbf_reader detections = child(child(pbf_reader(message), 26), 3);
    while (detections.next(2)) {
      const pbf_reader detection = detections.get_message();
      const bool isDrop = whole(child(detection, 2), 1) == UINT64_MAX;
      ++(isDrop ? drops : surfaces);
      pbf_reader classification = detection;
      CHECK(classification.next(9) == isDrop);
      if (isDrop) CHECK(classification.get_enum() == 3);  // DETECTION_CLASSIFICATION_CLUTTER
    }
  }
  CHECK(drops > 0);
  CHECK(surfaces > 3000);
}

TEST_CASE("OSI: GroundTruth of every frame has the vehicle and the actors that are there") {
  const DriveFolder folder;
  Json json = osiDrive();
  json["classes"]["cone"] = {{"id", 70}};
  json["actors"].push_back(
      {{"name", "cone-1"},
       {"model", "cube"},
       {"class", "cone"},
       {"trajectory", {{"waypoints", {{{"time", 0}, {"position", {6, 0, 0.5}}, {"yaw_deg", 30}}}}}}});
  json["outputs"][0]["sensors"] = {"side"};  // it starts no scan in half of the frames
  REQUIRE(folder.run(json).finished);
  CHECK_FALSE(fs::exists(folder / "out/osi/parts"));
  const std::vector<std::string> truths = messagesOf(folder.get(kTruth));
  REQUIRE(truths.size() == 10);
  for (size_t n = 0; n < truths.size(); ++n) {
    INFO("frame " << n);
    const pbf_reader truth(truths[n]);
    const double t = 0.1 * static_cast<double>(n);
    CHECK((whole(child(truth, 1), 1) == 3 && whole(child(truth, 1), 2) == 7));
    CHECK(timeOf(child(truth, 2)) == 1700000000'000000000 + static_cast<int64_t>(n) * 100'000'000);
    // Objects are 0 to 3: the floor and the three actors; 4 and 5 are the sensors, and 6 the vehicle.
    CHECK(whole(child(truth, 3), 1) == 6);
    const auto moving = objectsOf(truth, 5), standing = objectsOf(truth, 4);
    const bool personIsThere = n >= 3 && n <= 6;  // from 0.25 to 0.65 s
    REQUIRE(moving.size() == (personIsThere ? 3 : 2));

    const pbf_reader &vehicle = moving.at(6), base = child(vehicle, 2);
    CHECK_FALSE(has(base, 1));
    checkVector(vectorOf(child(base, 2)), {-2 + 4 * t, 0, 0});
    checkVector(vectorOf(child(base, 4)), {4, 0, 0});
    CHECK(whole(vehicle, 3) == 2);                           // TYPE_VEHICLE
    checkVector(vectorOf(child(child(vehicle, 5), 4)), {});  // bbcenter_to_rear

    const pbf_reader &car = moving.at(1), carBase = child(car, 2);
    checkVector(vectorOf(child(carBase, 1)), {4, 2, 1.5});
    checkVector(vectorOf(child(carBase, 2)), {3 + 5 * t, 3, 0.75});
    checkVector(vectorOf(child(carBase, 3)), {});
    checkVector(vectorOf(child(carBase, 4)), {5, 0, 0});
    checkVector(vectorOf(child(carBase, 5)), {});
    CHECK(whole(car, 3) == 2);
    CHECK((has(car, 5) && whole(child(car, 6), 1) == 4));  // TYPE_CAR

    if (personIsThere) {
      const pbf_reader &person = moving.at(2), personBase = child(person, 2);
      checkVector(vectorOf(child(personBase, 1)), {0.6, 0.8, 1.8});
      checkVector(vectorOf(child(personBase, 2)), {1, -3, 0.9});
      checkVector(vectorOf(child(personBase, 4)), {});
      CHECK((whole(person, 3) == 3 && has(person, 12) && !has(person, 6)));  // TYPE_PEDESTRIAN
    }
    REQUIRE(standing.size() == 1);
    const pbf_reader &cone = standing.at(3), coneBase = child(cone, 2);
    checkVector(vectorOf(child(coneBase, 1)), {1, 1, 1});
    checkVector(vectorOf(child(coneBase, 2)), {6, 0, 0.5});
    CHECK_THAT(number(child(coneBase, 3), 3), WithinAbs(M_PI / 6, 1e-9));
    CHECK(whole(child(cone, 3), 1) == 1);  // TYPE_OTHER
  }
}

TEST_CASE("OSI: the vehicle of GroundTruth is the actor that goes with the ego, if there is one") {
  const DriveFolder folder;
  Json json = osiDrive();
  // The vehicle accelerates along y with 2 m/s^2, and the middle of its body is 0.4 m before and 0.6 m above its
  // origin.
  Json way = Json::array(), above = Json::array(), behind = Json::array();
  for (const double t : {0.0, 0.5, 1.0}) {
    way.push_back(waypoint(t, 0, t * t, 0));
    above.push_back(waypoint(t, 0, t * t, 0.6));
    behind.push_back(waypoint(t, 0, t * t - 8, 0.6));
  }
  json["ego"]["trajectory"] = {{"waypoints", way}};
  json["models"]["body"] = {{"file", "cube.obj"}, {"pose", {{"position", {0.4, 0, 0}}}}};
  json["actors"] = {
      {{"name", "follower"}, {"model", "body"}, {"class", "car"}, {"trajectory", {{"waypoints", behind}}}},
      {{"name", "body"}, {"model", "body"}, {"class", "person"}, {"trajectory", {{"waypoints", above}}}}};
  for (Json& sensor : json["sensors"]) sensor["ignores"] = {"body"};
  REQUIRE(folder.run(json).finished);
  const std::vector<std::string> truths = messagesOf(folder.get(kTruth));
  REQUIRE(truths.size() == 10);
  const pbf_reader truth(truths[2]);  // at 0.2 s, between the first stamps
  CHECK(whole(child(truth, 3), 1) == 2);
  const auto moving = objectsOf(truth, 5);
  REQUIRE(moving.size() == 2);
  const pbf_reader &body = moving.at(2), base = child(body, 2);
  checkVector(vectorOf(child(base, 1)), {1, 1, 1});
  checkVector(vectorOf(child(base, 2)), {0, 0.1 + 0.4, 0.6});
  CHECK_THAT(number(child(base, 3), 3), WithinAbs(M_PI / 2, 1e-9));
  checkVector(vectorOf(child(base, 4)), {0, 0.5, 0});
  checkVector(vectorOf(child(base, 5)), {0, 2, 0});
  CHECK(whole(body, 3) == 2);  // whatever its class
  checkVector(vectorOf(child(child(body, 5), 4)), {-0.4, 0, -0.6});

  // An actor who is not there all the time is not the body.
  json["actors"][1]["outside"] = "gone";
  REQUIRE(folder.run(json, "gone").finished);
  const std::string gone = folder.get("gone/" + std::string(kTruth).substr(4));
  CHECK(whole(child(pbf_reader(messagesOf(gone)[2]), 3), 1) == 5);  // after two objects and two sensors
}

TEST_CASE("OSI: something around a vehicle that stands is the vehicle only if it is one") {
  for (const std::string kind : {"person", "car"}) {
    const DriveFolder folder;
    Json json = osiDrive();
    json["duration"] = 0.2;
    json["ego"]["trajectory"] = {{"waypoints", Json::array({waypoint(0, 0, 0, 0)})}};
    json["actors"] = {{{"name", "around"},
                       {"model", "cube"},
                       {"class", kind},
                       {"trajectory", {{"waypoints", Json::array({waypoint(0, 0, 0, 0)})}}}}};
    for (Json& sensor : json["sensors"]) sensor["ignores"] = {"around"};
    REQUIRE(folder.run(json).finished);
    const std::string trace = folder.get("out/osi/20231114T221320Z_gt_370_300_2_world.osi");
    CHECK(whole(child(pbf_reader(messagesOf(trace)[0]), 3), 1) == (kind == "car" ? 1 : 4));
  }
}

TEST_CASE("OSI: radial velocities are positive towards the sensor, if the output asks for them") {
  const DriveFolder folder;
  Json json = osiDrive();
  json["weather"] = Json::array();
  json["outputs"] = {{{"format", "osi"}, {"sensors", {"top"}}, {"fields", "radial_speed"}}};
  folder.run(json);
  const std::vector<std::string> top = messagesOf(folder.get("out/osi/20231114T221320Z_sd_370_300_10_top.osi"));
  REQUIRE(top.size() == 10);
  pbf_reader detections = child(child(pbf_reader(top[4]), 26), 3);
  size_t ground = 0, car = 0;
  while (detections.next(2)) {
    const pbf_reader detection = detections.get_message(), at = child(detection, 3);
    // The sensor drives along x with 4 m/s towards what stands, and 1 m/s slower than the car.
    const double ahead = std::cos(number(at, 3)) * std::cos(number(at, 2));
    const uint64_t object = whole(child(detection, 2), 1);
    if (object == 0) CHECK_THAT(number(detection, 12), WithinAbs(4 * ahead, 0.02));
    if (object == 1) CHECK_THAT(number(detection, 12), WithinAbs(-ahead, 0.02));
    ground += object == 0 ? 1 : 0;
    car += object == 1 ? 1 : 0;
  }
  CHECK((ground > 100 && car > 0));
  // Another output that asks for them changes no trace.
  const DriveFolder plain;
  json["outputs"] = {{{"format", "osi"}, {"sensors", {"top"}}},
                     {{"format", "pcd"}, {"sensors", {"top"}}, {"fields", "x,y,z,radial_speed"}}};
  plain.run(json);
  const std::string trace = plain.get("out/osi/20231114T221320Z_sd_370_300_10_top.osi");
  const std::string message = messagesOf(trace)[4];
  detections = child(child(pbf_reader(message), 26), 3);
  REQUIRE(detections.next(2));
  CHECK_FALSE(has(detections.get_message(), 12));
  json["outputs"][0]["fields"] = "radial_speed,width";
  CHECK_THROWS_WITH(folder.read(json),
                    ContainsSubstring("outputs[0].fields: OSI's detections have no place for width; beside what they "
                                      "always have they take radial_speed"));
}

TEST_CASE("OSI has no times below 0") {
  const DriveFolder folder;
  Json json = osiDrive();
  json["epoch"] = 0;
  json["start"] = -0.5;
  CHECK_THROWS_WITH(
      folder.read(json),
      ContainsSubstring("outputs[0].format: OSI has no times below 0; the drive begins at -0.5 s: give an "
                        "epoch"));
  json["epoch"] = 0.5;
  CHECK_NOTHROW(folder.read(json));
}

TEST_CASE("OSI: the name of a class tells what an object is, and a parked vehicle is a moving object") {
  const DriveFolder folder;
  Json json = osiDrive();
  json["duration"] = 0.1;
  json["actors"] = Json::array();
  // A class, its MovingObject.Type and its VehicleClassification.Type.
  const std::vector<std::tuple<const char*, uint64_t, uint64_t>> kinds = {
      {"Van", 2, 1},         {"vehicle.truck", 2, 7},          {"bicycle", 2, 11}, {"BUS", 2, 12},
      {"vehicle.car", 2, 4}, {"human.pedestrian.adult", 3, 0}, {"animal", 4, 0},   {"bicycle rack", 0, 0}};
  for (const auto& [name, type, vehicle] : kinds) {
    json["classes"][name] = {{"id", 100}};
    json["actors"].push_back({{"name", name},
                              {"model", "cube"},
                              {"class", name},
                              {"trajectory", {{"waypoints", {waypoint(0, 5, 5, 0.5)}}}}});
  }
  folder.run(json);
  const std::string truth = messagesOf(folder.get("out/osi/20231114T221320Z_gt_370_300_1_world.osi")).at(0);
  const auto moving = objectsOf(pbf_reader(truth), 5), standing = objectsOf(pbf_reader(truth), 4);
  CHECK((moving.size() == kinds.size() && standing.size() == 1));  // the vehicle itself is moving, too
  for (size_t i = 0; i < kinds.size(); ++i) {
    const auto& [name, type, vehicle] = kinds[i];
    INFO(name);
    if (type == 0) {
      CHECK(standing.contains(i + 1));  // behind the floor
      continue;
    }
    const pbf_reader& object = moving.at(i + 1);
    CHECK(whole(object, 3) == type);
    CHECK(has(object, 6) == (type == 2));
    if (type == 2) CHECK(whole(child(object, 6), 1) == vehicle);
  }
}
