// SPDX-License-Identifier: Apache-2.0
// Tests of messages that arrive at a subscriber, and of harm that a subscriber can do to a publisher.
#include <gnosphere_ros2.h>

#include <algorithm>
#include <catch2/catch_approx.hpp>
#include <catch2/matchers/catch_matchers_exception.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <cstring>
#include <gnosphere/ros2.hpp>

#include "columns.hpp"
#include "gnosphere/gnosphere.hpp"
#include "no_more_threads.hpp"
#include "ros2/listening.hpp"

using namespace gnosphere;
using namespace gnosphere::ros2;
using namespace gnosphere::test;
using Catch::Approx;
using Catch::Matchers::ContainsSubstring, Catch::Matchers::MessageMatches, Catch::Matchers::StartsWith;
using Time = std::chrono::steady_clock;

namespace {

PublisherOptions latched() {
  loopbackDomain();
  PublisherOptions options;
  options.qos.durability = Qos::Durability::transientLocal;
  options.qos.depth = 1;
  return options;
}

/// Output of a subscriber that comes late for a latched message.
std::string received(const Message& message, const char* type) {
  Publisher publisher(static_cast<MessageType>(message.index()), "/a/b_1", latched());
  publisher.publish(message);
  REQUIRE(publisher.flush(10));
  Listener listener({.type = type, .qos = "latched"}, {"rt/a/b_1"});
  const std::vector<std::string> lines = listener.lines();
  REQUIRE(lines.size() == 1);
  return lines[0];
}

PointCloud2 cloudOfSize(int64_t number, uint32_t points) {
  PointCloud2 cloud;
  cloud.stamp = number;
  cloud.frame = "lidar";
  cloud.width = points;
  cloud.fields = {{"x", 0}, {"y", 4}, {"z", 8}, {"intensity", 12}};
  cloud.pointStep = 16;
  cloud.data.assign(size_t{points} * 16, static_cast<uint8_t>(number));
  return cloud;
}

/// Publishes clouds at 10 Hz on every topic, and returns how many calls of publish() took so long that a scan would
/// have been late. A machine that does something else causes some; one that waits for a subscriber, nearly all.
int publishSteadily(std::vector<Publisher>& publishers, int first, int count, uint32_t points) {
  int late = 0;
  const auto begin = Time::now();
  for (int i = first; i < first + count; ++i) {
    for (Publisher& publisher : publishers) {
      PointCloud2 cloud = cloudOfSize(i, points);
      const auto before = Time::now();
      publisher.publish(std::move(cloud));
      late += Time::now() - before > std::chrono::milliseconds(50);
    }
    std::this_thread::sleep_until(begin + std::chrono::milliseconds(100 * (i - first + 1)));
  }
  return late;
}

/// The numbers of the clouds in lines of a topic.
std::vector<int> numbersIn(const std::vector<std::string>& lines, const std::string& topic) {
  std::vector<int> numbers;
  for (const std::string& line : lines)
    if (line.starts_with(topic + " ")) numbers.push_back(std::stoi(line.substr(line.find('.') + 1)));
  return numbers;
}

std::vector<int> upTo(int count) {
  std::vector<int> numbers;
  for (int i = 0; i < count; ++i) numbers.push_back(i);
  return numbers;
}

void noneIsLost(int count) {
  loopbackDomain();
  PublisherOptions options;
  options.qos.depth = 20;
  std::vector<Publisher> publishers;
  publishers.emplace_back(MessageType::pointCloud2, "points", options);
  Listener listener({.count = count, .seconds = count / 10 + 30}, {"rt/points"});
  REQUIRE(eventually([&] { return publishers[0].counts().subscribers == 1; }));
  publishSteadily(publishers, 0, count, 28800);
  CHECK(numbersIn(listener.lines(), "rt/points") == upTo(count));
  const PublisherCounts counts = publishers[0].counts();
  CHECK(counts.published == static_cast<uint64_t>(count));
  CHECK(counts.sent == counts.published);
  CHECK(counts.dropped == 0);
}

}  // namespace

TEST_CASE("ROS 2: every value of every message arrives") {
  REQUIRE(unavailable().empty());
  PointCloud2 cloud;
  cloud.stamp = 1'700'000'000'000'000'005;
  cloud.frame = "front left";
  cloud.height = 2;
  cloud.width = 1;
  cloud.fields = {{"x", 0, PointField::Type::f64, 1}, {"ring", 8, PointField::Type::u16, 2}};
  cloud.pointStep = 13;
  cloud.data.assign(26, 0);
  cloud.data[25] = 7;
  cloud.dense = false;
  CHECK(received(cloud, "cloud") ==
        "rt/a/b_1 1700000000.000000005 front left 2x1 step 13 row 13 bytes 26 sum 7 big 0 dense 0 x:0:8:1 ring:8:4:2");

  LaserScan laser;
  laser.stamp = -1;
  laser.frame = "laser";
  laser.angleMin = -1.5f;
  laser.angleMax = 1.5f;
  laser.angleIncrement = 0.5f;
  laser.timeIncrement = 0.25f;
  laser.scanTime = 2;
  laser.rangeMin = 0.125f;
  laser.rangeMax = 30;
  laser.ranges = {1, INFINITY, 3};
  laser.intensities = {0.5f, 0, 9};
  CHECK(received(laser, "laser") ==
        "rt/a/b_1 -1.999999999 laser -1.5 1.5 0.5 0.25 2 0.125 30 ranges 1 inf 3 intensities 0.5 0 9");

  const Transforms transforms = {{5, "map", "base_link", {{1, 2, 3}, {0, 0, 0.6, 0.8}}}, {6, "base_link", "top", {}}};
  CHECK(received(transforms, "transforms") ==
        "rt/a/b_1 0.000000005 map>base_link 1 2 3 0 0 0.6 0.8 0.000000006 base_link>top 0 0 0 0 0 0 1");
  CHECK(received(Transforms{{5, "map", "odom", {{}, {0, 0, 3, 4}}}}, "transforms") ==
        "rt/a/b_1 0.000000005 map>odom 0 0 0 0 0 0.6 0.8");
  CHECK(received(Clock{12'000'000'003}, "clock") == "rt/a/b_1 12.000000003");
  Imu imu;
  imu.stamp = 7;
  imu.frame = "imu";
  imu.orientation = {0, 0, 0.6, 0.8};
  imu.angularVelocity = {1, 2, 3};
  imu.linearAcceleration = {4, 5, 9.75};
  imu.orientationCovariance = {1, 0, 0, 0, 1, 0, 0, 0, 2};
  imu.angularVelocityCovariance = {3, 0, 0, 0, 1, 0, 0, 0, 4};
  imu.linearAccelerationCovariance = {5, 0, 0, 0, 1, 0, 0, 0, 6};
  CHECK(received(imu, "imu") ==
        "rt/a/b_1 0.000000007 imu 0 0 0.6 0.8 turns 1 2 3 accelerates 4 5 9.75 covariances 1..2 3..4 5..6");
  Odometry odometry;
  odometry.stamp = 8;
  odometry.frame = "odom";
  odometry.childFrame = "base_link";
  odometry.pose = {{1, 2, 3}, {0, 0, 0.6, 0.8}};
  odometry.poseCovariance[0] = 4;
  odometry.poseCovariance[35] = 5;
  odometry.linearVelocity = {6, 7, 8};
  odometry.angularVelocity = {9, 10, 11};
  odometry.twistCovariance[0] = 12;
  odometry.twistCovariance[35] = 13;
  CHECK(received(odometry, "odometry") ==
        "rt/a/b_1 0.000000008 odom>base_link 1 2 3 0 0 0.6 0.8 moves 6 7 8 turns 9 10 11 covariances 4..5 12..13");
  CHECK(received(Transforms(), "transforms") == "rt/a/b_1");
  CHECK(received(PointCloud2(), "cloud") == "rt/a/b_1 0.000000000  1x0 step 0 row 0 bytes 0 sum 0 big 0 dense 1");
}

TEST_CASE("ROS 2: a scan as a cloud and as a laser scan") {
  Scan scan;
  scan.columns = 4;
  scan.channels = 1;
  scan.points = {1, 0, 0, NAN, NAN, NAN, -1, 0, 0, 0, -2, 0};
  scan.ranges = {1, NAN, 1, 2};
  scan.triangles = {0, kNoTriangle, 0, 0};
  scan.instances = {5, kNoTriangle, 6, 7};
  const PointCloud2 cloud = cloudOf(scan, {Field::x, Field::y, Field::z, Field::ring, Field::instance}, "top", 9);
  CHECK(cloud.width == 3);
  CHECK(cloud.height == 1);
  CHECK(cloud.pointStep == 18);
  REQUIRE(cloud.fields.size() == 5);
  CHECK(cloud.fields[3].name == "ring");
  CHECK(cloud.fields[3].offset == 12);
  CHECK(cloud.fields[3].type == PointField::Type::u16);
  REQUIRE(cloud.data.size() == 54);
  float y = 0;
  uint32_t instance = 0;
  std::memcpy(&y, &cloud.data[36 + 4], 4);
  std::memcpy(&instance, &cloud.data[18 + 14], 4);
  CHECK(y == -2);
  CHECK(instance == 6);
  CHECK_THROWS_WITH(cloudOf(scan, {Field::intensity}, "top", 0), ContainsSubstring("intensity"));

  Sensor sensor;
  sensor.columns = 4;
  sensor.channels = {{}};
  sensor.rangeMax = 50;
  sensor.rotationPeriod = 0.1;
  const LaserScan laser = laserScanOf(sensor, scan, 0, "top", 9);
  CHECK(laser.ranges == std::vector<float>{1, INFINITY, 1, 2});
  CHECK(laser.intensities.empty());
  CHECK(laser.angleMin == Approx(-M_PI));
  CHECK(laser.angleMax == Approx(M_PI / 2));
  CHECK(laser.angleIncrement == Approx(M_PI / 2));
  CHECK(laser.timeIncrement == Approx(0.025));
  CHECK(laser.scanTime == Approx(0.1));
  CHECK(laser.rangeMax == 50);
  sensor.azimuthSpanDeg = 270;
  sensor.scanPeriod = 0.15;
  CHECK(laserScanOf(sensor, scan, 0, "top", 9).scanTime == Approx(0.15));
  CHECK(laserScanOf(sensor, scan, 0, "top", 9).timeIncrement == Approx(0.025));
  CHECK_THROWS_WITH(laserScanOf(sensor, scan, 1, "top", 0), ContainsSubstring("no channel 1"));
  scan.sensor = "front";
  sensor.name = "rear";
  CHECK_THROWS_WITH(laserScanOf(sensor, scan, 0, "top", 0),
                    ContainsSubstring("is of the sensor front, and not of rear"));
  sensor.name = "front";
  CHECK_NOTHROW(laserScanOf(sensor, scan, 0, "top", 0));
  for (const double elevation : {-90, 90}) {
    sensor.channels = {{elevation}};
    CHECK_FALSE(hasLaserScan(sensor));
    CHECK_THROWS_WITH(laserScanOf(sensor, scan, 0, "top", 0), ContainsSubstring("straight up or down"));
  }
}

namespace {

/// A turn of two columns and two channels with up to two returns. Entries are in the order of channels, not of times.
Scan scanOfDriver() {
  Scan scan;
  scan.columns = 2;
  scan.channels = 2;
  scan.returns = 2;
  scan.points = {1, 0, 0, 2,   0,   0,   NAN, NAN, NAN, NAN, NAN, NAN,   // channel 0: two returns, none
                 0, 3, 4, NAN, NAN, NAN, -8,  0,   6,   NAN, NAN, NAN};  // channel 1: one each
  scan.ranges = {1, 2, NAN, NAN, 5, NAN, 10.0004f, NAN};
  scan.triangles.assign(8, 0);
  scan.instances.assign(8, 0);
  setColumn<float>(scan, Field::time, {0.01f, 0.01f, 0.05f, 0.05f, 0.0100004f, 0.0100004f, 0.0004f, 0.0004f});
  setColumn<float>(scan, Field::intensity, {0.5f, 0.2f, 0, 0, 1, 0, 0.126f, 0});
  setColumn<uint8_t>(scan, Field::returnNumber, {1, 2, 0, 0, 1, 0, 1, 0});
  return scan;
}

/// Returns a field of a point, found by its name as subscribers do it.
template <typename T>
T fieldOf(const PointCloud2& cloud, size_t point, const std::string& name) {
  for (const PointField& field : cloud.fields) {
    if (field.name != name) continue;
    T value;
    std::memcpy(&value, &cloud.data[point * cloud.pointStep + field.offset], sizeof(T));
    return value;
  }
  FAIL("no field " << name);
  return {};
}

/// Returns "name:offset:type ..." of a cloud's fields, and its step.
std::string layoutText(const PointCloud2& cloud) {
  std::string text;
  for (const PointField& field : cloud.fields)
    text += field.name + ":" + std::to_string(field.offset) + ":" + std::to_string(static_cast<int>(field.type)) + " ";
  return text + std::to_string(cloud.pointStep);
}

}  // namespace

// The layouts are those of the drivers' sources: velodyne_pointcloud, ouster-ros, HesaiLidar_ROS_2.0, rslidar_sdk,
// livox_ros_driver2 and autoware_point_types.
TEST_CASE("ROS 2: the block of docs/ros2.md publishes a cloud") {  // tests/docs/check_page compares it with the page
  loopbackDomain();
  Scan scan;
  scan.columns = 2;
  scan.channels = 1;
  scan.points = {1, 0, 0, 0, -2, 0};
  scan.ranges = {1, 2};
  scan.triangles = {0, 0};
  scan.instances = {0, 0};
  setColumn<float>(scan, Field::intensity, {0.5f, 0.25f});
  const int64_t stamp = 1'700'000'000'000'000'000;

  ros2::Publisher points(ros2::MessageType::pointCloud2, "front/points");
  points.publish(ros2::cloudOf(scan, {Field::x, Field::y, Field::z, Field::intensity, Field::ring}, "front", stamp));

  CHECK(points.flush(10));
  CHECK((points.counts().published == 1 && points.counts().sent == 1 && points.counts().dropped == 0));
}

TEST_CASE("ROS 2: clouds in the point layouts of drivers, in the order of times") {
  const Scan scan = scanOfDriver();
  constexpr int64_t kStamp = 1'700'000'000'250'000'000;
  const auto cloudOf = [&](Driver driver, const Effects& effects = {}) {
    const PointCloud2 cloud = driverCloudOf(scan, driver, "top", kStamp, effects);
    CHECK(cloud.stamp == kStamp);
    CHECK(cloud.frame == "top");
    CHECK(cloud.height == 1);
    CHECK(cloud.dense);
    REQUIRE(cloud.width == 4);
    REQUIRE(cloud.data.size() == size_t{4} * cloud.pointStep);
    CHECK(fieldOf<float>(cloud, 0, "x") == -8);
    CHECK(fieldOf<float>(cloud, 1, "x") == 1);
    CHECK(fieldOf<float>(cloud, 2, "x") == 2);
    CHECK(fieldOf<float>(cloud, 3, "z") == 4);
    return cloud;
  };

  const PointCloud2 velodyne = cloudOf(Driver::velodyne);
  CHECK(layoutText(velodyne) == "x:0:7 y:4:7 z:8:7 intensity:12:7 ring:16:4 time:18:7 22");
  CHECK(fieldOf<float>(velodyne, 0, "time") == 0.0004f);
  CHECK(fieldOf<float>(velodyne, 1, "intensity") == 50);
  CHECK(fieldOf<uint16_t>(velodyne, 0, "ring") == 1);

  const PointCloud2 ouster = cloudOf(Driver::ouster);
  CHECK(layoutText(ouster) ==
        "x:0:7 y:4:7 z:8:7 intensity:16:7 t:20:6 reflectivity:24:4 ring:26:4 ambient:28:4 range:32:6 48");
  CHECK(fieldOf<uint32_t>(ouster, 0, "t") == 400'000);
  CHECK(fieldOf<uint32_t>(ouster, 0, "range") == 10'000);
  CHECK(fieldOf<uint16_t>(ouster, 0, "reflectivity") == 13);
  CHECK(fieldOf<uint16_t>(ouster, 3, "ring") == 1);

  const PointCloud2 hesai = cloudOf(Driver::hesai), robosense = cloudOf(Driver::robosense);
  CHECK(layoutText(hesai) == "x:0:7 y:4:7 z:8:7 intensity:12:7 ring:16:4 timestamp:18:8 26");
  CHECK(std::abs(fieldOf<double>(hesai, 0, "timestamp") - 1'700'000'000.2504) < 3e-7);
  CHECK(robosense.data == hesai.data);

  const PointCloud2 livox = cloudOf(Driver::livox);
  CHECK(layoutText(livox) == "x:0:7 y:4:7 z:8:7 intensity:12:7 tag:16:2 line:17:2 timestamp:18:8 26");
  CHECK(std::abs(fieldOf<double>(livox, 1, "timestamp") - 1'700'000'000'260'000'000.0) <= 256);
  CHECK(fieldOf<uint8_t>(livox, 1, "tag") == 0);
  CHECK(fieldOf<uint8_t>(livox, 2, "tag") == 0x10);
  CHECK(fieldOf<uint8_t>(livox, 3, "line") == 1);

  const PointCloud2 autoware = cloudOf(Driver::autoware);
  CHECK(layoutText(autoware) ==
        "x:0:7 y:4:7 z:8:7 intensity:12:2 return_type:13:2 channel:14:4 azimuth:16:7 elevation:20:7 distance:24:7 "
        "time_stamp:28:6 32");
  CHECK(fieldOf<uint8_t>(autoware, 0, "intensity") == 13);
  CHECK(fieldOf<float>(autoware, 0, "azimuth") == Approx(M_PI));
  CHECK(fieldOf<float>(autoware, 0, "elevation") == Approx(std::atan2(6, 8)));
  CHECK(fieldOf<float>(autoware, 3, "distance") == 5);
  CHECK(fieldOf<uint32_t>(autoware, 3, "time_stamp") == 10'000'400);
  CHECK(fieldOf<uint8_t>(autoware, 0, "return_type") == 0);
  Effects effects;
  effects.intensity.scale = Effects::Intensity::Scale::byte;
  effects.returns.mode = Effects::Returns::Mode::lastStrongest;
  const PointCloud2 dual = cloudOf(Driver::autoware, effects);
  CHECK(fieldOf<uint8_t>(dual, 3, "intensity") == 1);
  CHECK(fieldOf<uint8_t>(dual, 0, "return_type") == 7);
  CHECK(fieldOf<uint8_t>(dual, 1, "return_type") == 3);
  CHECK(fieldOf<uint8_t>(dual, 2, "return_type") == 6);
  effects.returns.mode = Effects::Returns::Mode::strongest;
  CHECK(fieldOf<uint8_t>(cloudOf(Driver::autoware, effects), 1, "return_type") == 1);

  // Livox's tag has two bits for the number of a return.
  Scan five;
  five.columns = five.channels = 1;
  five.returns = 5;
  five.points.assign(15, 1);
  five.ranges.assign(5, 1.7f);
  five.triangles.assign(5, 0);
  five.instances.assign(5, 0);
  setColumn<float>(five, Field::time, {0, 0, 0, 0, 0});
  const PointCloud2 tagged = driverCloudOf(five, Driver::livox, "top", kStamp);
  for (const auto& [point, tag] : {std::pair(0, 0), std::pair(3, 0x30), std::pair(4, 0x30)})
    CHECK(fieldOf<uint8_t>(tagged, point, "tag") == tag);

  const LivoxCustom custom = livoxCustomOf(scan, "top", kStamp);
  CHECK(received(custom, "livox") ==
        "rt/a/b_1 1700000000.250000000 top base 1700000000250000000 points 4 id 0 400000:-8,0,6:13:0:1 "
        "10000000:1,0,0:50:0:0 10000000:2,0,0:20:16:0 10000400:0,3,4:100:0:1");

  Scan late = scan;  // its first two returns have no time, so they come last
  setColumn<float>(late, Field::time, {NAN, NAN, 0.05f, 0.05f, 0.0100004f, 0.0100004f, 0.0004f, 0.0004f});
  const PointCloud2 timeless = driverCloudOf(late, Driver::velodyne, "top", kStamp);
  size_t point = 0;
  for (const float x : {-8.0f, 0.0f, 1.0f, 2.0f}) CHECK(fieldOf<float>(timeless, point++, "x") == x);

  CHECK(driverNamed("ouster") == Driver::ouster);
  CHECK(!driverNamed("sick"));
}

TEST_CASE("ROS 2: a scan that a driver's types do not hold is refused") {
  Scan scan = scanOfDriver();
  setColumn<uint16_t>(scan, Field::ring, {0, 0, 0, 0, 256, 256, 256, 256});
  CHECK_THROWS_WITH(driverCloudOf(scan, Driver::livox, "", 0),
                    ContainsSubstring("'line' of the driver livox has numbers up to 255"));
  CHECK_NOTHROW(driverCloudOf(scan, Driver::ouster, "", 0));
  setColumn<float>(scan, Field::time, {5, 5, 5, 5, 5, 5, 5, 5});
  CHECK_THROWS_WITH(driverCloudOf(scan, Driver::ouster, "", 0),
                    ContainsSubstring("'t' of the driver ouster has times up to 4.29 s"));
  CHECK_NOTHROW(driverCloudOf(scan, Driver::velodyne, "", 0));
  ScanColumns(scan).make(Field::time, false);
  CHECK_THROWS_WITH(driverCloudOf(scan, Driver::velodyne, "", 0), ContainsSubstring("'time'"));
  CHECK_THROWS_WITH(driverCloudOf(scan, static_cast<Driver>(6), "", 0), ContainsSubstring("no driver 6"));
}

TEST_CASE("ROS 2: a list of evenly spaced beams is a laser scan, and dead and blocked beams are not free space") {
  Sensor sensor;
  sensor.name = "scanner";
  sensor.rangeMax = 40;
  BeamList list;
  for (const double degrees : {170.0, 179.0, 188.0, 197.0, 206.0}) {  // beyond 180 degrees without a gap
    list.directions.push_back({std::cos(degrees * M_PI / 180), std::sin(degrees * M_PI / 180), 0});
    list.times.push_back((degrees - 170) / 9000);
  }
  sensor.patterns = {list};
  sensor.maskedBeams = {1};
  Scan scan;
  scan.columns = 5;
  scan.channels = 1;
  scan.points.assign(15, NAN);
  scan.ranges = {NAN, NAN, NAN, 5, NAN};
  scan.triangles = scan.instances = {kNoTriangle, kNoTriangle, kNoTriangle, 0, kNoTriangle};
  // No surface, no surface, dropped out, returned, too near.
  setColumn<uint8_t>(scan, Field::cause, {1, 1, 4, 0, 6});
  CHECK(hasLaserScan(sensor));
  const LaserScan laser = laserScanOf(sensor, scan, 0, "front", 0);
  CHECK(laser.angleMin == Approx(170 * M_PI / 180));
  CHECK(laser.angleMax == Approx(206 * M_PI / 180));
  CHECK(laser.angleIncrement == Approx(9 * M_PI / 180));
  CHECK(laser.timeIncrement == Approx(0.001));
  CHECK(laser.scanTime == Approx(0.004));
  sensor.scanPeriod = 0.1;
  CHECK(laserScanOf(sensor, scan, 0, "front", 0).scanTime == Approx(0.1));
  CHECK(laser.ranges[0] == INFINITY);
  CHECK(std::isnan(laser.ranges[1]));
  CHECK(std::isnan(laser.ranges[2]));
  CHECK(laser.ranges[3] == 5);
  CHECK(laser.ranges[4] == -INFINITY);

  sensor.patterns[0].directions[2] = {-1, 0, 0};
  CHECK_FALSE(hasLaserScan(sensor));
  CHECK_THROWS_WITH(laserScanOf(sensor, scan, 0, "front", 0), ContainsSubstring("evenly spaced"));
  sensor.patterns = {list, list};
  CHECK_FALSE(hasLaserScan(sensor));
  sensor.patterns = {list};
  scan.columns = 3;
  scan.channels = 2;
  CHECK_THROWS_WITH(laserScanOf(sensor, scan, 0, "front", 0), ContainsSubstring("no channel 0 of the sensor scanner"));
}

TEST_CASE("ROS 2: wrong names, domains and messages are refused with a sentence") {
  loopbackDomain();
  const auto make = [](const char* topic, PublisherOptions options = {}) {
    Publisher(MessageType::clock, topic, options);
  };
  for (const char* topic : {"", "/", "a//b", "a/", "2d", "a/2d", "a-b", "~/a", "a b"})
    CHECK_THROWS_WITH(make(topic), ContainsSubstring("is no name of a topic"));
  PublisherOptions options;
  options.qos.depth = 0;
  CHECK_THROWS_WITH(make("a", options), ContainsSubstring("depth"));
  options.qos.depth = 1;
  options.domain = 233;
  CHECK_THROWS_WITH(make("a", options), ContainsSubstring("232"));
  const std::string domain = std::getenv("ROS_DOMAIN_ID");
  setenv("ROS_DOMAIN_ID", "7x", 1);
  CHECK_THROWS_WITH(make("a"), ContainsSubstring("ROS_DOMAIN_ID is '7x'"));
  setenv("ROS_DOMAIN_ID", domain.c_str(), 1);

  Publisher clouds(MessageType::pointCloud2, "points");
  CHECK_THROWS_WITH(clouds.publish(Clock()), ContainsSubstring("another type"));
  PointCloud2 cloud = cloudOfSize(0, 2);
  cloud.width = 3;
  CHECK_THROWS_WITH(clouds.publish(cloud),
                    ContainsSubstring("has 32 bytes, but height * width * pointStep is 1 * 3 * 16"));
  cloud = cloudOfSize(0, 2);
  cloud.fields[3].type = PointField::Type::f64;
  CHECK_THROWS_WITH(clouds.publish(cloud), ContainsSubstring("intensity ends beyond"));
  cloud.fields[3].type = PointField::Type::f32;
  cloud.fields[3].count = 2;
  CHECK_THROWS_WITH(clouds.publish(cloud), ContainsSubstring("intensity ends beyond"));
  cloud.fields[3].type = static_cast<PointField::Type>(9);
  CHECK_THROWS_WITH(clouds.publish(cloud), ContainsSubstring("no type of ROS"));
  LaserScan laser;
  laser.ranges = {1};
  laser.intensities = {1, 2};
  Publisher lasers(MessageType::laserScan, "scan");
  CHECK_THROWS_WITH(lasers.publish(laser), ContainsSubstring("2 values, but there are 1 ranges"));
  CHECK(clouds.counts().published == 0);

  Publisher moved = std::move(lasers);
  const auto refused = ContainsSubstring("was moved to another variable");
  CHECK_THROWS_WITH(lasers.publish(laser), refused);
  CHECK_THROWS_WITH(lasers.flush(0), refused);
  CHECK_THROWS_WITH(lasers.counts(), refused);
  Publisher& same = moved;
  moved = std::move(same);
  CHECK(moved.counts().published == 0);
}

TEST_CASE("ROS 2: a topic is refused when its thread, or those of Cyclone DDS, cannot be started") {
  const auto publish = [] { Publisher(MessageType::clock, "none", latched()); };
  const auto refused = [&](const std::string& begin) {
    const NoMoreThreads none;
    CHECK_THROWS_MATCHES(publish(), Error,
                         MessageMatches(StartsWith(begin + " cannot be started (Resource temporarily unavailable)")));
  };
  refused("the topic rt/none cannot be published: the 8 threads that Cyclone DDS may need");
  const Publisher other(MessageType::clock, "other", latched());  // keeps the threads of Cyclone DDS
  refused("ros2::Publisher: the thread that sends the messages of rt/none");
  CHECK_NOTHROW(publish());
}

TEST_CASE("ROS 2: three seconds at 10 Hz without loss") {
  noneIsLost(30);
}

TEST_CASE("ROS 2: a minute at 10 Hz without loss", "[.minute]") {
  noneIsLost(600);
}

TEST_CASE("ROS 2: subscribers that stop, sleep, die and come back stall nobody") {
  loopbackDomain();
  constexpr uint32_t kPoints = 131072;  // 2 MB
  PublisherOptions options;
  options.qos.depth = 20;  // a healthy subscriber on a busy machine may be two seconds late
  std::vector<Publisher> publishers;
  publishers.emplace_back(MessageType::pointCloud2, "points", options);
  Publisher& publisher = publishers[0];
  Listener healthy({.count = 60, .seconds = 60}, {"rt/points"});
  Listener slow({.count = 60, .seconds = 60, .sleepMs = 500}, {"rt/points"});
  Listener stopped({.count = 60, .seconds = 60}, {"rt/points"});
  Listener killed({.count = 60, .seconds = 60}, {"rt/points"});
  REQUIRE(eventually([&] { return publisher.counts().subscribers == 4; }));
  int late = publishSteadily(publishers, 0, 10, kPoints);
  const double before = residentMegabytes();
  stopped.tell(SIGSTOP);
  killed.end(SIGKILL);
  late += publishSteadily(publishers, 10, 40, kPoints);
  stopped.tell(SIGCONT);
  Listener restarted({.count = 5, .seconds = 30}, {"rt/points"});
  REQUIRE(eventually([&] { return publisher.counts().subscribers >= 4; }));
  late += publishSteadily(publishers, 50, 10, kPoints);
  CHECK(numbersIn(healthy.lines(), "rt/points") == upTo(60));
  CHECK(restarted.lines().size() == 5);
  CHECK(late < 10);
  CHECK(publisher.counts().dropped == 0);
  CHECK(residentMegabytes() - before < 100);  // the queue and unconfirmed messages: 2 * depth * 2 MB, of 120 MB sent
}

TEST_CASE("ROS 2: ten publishers at once") {
  loopbackDomain();
  std::vector<Publisher> publishers;
  std::vector<std::string> topics;
  for (int i = 0; i < 10; ++i) {
    publishers.emplace_back(MessageType::pointCloud2, "head" + std::to_string(i) + "/points");
    topics.push_back("rt/head" + std::to_string(i) + "/points");
  }
  Listener listener({.count = 200, .seconds = 60}, topics);
  for (Publisher& publisher : publishers) REQUIRE(eventually([&] { return publisher.counts().subscribers == 1; }));
  publishSteadily(publishers, 0, 5, 4000);
  const double before = residentMegabytes();
  const int late = publishSteadily(publishers, 5, 15, 4000);
  const std::vector<std::string> lines = listener.lines();
  for (const std::string& topic : topics) CHECK(numbersIn(lines, topic) == upTo(20));
  CHECK(late < 10);
  CHECK(residentMegabytes() - before < 10);
}

TEST_CASE("ROS 2: what waits too long is replaced and counted") {
  loopbackDomain();
  PublisherOptions options;
  options.qos.depth = 2;
  Publisher publisher(MessageType::pointCloud2, "points", options);
  for (int i = 0; i < 200; ++i) {
    publisher.publish(cloudOfSize(i, 131072));
    CHECK(publisher.counts().waiting <= 3);  // one of them is being sent
  }
  REQUIRE(publisher.flush(20));
  const PublisherCounts counts = publisher.counts();
  CHECK(counts.published == 200);
  CHECK(counts.waiting == 0);
  CHECK(counts.sent + counts.dropped == 200);
  CHECK(counts.sent >= 2);
}

// The test runs in a process that has an unusable library: see tests/CMakeLists.txt.
TEST_CASE("ROS 2: without Cyclone DDS a sentence names the package", "[.absent]") {
  CHECK_THAT(unavailable(), ContainsSubstring("cyclonedds-dev"));
  CHECK_THROWS_WITH(Publisher(MessageType::clock, "clock"),
                    ContainsSubstring("install the Debian packages cyclonedds-dev"));
  CHECK_THROWS_WITH(Publisher(MessageType::clock, "2"), ContainsSubstring("is no name of a topic"));
}

TEST_CASE("ROS 2: a message for which there is no memory is dropped and counted", "[.forgetful]") {
  Publisher publisher(MessageType::clock, "clock");
  for (int64_t i = 0; i < 3; ++i) {
    publisher.publish(Clock{i});
    REQUIRE(publisher.flush(10));
  }
  CHECK(publisher.counts().dropped == 3);
  CHECK(publisher.counts().sent == 0);
}

TEST_CASE("ROS 2: a topic whose thread cannot be started is refused", "[.forgetful]") {
  const auto publish = [] { Publisher(MessageType::clock, "clock"); };
  {
    const NoMoreThreads none;
    CHECK_THROWS_MATCHES(publish(), Error,
                         MessageMatches(StartsWith("ros2::Publisher: the thread that sends the messages of rt/clock "
                                                   "cannot be started (Resource temporarily unavailable)") &&
                                        ContainsSubstring("raise the limits")));
    gno_ros2_publisher publisher = nullptr;
    CHECK(gno_ros2_publisher_create(GNO_ROS2_CLOCK, "clock", nullptr, &publisher) == GNO_OUT_OF_MEMORY);
    CHECK(publisher == nullptr);
  }
  CHECK_NOTHROW(publish());
}
