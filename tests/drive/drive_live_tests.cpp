// SPDX-License-Identifier: Apache-2.0
// gnosphere drive --live, and what subscribers of ROS 2 get of it.
#include <algorithm>
#include <catch2/matchers/catch_matchers_string.hpp>

#include "drive/live.hpp"
#include "drive_support.hpp"
#include "ros2/listening.hpp"
#include "tools/cli_support.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;

namespace {

struct LivePlace : Workplace {
  explicit LivePlace(const Json& json) {
    loopbackDomain();
    put("cube.obj", kCube);
    put("floor.obj", kFloor);
    put("drive.json", json.dump());
  }
  Result publish(const std::string& arguments) const {
    return run("drive drive.json --device reference --live " + arguments);
  }
};

/// The second word of a line, a time in seconds.
double stampOf(const std::string& line) {
  return std::stod(line.substr(line.find(' ') + 1));
}

}  // namespace

TEST_CASE("gnosphere drive --live publishes a drive in its own time") {
  Json json = smallDrive();
  json["epoch"] = 1000;
  json["imu"] = {{"rate", 50}, {"mount", {{"position", {0.5, 0, 1}}}}};
  json["sensors"][0]["name"] = "on-top";
  json["sensors"][1]["driver"] = "ouster";
  json["sensors"][1]["sensor"]["elevation_deg"] = {0};
  const std::string flat = json["sensors"][1]["name"];
  const LivePlace place(json);
  Listener clouds({.count = 100, .seconds = 60}, {"rt/on_top/points"});
  Listener ousters({.type = "cloud", .count = 100, .seconds = 60}, {"rt/" + flat + "/points"});
  Listener lasers({.type = "laser", .count = 100, .seconds = 60}, {"rt/" + flat + "/scan"});
  Listener clock({.type = "clock", .count = 1000, .seconds = 60}, {"rt/clock"});
  Listener imu({.type = "imu", .count = 1000, .seconds = 60}, {"rt/imu/data"});
  Listener tf({.type = "transforms", .count = 1000, .seconds = 60}, {"rt/tf"});
  Listener odometry({.type = "odometry", .count = 1000, .seconds = 60}, {"rt/odom"});
  Listener mounts({.type = "transforms", .qos = "latched", .seconds = 60}, {"rt/tf_static"});
  const Result result = place.publish("--speed 0.25");  // four seconds
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  for (Listener* listener : {&clouds, &ousters, &lasers, &clock, &imu, &tf, &odometry, &mounts}) listener->end(SIGKILL);
  INFO(result.err);
  CHECK(result.status == 0);
  CHECK_THAT(result.out, ContainsSubstring("published") && !ContainsSubstring("dropped"));
  // The clock, the vehicle and its odometry have 101 messages each; there are 51 measurements, one message of the
  // mounts, 15 clouds and 5 laser scans.
  const size_t messages = result.out.find(", 375 messages in ");
  REQUIRE(messages != result.out.npos);
  CHECK(std::stod(result.out.substr(messages + 18)) >= 4);
  CHECK(place.files().size() == 3);  // it writes none

  // A subscriber misses the messages that are sent before it has discovered the topic.
  const std::vector<std::string> seen = clouds.lines();
  REQUIRE(seen.size() >= 5);
  CHECK(seen.size() <= 10);
  CHECK(stampOf(seen.back()) == 1000.9);
  CHECK_THAT(seen.back(), ContainsSubstring(" on-top 1x") && ContainsSubstring(" dense 1 x:0:7:1 y:4:7:1 z:8:7:1") &&
                              ContainsSubstring("ring:") && ContainsSubstring("class:") &&
                              ContainsSubstring("instance:") && ContainsSubstring("time:"));
  const std::vector<std::string> asOuster = ousters.lines();
  REQUIRE(!asOuster.empty());
  CHECK_THAT(asOuster.back(), ContainsSubstring(" step 48 ") && ContainsSubstring(" t:20:6:1 "));
  const std::vector<std::string> flatScans = lasers.lines();
  REQUIRE(!flatScans.empty());
  CHECK_THAT(flatScans.back(), ContainsSubstring(" ranges ") && ContainsSubstring(" 0.1 60 "));
  const std::vector<std::string> times = clock.lines(), poses = tf.lines();
  REQUIRE(times.size() >= 50);
  CHECK(times.size() <= 101);
  CHECK(stampOf(times.back()) == 1001);
  CHECK(std::is_sorted(times.begin(), times.end()));
  REQUIRE(poses.size() >= 50);
  CHECK_THAT(poses.back(), ContainsSubstring(" 1001.000000000 map>base_link 2 0 0 "));
  const std::vector<std::string> driven = odometry.lines();
  REQUIRE(driven.size() >= 50);
  CHECK(driven.size() <= 101);
  CHECK_THAT(driven.back(), ContainsSubstring(" 1001.000000000 map>base_link 2 0 0 0 0 0 1 moves 4 0 0 turns 0 0 0 "));
  const std::vector<std::string> measured = imu.lines();
  REQUIRE(measured.size() >= 25);
  CHECK(measured.size() <= 51);
  CHECK_THAT(measured.back(), ContainsSubstring(" 1001.000000000 imu 0 0 0 1 turns 0 0 0 accelerates 0 0 9.80665 "));
  const std::vector<std::string> placed = mounts.lines();
  REQUIRE(placed.size() == 1);
  CHECK_THAT(placed[0], ContainsSubstring("base_link>on-top 0 0 1.8") && ContainsSubstring("base_link>" + flat) &&
                            ContainsSubstring("base_link>imu 0.5 0 1"));
}

TEST_CASE("a live drive needs neither an inertial unit nor functions that are told how far it is") {
  loopbackDomain();
  const DriveFolder folder;
  const drive::Drive drive = folder.read(smallDrive());
  drive::LiveOptions options;
  options.endFrame = 2;
  options.speed = 100;
  options.simulator.device = DeviceChoice::Kind::reference;
  // The clock, the vehicle and its odometry have 21 messages each; there are the mounts and three clouds.
  CHECK(drive::publishLive(drive, options).messages == 67);
  std::string device;
  std::vector<std::pair<uint64_t, uint64_t>> told;
  options.started = [&](const DeviceInfo& info) { device = info.name; };
  options.progress = [&](uint64_t done, uint64_t total) { told.emplace_back(done, total); };
  CHECK(drive::publishLive(drive, options).device == device);
  CHECK(!device.empty());
  CHECK(told == std::vector<std::pair<uint64_t, uint64_t>>{{1, 2}, {2, 2}});
}

TEST_CASE("wrong calls of gnosphere drive --live are refused") {
  Json json = smallDrive();
  const LivePlace place(json);
  const auto refused = [&](const std::string& arguments, int status, const std::string& words) {
    INFO(arguments);
    const Result result = place.publish(arguments);
    CHECK(result.status == status);
    CHECK_THAT(result.err, ContainsSubstring(words));
  };
  refused("-o out", 2, "excludes --live");
  refused("--shard 0/2", 2, "excludes --live");
  refused("--speed 0", 2, "--speed");
  refused("--frames 10:", 2, "frames 0 to 9");
  json["sensors"][0]["name"] = "2nd";
  place.put("drive.json", json.dump());
  refused("", 2, "the sensor '2nd' begins with a digit");
}
