// SPDX-License-Identifier: Apache-2.0
// Tests the bags of ROS 2: messages of laser scans and of the inertial unit.
#include <algorithm>
#include <catch2/matchers/catch_matchers_floating_point.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>

#include "base/vector.hpp"
#include "bits.hpp"
#include "drive/formats/cdr.hpp"
#include "drive/pose_math.hpp"
#include "drive/ros.hpp"
#include "drive_support.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::WithinAbs;

namespace {

/// Returns the messages of a channel of an MCAP file, in their order in the chunks.
std::vector<std::string> messagesOf(const std::string& mcap, uint16_t channel, std::vector<int64_t>* times = nullptr) {
  std::vector<std::string> messages;
  for (size_t chunk = 8; chunk < mcap.size() - 8; chunk += 9 + at<uint64_t>(mcap, chunk + 1)) {
    if (at<uint8_t>(mcap, chunk) != 6) continue;
    const size_t end = chunk + 9 + at<uint64_t>(mcap, chunk + 1);
    for (size_t p = chunk + 9 + 8 + 8 + 8 + 4 + 4 + 8; p < end; p += 9 + at<uint64_t>(mcap, p + 1)) {
      if (at<uint16_t>(mcap, p + 9) != channel) continue;
      CHECK(at<uint32_t>(mcap, p + 11) == messages.size());
      if (times) times->push_back(at<int64_t>(mcap, p + 15));
      messages.push_back(mcap.substr(p + 31, at<uint64_t>(mcap, p + 1) - 22));
    }
  }
  return messages;
}

/// A drive whose vehicle goes along a curve that changes its direction and its speed, with a stamp every 20 ms.
Json curvedDrive() {
  Json json = smallDrive(), waypoints = Json::array();
  for (int i = 0; i <= 50; ++i) {
    const double t = 0.02 * i, yaw = 0.8 * std::sin(2 * t);
    Json point = waypoint(t, 5 * t + 2 * std::sin(3 * t), std::cos(2 * t), 0.3 * std::sin(5 * t));
    point["orientation"] = {0.1 * std::sin(4 * t) / 2, 0, std::sin(yaw / 2), std::cos(yaw / 2)};
    waypoints.push_back(std::move(point));
  }
  json["ego"]["trajectory"]["waypoints"] = std::move(waypoints);
  json["imu"] = {{"mount", {{"position", {1, 0.5, 2}}, {"yaw_pitch_roll_deg", {90, 0, 180}}}}, {"rate", 400}};
  return json;
}

}  // namespace

TEST_CASE("an inertial unit beside the middle of a turning vehicle goes on a circle of its own") {
  constexpr double kTurnRate = 0.5;
  std::vector<drive::Trajectory::Stamp> stamps;
  for (int i = 0; i <= 200; ++i) {  // turns on the spot
    const double half = kTurnRate * 0.01 * i / 2;
    stamps.push_back({0.01 * i, {{3, 4, 5}, {0, 0, std::sin(half), std::cos(half)}}});
  }
  const drive::Trajectory turning(std::move(stamps));
  const Pose mount = {{2, 0, 1}, {1, 0, 0, 0}};  // upside down
  const drive::Trajectory::Rates rates = turning.ratesAt(1, mount);
  const double angle = kTurnRate * 1;
  CHECK_THAT(rates.velocity.x, WithinAbs(-2 * kTurnRate * std::sin(angle), 1e-3));
  CHECK_THAT(rates.velocity.y, WithinAbs(2 * kTurnRate * std::cos(angle), 1e-3));
  CHECK_THAT(rates.acceleration.x, WithinAbs(-2 * kTurnRate * kTurnRate * std::cos(angle), 1e-2));
  CHECK_THAT(rates.acceleration.y, WithinAbs(-2 * kTurnRate * kTurnRate * std::sin(angle), 1e-2));
  CHECK_THAT(rates.turnRate.z, WithinAbs(-kTurnRate, 1e-9));
}

TEST_CASE("the measurements of a drive's inertial unit, integrated, lead along its way") {
  const DriveFolder folder;
  const drive::Drive drive = folder.read(curvedDrive());
  using drive::operator*;
  const Pose& mount = drive.imu->mount;
  Pose pose = drive.ego.at(0) * mount;
  Vec3 velocity = drive.ego.ratesAt(0, mount).velocity;
  double furthest = 0, mostTurned = 0;
  constexpr double kStep = 1 / 400.0;
  for (uint64_t frame = 0; frame < drive.frameCount(); ++frame)
    for (const double time : drive::imuTimes(drive, frame, false)) {
      const ros2::Imu imu = drive::imuMessage(drive, time + kStep / 2);  // in the middle of the step
      const Vec3 half = 0.5 * kStep * imu.angularVelocity;
      const Quaternion turn = normalized(Quaternion{half.x, half.y, half.z, 1});
      const Vec3 acceleration = pose.orientation * imu.linearAcceleration - Vec3{0, 0, 9.80665};
      pose.position = pose.position + kStep * velocity + 0.5 * kStep * kStep * acceleration;
      velocity = velocity + kStep * acceleration;
      pose.orientation = normalized(pose.orientation * turn);
      const Pose truth = drive.ego.at(time + kStep) * mount;
      furthest = std::max(furthest, lengthOf(pose.position - truth.position));
      mostTurned = std::max(mostTurned, drive::angleBetween(pose.orientation, truth.orientation));
    }
  CHECK(furthest < 0.05);
  CHECK(mostTurned < 0.01);
}

TEST_CASE("the odometry of a drive, integrated, leads along the way of its vehicle") {
  const DriveFolder folder;
  const drive::Drive drive = folder.read(curvedDrive());
  using drive::operator*;
  Pose pose = drive.ego.at(0);
  double furthest = 0, mostTurned = 0;
  constexpr double kStep = 1 / 400.0;
  for (int i = 0; i < 400; ++i) {
    const ros2::Odometry odometry = drive::odometryMessage(drive, (i + 0.5) * kStep);  // in the middle of the step
    CHECK(odometry.frame == "map");
    CHECK(odometry.childFrame == "base_link");
    CHECK(lengthOf(odometry.pose.position - drive.ego.at((i + 0.5) * kStep).position) == 0);
    const Vec3 half = 0.5 * kStep * odometry.angularVelocity;
    const Quaternion turn = normalized(Quaternion{half.x, half.y, half.z, 1});
    pose.position = pose.position + kStep * (pose.orientation * odometry.linearVelocity);
    pose.orientation = normalized(pose.orientation * turn);
    const Pose truth = drive.ego.at((i + 1) * kStep);
    furthest = std::max(furthest, lengthOf(pose.position - truth.position));
    mostTurned = std::max(mostTurned, drive::angleBetween(pose.orientation, truth.orientation));
  }
  CHECK(furthest < 0.05);
  CHECK(mostTurned < 0.01);
}

TEST_CASE("MCAP: the odometry of the vehicle beside its transforms") {
  const DriveFolder folder;
  Json json = smallDrive();
  json["epoch"] = 1700000000;
  json["frames"] = {{"world", "odom"}};
  json["outputs"] = {{{"format", "mcap"}}};
  folder.run(json);
  const std::string mcap = folder.get("out/mcap/drive.mcap"), text = folder.get("out/mcap/metadata.yaml");
  CHECK_THAT(text, ContainsSubstring("name: /odom\n        type: nav_msgs/msg/Odometry\n"));
  std::vector<int64_t> times;
  const std::vector<std::string> messages = messagesOf(mcap, 5, &times);  // after the transforms and two sensors
  REQUIRE(messages.size() == 101);
  CHECK(times[50] == 1700000000500000000);
  const std::string& cdr = messages[50];
  CHECK(cdr.substr(16, 5) == std::string("odom\0", 5));
  CHECK(cdr.substr(28, 10) == std::string("base_link\0", 10));
  const size_t numbers = 4 + 40;  // the next multiple of 8 after the names, from the end of the head of CDR
  REQUIRE(cdr.size() == numbers + (7 + 36 + 6 + 36) * 8);
  CHECK(at<double>(cdr, numbers) == 0);                                     // halfway from x = -2 to 2
  CHECK(at<double>(cdr, numbers + 8 * 6) == 1);                             // of the orientation
  CHECK_THAT(at<double>(cdr, numbers + 8 * (7 + 36)), WithinAbs(4, 1e-9));  // m/s forward
}

TEST_CASE("MCAP: clouds have the fields that their output names, with the values of other formats") {
  const DriveFolder folder;
  Json json = smallDrive();
  json["epoch"] = 1700000000;
  json["weather"] = Json::array();
  json["sensors"] = {json["sensors"][0]};
  const char* names = "x,y,z,radial_speed,velocity,ring";
  json["outputs"] = {{{"format", "mcap"}, {"fields", names}}, {{"format", "pcd"}, {"fields", names}}};
  folder.run(json);
  const std::vector<std::string> clouds = messagesOf(folder.get("out/mcap/drive.mcap"), 3);
  REQUIRE(clouds.size() == 10);
  const std::string& cdr = clouds[3];
  CHECK(cdr.substr(16, 4) == std::string("top\0", 4));
  const auto points = at<uint32_t>(cdr, 24);
  REQUIRE(points > 300);
  REQUIRE(at<uint32_t>(cdr, 28) == 8);  // fields
  struct Field {
    const char* name;
    uint32_t offset;
    uint8_t type;
  };
  constexpr uint8_t kU16 = 4, kF32 = 7;  // of sensor_msgs/PointField
  constexpr uint32_t kStep = 30;
  size_t place = 32;
  for (const Field& field : {Field{"x", 0, kF32},
                             {"y", 4, kF32},
                             {"z", 8, kF32},
                             {"radial_speed", 12, kF32},
                             {"velocity_x", 16, kF32},
                             {"velocity_y", 20, kF32},
                             {"velocity_z", 24, kF32},
                             {"ring", 28, kU16}}) {
    CAPTURE(field.name);
    const auto length = at<uint32_t>(cdr, place);
    CHECK(cdr.substr(place + 4, length) == std::string(field.name) + '\0');
    place += (4 + length + 3) / 4 * 4;
    CHECK(at<uint32_t>(cdr, place) == field.offset);
    CHECK(at<uint8_t>(cdr, place + 4) == field.type);
    CHECK(at<uint32_t>(cdr, place + 8) == 1);
    place += 12;
  }
  CHECK(at<uint32_t>(cdr, place + 4) == kStep);
  const std::string data = cdr.substr(place + 16, kStep * points), pcd = folder.get("out/pcd/top/000003.pcd");
  CHECK(pcd.substr(pcd.size() - data.size()) == data);
  double fastest = 0;
  for (size_t point = 0; point < data.size(); point += kStep)
    fastest = std::max(fastest, std::abs(double{at<float>(data, point + 12)}));
  CHECK(fastest > 1);
}

TEST_CASE("MCAP: clouds of a list have the numbers of its beams, by which they go back into their grid") {
  const DriveFolder folder;
  Json json = smallDrive();
  json["epoch"] = 1700000000;
  json["outputs"] = {{{"format", "mcap"}}};
  const std::vector<Field> usual = parseFields("x,y,z,intensity,time,ring,class,instance");
  const drive::Drive grids = folder.read(json);
  CHECK(grids.outputs[0].fields == usual);
  CHECK(drive::liveFieldsOf(grids, 1) == usual);

  // Four rows of eight, of which the upper two see nothing.
  Json& list = json["sensors"][1]["sensor"];
  list = {{"name", "zones"}, {"range", {{"max", 60}}}};
  Json& pattern = list["patterns"][0] = {{"width", 8}, {"height", 4}};
  for (int i = 0; i < 32; ++i) {
    pattern["azimuth_deg"].push_back(20 - 5 * (i % 8));
    pattern["elevation_deg"].push_back(i < 16 ? 60 : -20);
  }
  std::vector<Field> numbered = usual;
  numbered.push_back(Field::beam);
  const drive::Drive lists = folder.read(json);
  CHECK(lists.outputs[0].fields == numbered);
  CHECK(drive::liveFieldsOf(lists, 0) == numbered);  // as the bag has both sensors
  json["sensors"][1]["driver"] = "livox";
  CHECK(folder.read(json).outputs[0].fields == usual);
  json["sensors"][1].erase("driver");
  json["outputs"][0]["sensors"] = {"top"};
  const drive::Drive without = folder.read(json);
  CHECK(without.outputs[0].fields == usual);
  CHECK(drive::liveFieldsOf(without, 0) == usual);
  CHECK(drive::liveFieldsOf(without, 1) == numbered);

  json["outputs"][0]["sensors"] = {"side"};
  folder.run(json);
  const std::string cdr = messagesOf(folder.get("out/mcap/drive.mcap"), 3).at(0);
  const size_t beam = cdr.find(std::string("beam\0", 5));
  REQUIRE(beam != std::string::npos);
  const auto offset = at<uint32_t>(cdr, beam + 8);
  const size_t ends = beam + 8 + 12;  // its offset, type and count, then whether the data is big-endian
  const auto step = at<uint32_t>(cdr, ends + 4), bytes = at<uint32_t>(cdr, ends + 12);
  REQUIRE(bytes == 16 * step);
  for (uint32_t i = 0; i < 16; ++i) CHECK(at<uint32_t>(cdr, ends + 16 + i * step + offset) == 16 + i);
}

TEST_CASE("MCAP: fields without a position, or of a sensor with a driver, are refused") {
  const DriveFolder folder;
  Json json = smallDrive();
  json["epoch"] = 1700000000;
  json["outputs"] = {{{"format", "mcap"}, {"fields", "radial_speed"}}};
  CHECK_THROWS_WITH(folder.read(json), ContainsSubstring("outputs[0].fields: must have x, y and z, without which "
                                                         "nothing shows a cloud; by default they are "
                                                         "x,y,z,intensity,time,ring,class,instance"));
  json["outputs"][0]["fields"] = "x,y,z,radial_speed";
  for (const char* driver : {"ouster", "livox-custom"}) {
    json["sensors"][1]["driver"] = driver;
    CHECK_THROWS_WITH(folder.read(json),
                      ContainsSubstring("outputs[0].fields: are not for 'side', whose clouds have the fields of its "
                                        "driver; leave out its 'driver', or name the other sensors in 'sensors'"));
  }
  json["outputs"][0]["sensors"] = {"top"};
  const drive::Drive drive = folder.read(json);
  CHECK(drive::liveFieldsOf(drive, 0) == std::vector<Field>{Field::x, Field::y, Field::z, Field::radialSpeed});
  CHECK(drive::liveFieldsOf(drive, 1).size() == 8);
}

TEST_CASE("MCAP: a flat sensor has laser scans beside its clouds") {
  const DriveFolder folder;
  Json json = smallDrive();
  json["epoch"] = 1700000000;
  json["sensors"][1]["sensor"]["elevation_deg"] = {0};
  json["sensors"][1]["effects"] = {{"drop-out", {{"general_rate", 0.3}}}};
  json["outputs"] = {{{"format", "mcap"}}};
  folder.run(json);
  const std::string mcap = folder.get("out/mcap/drive.mcap"), text = folder.get("out/mcap/metadata.yaml");
  CHECK_THAT(text, ContainsSubstring("name: /side/scan\n        type: sensor_msgs/msg/LaserScan\n") &&
                       !ContainsSubstring("/top/scan"));
  const std::vector<std::string> scans = messagesOf(mcap, 5), clouds = messagesOf(mcap, 4);
  REQUIRE(scans.size() == 5);
  const std::string counted = text.substr(text.find("message_count: ", text.find("name: /side/scan")));
  CHECK(counted.starts_with("message_count: 5\n"));
  REQUIRE(clouds.size() == 5);
  const std::string& cdr = scans[2];
  CHECK(at<int32_t>(cdr, 4) == 1700000000);
  CHECK(at<uint32_t>(cdr, 8) == 450000000);
  CHECK(cdr.substr(16, 5) == std::string("side\0", 5));
  CHECK_THAT(at<float>(cdr, 24), WithinAbs(-M_PI, 1e-6));
  CHECK_THAT(at<float>(cdr, 24 + 4 * 2), WithinAbs(2 * M_PI / 90, 1e-6));
  CHECK_THAT(at<float>(cdr, 24 + 4 * 4), WithinAbs(0.2, 1e-6));  // 5 scans a second
  REQUIRE(at<uint32_t>(cdr, 24 + 4 * 7) == 90);
  size_t returned = 0, lost = 0;
  for (size_t i = 0; i < 90; ++i) {
    const float range = at<float>(cdr, 24 + 4 * (8 + i));
    returned += std::isfinite(range);
    lost += std::isnan(range);
  }
  CHECK(lost > 0);  // at random, so nobody knows whether the way is free
  CHECK(returned + lost < 90);
  CHECK(returned == at<uint32_t>(clouds[2], 28));  // the width of the cloud
  CHECK(returned > 0);
}

TEST_CASE("MCAP: the messages of an inertial unit, as many as the metadata say") {
  const DriveFolder folder;
  Json json = curvedDrive();
  json["epoch"] = 1700000000;
  json["imu"]["name"] = "imu-1";
  json["imu"]["rate"] = 200.5;
  json["outputs"] = {{{"format", "mcap"}}};
  folder.run(json);
  const drive::Drive drive = folder.read(json);
  const std::string mcap = folder.get("out/mcap/drive.mcap"), text = folder.get("out/mcap/metadata.yaml");
  CHECK_THAT(text, ContainsSubstring("name: /imu_1/data\n        type: sensor_msgs/msg/Imu\n"));
  std::vector<int64_t> times;
  const std::vector<std::string> messages = messagesOf(mcap, 5, &times);  // after the transforms and two sensors
  REQUIRE(messages.size() == 202);  // for a second, and the one behind the end of the last scan
  CHECK_THAT(text, ContainsSubstring("message_count: 202"));
  CHECK(std::is_sorted(times.begin(), times.end()));
  CHECK(times[0] == 1700000000000000000);
  CHECK(std::abs(times[201] - 1700000001002493765) < 1000);
  CHECK_THAT(text, ContainsSubstring("  duration:\n    nanoseconds: " + std::to_string(times[201] - times[0]) + "\n"));
  const ros2::Imu wanted = drive::imuMessage(drive, 100 / 200.5);
  const std::string& cdr = messages[100];
  CHECK(cdr.substr(16, 6) == std::string("imu-1\0", 6));
  const size_t numbers = 4 + 24;  // the next multiple of 8 after the name, from the end of the head of CDR
  REQUIRE(cdr.size() == numbers + 37 * 8);
  CHECK(at<double>(cdr, numbers + 8 * 3) == wanted.orientation.w);
  CHECK(at<double>(cdr, numbers + 8 * (4 + 9)) == wanted.angularVelocity.x);
  CHECK(at<double>(cdr, numbers + 8 * (4 + 9 + 3 + 9 + 2)) == wanted.linearAcceleration.z);
}

TEST_CASE("the size of a list in a message is refused rather than cut to 32 bits") {
  CHECK(drive::cdrSize(UINT32_MAX) == UINT32_MAX);
  CHECK_THROWS_WITH(drive::cdrSize(uint64_t{1} << 32),
                    ContainsSubstring("a list of 4294967296 bytes does not fit into a message of ROS 2"));
}
