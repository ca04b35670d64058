// SPDX-License-Identifier: Apache-2.0
// Tests of what a drive warns of: times, sensors and weather that a file probably does not mean.
#include <catch2/matchers/catch_matchers_string.hpp>

#include "drive_support.hpp"

using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::StartsWith;

namespace {

using Warnings = std::vector<std::string>;

Warnings warningsOf(const Json& json) {
  return DriveFolder().read(json).warnings;
}

}  // namespace

TEST_CASE("trajectories beside the time of the drive are warned of") {
  REQUIRE(warningsOf(quietDrive()).empty());
  Json json = quietDrive();
  json["actors"][0]["trajectory"] = {
      {"waypoints", {waypoint(1700000000, 3, 3, 0.75), waypoint(1700000001.5, 8, 3, 0.75)}}};
  CHECK(warningsOf(json) == Warnings{"actors[0].trajectory: is from 1700000000 s to 1700000001.5 s, and the drive from "
                                     "0 s to 1 s, so 'car-1' stands all the time; \"begin\" moves its first time"});
  json["actors"][0]["outside"] = "gone";
  REQUIRE(warningsOf(json).size() == 1);
  CHECK_THAT(warningsOf(json)[0], ContainsSubstring("so 'car-1' is never there; "));
  json["actors"][0]["trajectory"]["begin"] = 0.9;  // it overlaps by a tenth of a second
  CHECK(warningsOf(json).empty());
  json["actors"][0]["trajectory"] = {{"waypoints", {waypoint(1700000000, 3, 3, 0.75)}}};  // a parked car
  CHECK(warningsOf(json).empty());
  json["actors"][0]["trajectory"] = {{"waypoints", {waypoint(1e70, 3, 3, 0.75), waypoint(2e70, 8, 3, 0.75)}}};
  const std::string digits = std::to_string(1e70);  // with six zeros after the point
  REQUIRE(warningsOf(json).size() == 1);
  CHECK_THAT(warningsOf(json)[0], ContainsSubstring(": is from " + digits.substr(0, digits.size() - 7) + " s to "));

  json = quietDrive();
  json["duration"] = 0.1;  // a part of the whole, in which the person has not yet come
  CHECK(warningsOf(json).empty());
  json["start"] = 1000;
  json["duration"] = 4;
  CHECK(warningsOf(json) == Warnings{"ego.trajectory: is from 0 s to 1 s, and the drive from 1000 s to 1004 s, so the "
                                     "vehicle stands all the time; give another start"});
  json["ego"]["trajectory"] = {{"waypoints", {waypoint(0, 0, 0, 0)}}};  // it is meant to stand
  CHECK(warningsOf(json) ==
        Warnings{"actors[0].trajectory: is from 0 s to 1 s, and the drive from 1000 s to 1004 s, so 'car-1' stands all "
                 "the time; \"begin\" moves its first time (of 2 trajectories beside the drive this is the first)"});
}

TEST_CASE("triangles that are nowhere are warned of by file, and counted by scan") {
  const DriveFolder folder;
  put(folder / "hole.obj", std::string(kFloor) + "v nan 0 0\nf 1 2 -1\nf 2 3 -1\n");
  Json json = quietDrive();
  json["duration"] = 0.2;
  json["models"]["hole"] = {{"file", "hole.obj"}};
  json["actors"][0]["model"] = "hole";
  json["actors"][0].erase("size");
  json["scenes"].push_back({{"file", "hole.obj"}, {"pose", {{"position", {0, 0, -1}}}}});
  CHECK(folder.read(json).warnings ==
        Warnings{
            "scenes[1].file: 2 triangles of 'hole.obj' are dropped because a corner is NaN, infinite or beyond 1e9 m "
            "or units of the file"});
  folder.run(json);
  const Json scans = Json::parse(folder.get("out/manifest/frames/000001.json"))["scans"];
  REQUIRE(scans.size() > 0);
  for (const Json& scan : scans) {
    CHECK(scan["non_finite"] == 4);
    CHECK(scan["lost_echoes"] == 0);
  }
}

TEST_CASE("a model that is no size of anything in traffic is warned of, unless its actors have a size of their own") {
  const DriveFolder folder;
  Json json = quietDrive();
  json["actors"][0]["trajectory"]["waypoints"] = {waypoint(0, 0, 200, 0)};  // sensors are not in its box
  const std::string remedy =
      " m; files are in metres, and \"scale\" changes that: 0.01 for centimetres, 0.001 for millimetres";
  for (const auto& [scale, warned] : {std::pair(101.0, "101"), {99.0, ""}, {0.021, ""}, {0.019, "0.019"}}) {
    CAPTURE(scale);
    json["models"]["cube"]["scale"] = scale;
    json["actors"][0].erase("size");
    CHECK(folder.read(json).warnings ==
          (*warned ? Warnings{std::string("models.cube.file: measures ") + warned + remedy} : Warnings{}));
    json["actors"][0]["size"] = {4, 2, 1.5};
    CHECK(folder.read(json).warnings.empty());
  }
}

TEST_CASE("a size that distorts its model is warned of, unless the model is a box") {
  const DriveFolder folder;
  put(folder / "wedge.obj", "v 0 0 0\nv 2 0 0\nv 0 1 0\nv 0.5 0.5 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
  Json json = quietDrive();
  json["actors"][0]["size"] = {40, 1, 1};
  CHECK(folder.read(json).warnings.empty());
  json["models"]["cube"]["file"] = "wedge.obj";
  json["actors"][0]["size"] = {4, 2, 2.9};
  json["actors"][1]["size"] = {4, 2, 2.9};
  CHECK(folder.read(json).warnings.empty());
  json["actors"][1]["size"] = {4, 2, 3.28};
  const std::string text =
      "actors[1].size: scales the model of 'person-1' by 2, 2 and 3.28 along x, y and z, which distorts it; the model "
      "measures 2, 1 and 1 m: give a size of its proportions, or turn it by its \"pose\"";
  CHECK(folder.read(json).warnings == Warnings{text});
  json["actors"][0]["size"] = {4, 2, 3.1};
  CHECK(folder.read(json).warnings == Warnings{text + " (of 2 actors that are distorted this is the most)"});
}

TEST_CASE("a model whose fronts are inside is warned of where beams pass through backs") {
  const DriveFolder folder;
  Scene cube = loadScene(folder / "cube.obj");
  Json json = quietDrive();
  json["models"]["cube"]["file"] = "cube.glb";
  const auto warnings = [&] {
    writeGlb(cube, folder / "cube.glb");
    return folder.read(json).warnings;
  };
  const Warnings inside = {
      "models.cube.file: has the fronts of its surfaces inside, and beams pass through backs, so it is invisible from "
      "outside; turn its triangles round, or make its materials double-sided"};
  double& mirror = cube.instances.at(0).transform.rows[0];  // glTF turns the triangles of a mirrored mesh
  cube.materials.at(0).doubleSided = false;
  CHECK(warnings().empty());
  mirror = -1;
  CHECK(warnings().empty());
  std::vector<uint32_t>& indices = cube.meshes.at(0).indices;
  for (size_t i = 0; i < indices.size(); i += 3) std::swap(indices[i], indices[i + 1]);
  CHECK(warnings() == inside);
  mirror = 1;
  CHECK(warnings() == inside);
  json["simulator"]["faces"] = "both";
  CHECK(warnings().empty());
  json.erase("simulator");
  cube.materials[0].doubleSided = true;
  CHECK(warnings().empty());
}

TEST_CASE("a pose file that lacks poses, or whose times are not in seconds, is warned of") {
  const DriveFolder folder;
  const auto recorded = [&](double unit, double gap, double moved) {  // at 100 Hz, with a gap after half a second
    std::string lines;
    for (int i = 0; i <= 100; ++i) {
      const double lost = i > 50 ? gap : 0, time = 0.01 * i + lost,
                   x = 2 * 0.01 * std::min(i, 50) + (i > 50 ? moved : 0);
      lines += std::to_string(unit * time) + " " + std::to_string(x) + " 0 0 0 0 0 1\n";
    }
    put(folder / "ego.tum", lines);
    Json json = quietDrive();
    json["actors"] = Json::array();
    json["ego"]["trajectory"] = {{"file", "ego.tum"}};
    return folder.read(json).warnings;
  };
  CHECK(recorded(1, 0, 0.02).empty());
  CHECK(recorded(1, 0.1, 0.3).empty());
  CHECK(recorded(1, 0.39, 0.8) ==
        Warnings{"ego.trajectory.file: has no pose from 0.5 s to 0.9 s, 40 times as long as between most poses, so the "
                 "vehicle goes straight"});
  CHECK(recorded(1, 0.39, 0).empty());  // it stood
  std::string twice;
  for (int i = 0; i <= 100; ++i) {
    const double lost = (i > 30 ? 0.2 : 0) + (i > 60 ? 0.4 : 0);
    twice +=
        std::to_string(0.01 * i + lost) + " " + std::to_string(0.02 * std::min(i, 90) + 2 * lost) + " 0 0 0 0 0 1\n";
  }
  put(folder / "ego.tum", twice);
  Json json = quietDrive();
  json["actors"] = Json::array();
  json["ego"]["trajectory"] = {{"file", "ego.tum"}};
  CHECK(folder.read(json).warnings ==
        Warnings{"ego.trajectory.file: has no pose from 0.8 s to 1.21 s, 41 times as long as between most poses, so "
                 "the vehicle goes straight (of 2 gaps this is the longest)"});
  const auto has = [](const Warnings& warnings, const std::string& text) {
    return std::ranges::find(warnings, "ego.trajectory.file: has a pose every " + text) != warnings.end();
  };
  CHECK(has(recorded(1e4, 0, 0.02), "100 s; times are in seconds, and these look like milliseconds"));
  CHECK(has(recorded(1e6, 0, 0.02), "10000 s; times are in seconds, and these look like microseconds"));
}

TEST_CASE("an epoch for times that are Unix times already is warned of") {
  Json json = quietDrive();
  json["actors"] = Json::array();
  const auto warnings = [&](double epoch, double begin) {
    json["epoch"] = epoch;
    json["start"] = begin;
    json["ego"]["trajectory"] = {
        {"waypoints",
         {{{"time", begin}, {"position", {0, 0, 0}}}, {{"time", begin + 100}, {"position", {100, 0, 0}}}}}};
    return warningsOf(json);
  };
  CHECK(
      warnings(1700000000, 1403636579.75) ==
      Warnings{"epoch: is added to the times of the trajectory, and the drive begins at 1403636579.75 s of them, which "
               "look like Unix times: without an epoch they are"});
  CHECK(warnings(0, 1403636579.75).empty());
  CHECK(warnings(1700000000, 0).empty());
  CHECK(warnings(1315964782, 4e8).empty());        // adjusted standard GPS time
  CHECK(warnings(315964800 - 18, 1.4e9).empty());  // seconds since the beginning of GPS time
}

TEST_CASE("a pose file that has the vehicle upside down is warned of") {
  const DriveFolder folder;
  const auto warnings = [&](const std::string& quaternion, double x) {
    std::string lines;
    for (int i = 0; i < 20; ++i)
      lines += std::to_string(0.1 * i) + " " + std::to_string(x + 0.1 * i) + " 0 0 " + quaternion + "\n";
    put(folder / "ego.tum", lines);
    Json json = quietDrive();
    json["actors"] = Json::array();
    json["ego"]["trajectory"] = {{"file", "ego.tum"}};
    json["duration"] = 1;
    return folder.read(json).warnings;
  };
  CHECK(warnings("0 0 0.0872 0.9962", 0).empty());
  CHECK(warnings("0.9962 0 0 0.0872", 0) ==
        Warnings{"ego.trajectory.file: has the vehicle upside down in 11 of 11 poses; lines are t x y z qx qy qz qw, "
                 "with w last"});
  CHECK(warnings("1 0 0 0", 5e6).empty());  // seen from the centre of the earth
}

TEST_CASE("actors and vehicles that jump from one stamp to the next are warned of") {
  Json json = quietDrive();
  const auto jump = [](double time, double length) {
    return Json{waypoint(0, 3, 3, 0.75), waypoint(time, 3, 3, 0.75), waypoint(time + 0.001, 3 + length, 3, 0.75),
                waypoint(2, 4 + length, 3, 0.75)};
  };
  const std::string advice =
      "; positions are in metres and times in seconds, and what appears elsewhere is another actor, both with "
      "\"outside\": \"gone\"";
  json["actors"][0]["trajectory"]["waypoints"] = jump(0.449, 10);
  CHECK(warningsOf(json) ==
        Warnings{"actors[0].trajectory: 'car-1' goes 10 m in 0.001 s from 0.449 s on, at 10000 m/s" + advice});
  json["actors"][1]["trajectory"]["waypoints"] = jump(0.3, 20);
  CHECK(warningsOf(json) ==
        Warnings{"actors[1].trajectory: 'person-1' goes 20 m in 0.001 s from 0.3 s on, at 20000 m/s" + advice +
                 " (of 2 actors that do so this is the fastest)"});
  json["actors"].erase(1);
  json["actors"][0]["trajectory"]["waypoints"] = jump(0.449, 0.09);  // at 90 m/s
  CHECK(warningsOf(json).empty());
  json["actors"][0]["trajectory"]["waypoints"] = jump(1.5, 10);  // after the drive
  CHECK(warningsOf(json).empty());

  json = quietDrive();
  json["ego"]["trajectory"]["waypoints"] = {waypoint(0, 0, 0, 0), waypoint(0.5, 1, 0, 0), waypoint(0.502, 2, 0, 0),
                                            waypoint(1, 3, 0, 0)};
  CHECK(warningsOf(json) == Warnings{"ego.trajectory: the vehicle goes 1 m in 0.002 s from 0.5 s on, at 500 m/s; "
                                     "positions are in metres and times in seconds"});
  json["ego"]["trajectory"]["waypoints"] = {waypoint(0, 0, 0, 0), waypoint(0.5, 100, 0, 0), waypoint(1, 210, 0, 0)};
  CHECK(warningsOf(json).empty());  // an aircraft
  json["actors"][0]["trajectory"] = json["ego"]["trajectory"];
  CHECK(warningsOf(json).empty());  // its body
}

TEST_CASE("yaws in radians are warned of") {
  const auto driven = [](double yaw, double x, double y) {
    Json json = quietDrive(), from = waypoint(0, 0, 0, 0), to = waypoint(1, x, y, 0);
    from["yaw_deg"] = to["yaw_deg"] = yaw;
    json["ego"]["trajectory"] = {{"waypoints", {from, to}}};
    return warningsOf(json);
  };
  CHECK(driven(1.6, -0.1, 5) ==
        Warnings{"ego.trajectory.waypoints[0].yaw_deg: is 1.6, and the way leads elsewhere; the "
                 "yaws are in degrees, and along the way these would be radians"});
  CHECK(driven(1.6, 5, 0).empty());  // a little to the left
  CHECK(driven(0, -5, 0).empty());   // backwards
  CHECK(driven(90, 0, 5).empty());
}

TEST_CASE("a file whose positions have steps of single precision is warned of once") {
  const DriveFolder folder;
  put(folder / "utm.ply",
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n5300000.5 0 0\n5300020 0 0\n"
      "5300000 20.5 0\n3 0 1 2\n");
  Json json = quietDrive();
  json["scenes"].push_back({{"file", "utm.ply"}, {"class", "ground"}, {"pose", {{"position", {-5300000, 0, 0}}}}});
  json["scenes"].push_back(json["scenes"][1]);
  const Warnings warnings = folder.read(json).warnings;
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0], StartsWith("scenes[1].file: 'utm.ply': its positions are in single precision, which has "
                                     "steps of 0.5 m at 5300020 m; "));
}

TEST_CASE("a drive that begins before its vehicle, or goes on when that has arrived, is warned of") {
  Json json = quietDrive();
  json["start"] = -0.25;
  json["duration"] = 0.5;
  CHECK(warningsOf(json) ==
        Warnings{"ego.trajectory: begins at 0 s, and the drive from -0.25 s to 0.25 s, so the vehicle stands for the "
                 "first 0.25 s; give a later start"});
  json["start"] = 0.2;
  json["duration"] = 1.5;
  CHECK(warningsOf(json) ==
        Warnings{"ego.trajectory: ends at 1 s, and the drive from 0.2 s to 1.7 s, so the vehicle stands for the last "
                 "0.7 s; give a shorter duration"});
  json["duration"] = 0.8;
  CHECK(warningsOf(json).empty());
  json["duration"] = 1.5;
  json["ego"]["trajectory"] = {{"waypoints", {waypoint(0, 0, 0, 0)}}};  // it is meant to stand
  CHECK(warningsOf(json).empty());
}

TEST_CASE("a scan that goes on when its moving vehicle has arrived is warned of") {
  Json json = quietDrive();
  json["sensors"][1]["offset"] = 0.15;  // the last scan is from 0.95 to 1.05 s
  const std::string end = ", so the vehicle stops at once and stands for the rest of it; give a longer trajectory";
  CHECK(warningsOf(json) == Warnings{"ego.trajectory: ends at 1 s, and the last scan of 'side' at 1.05 s" + end +
                                     ", or a duration of at most 0.95 s"});
  json["duration"] = 0.95;
  CHECK(warningsOf(json).empty());
  json["duration"] = 1;
  json["sensors"][0]["offset"] = 0.07;
  CHECK(warningsOf(json) == Warnings{"ego.trajectory: ends at 1 s, and the last scan of 'top' at 1.07 s" + end +
                                     ", or a duration of at most 0.95 s"});
  json["sensors"][0]["offset"] = 0;
  json["sensors"][1]["offset"] = 0.25;
  json["sensors"][1]["rate"] = 6;  // the last scan is from 0.91666 to 1.01666 s
  CHECK(warningsOf(json) == Warnings{"ego.trajectory: ends at 1 s, and the last scan of 'side' at 1.017 s" + end +
                                     ", or a duration of at most 0.916 s"});
  json["duration"] = 0.916;
  CHECK(warningsOf(json).empty());
  json["weather"] = Json::array();
  json["start"] = 0.95;
  json["duration"] = 0.05;
  json["sensors"][1]["offset"] = 0;
  CHECK(warningsOf(json) == Warnings{"ego.trajectory: ends at 1 s, and the last scan of 'top' at 1.05 s" + end});
  json["actors"] = Json::array();
  json["ego"]["trajectory"]["waypoints"].push_back(waypoint(2, 2, 0, 0));  // it stands until it has ended
  CHECK(warningsOf(json).empty());
  json["start"] = 1.95;
  CHECK(warningsOf(json).empty());
  json["ego"]["trajectory"] = {{"waypoints", {waypoint(0, 0, 0, 0)}}};
  CHECK(warningsOf(json).empty());
}

TEST_CASE("fields of a driver's clouds that have no value are warned of") {
  Json json = quietDrive();
  json["sensors"][1]["driver"] = "autoware";
  json["sensors"][1]["effects"] = {{"intensity", "off"}};
  CHECK(warningsOf(json) == Warnings{"sensors[1].driver: the intensities in the clouds of 'side' are 0, because its "
                                     "effect intensity is off"});
  json["sensors"][1]["effects"] = {{"returns", {{"count", 2}}}};
  CHECK(warningsOf(json) == Warnings{"sensors[1].driver: the return types in the clouds of 'side' are 0, unknown, "
                                     "because its effect returns has the mode all; the mode dual gives Autoware's "
                                     "types of pairs"});
  json["sensors"][1]["effects"] = {{"returns", {{"mode", "dual"}}}};
  CHECK(warningsOf(json).empty());
}

TEST_CASE("more lines than Livox's heads have are warned of where their driver is named") {
  Json json = quietDrive();
  for (const char* driver : {"livox", "livox-custom"}) {
    json["sensors"][1]["driver"] = driver;
    CHECK(
        warningsOf(json) ==
        Warnings{"sensors[1].driver: Livox's heads have at most 6 lines, and 'side' has 8; nodes such as FAST-LIO drop "
                 "points whose line is not below their scan_line"});
  }
  json["sensors"][1]["driver"] = "ouster";
  CHECK(warningsOf(json).empty());
  json["sensors"][1]["driver"] = "livox-custom";
  json["sensors"][1]["sensor"]["elevation_deg"] = {-10, -5, -3, 0, 3, 5};
  CHECK(warningsOf(json).empty());
}

TEST_CASE("entries of weather on another clock are warned of") {
  Json json = quietDrive();
  json["weather"] = {{{"time", 1700000000}}, {{"time", 1700000000.5}, {"rain", 5}}};
  CHECK(warningsOf(json) == Warnings{"weather[0].time: is 1700000000 s, and times of weather count from the start of "
                                     "the drive, which lasts 1 s"});
  json["weather"] = {{{"time", 0}}, {{"time", 60}, {"rain", 5}}};  // the drive has the beginning of the ramp
  CHECK(warningsOf(json).empty());
  json["weather"] = {{{"time", 0}}, {{"time", 0.9}, {"rain", 5}}, {{"time", 2}, {"rain", 9}}};
  CHECK(warningsOf(json).empty());
  json["duration"] = 0.5;  // a part of the whole, in which the rain has not yet come
  CHECK(warningsOf(json).empty());
  json["weather"] = {{{"time", 5}, {"rain", 5}}};  // one entry holds at all times
  CHECK(warningsOf(json).empty());
}

TEST_CASE("a sensor that makes no scan, or is mounted far away, is warned of") {
  Json json = quietDrive();
  json["sensors"][1]["offset"] = 1;
  CHECK(warningsOf(json) == Warnings{"sensors[1].offset: is 1 s, and the drive lasts 1 s, so 'side' makes no scan"});
  json["sensors"][1]["offset"] = 0.9;
  CHECK(warningsOf(json).empty());
  json["sensors"][0]["mount"]["position"] = {900, 0, 1200};  // millimetres
  json["imu"]["mount"]["position"] = {0, 0, 51};
  CHECK(warningsOf(json) ==
        Warnings{"sensors[0].mount.position: is 1500 m from the vehicle's origin; positions are in metres",
                 "imu.mount.position: is 51 m from the vehicle's origin; positions are in metres"});
  json["duration"] = 1;
  json["ego"]["trajectory"]["waypoints"].erase(1);  // a site may be larger than a vehicle
  CHECK(warningsOf(json) ==
        Warnings{"sensors[0].mount.position: is 1500 m from the vehicle's origin; positions are in metres"});
}

TEST_CASE("a drive that leaves out scans of a faster sensor is warned of") {
  Json json = quietDrive();
  json["rate"] = 10;
  json["sensors"][0]["sensor"] = "Puck:20Hz";
  json["sensors"][0].erase("rate");
  CHECK(warningsOf(json) ==
        Warnings{"sensors[0].sensor: makes 20 scans a second, and the drive has 10 of them; give '" +
                 json["sensors"][0]["name"].get<std::string>() + "' a \"rate\" of 20 to have all"});
  json["sensors"][0]["rate"] = 10;
  CHECK(warningsOf(json).empty());
  json["sensors"][0].erase("rate");
  json["rate"] = 20;
  CHECK(warningsOf(json).empty());
}

TEST_CASE("samples without a scan of a sensor are warned of, with its offset or its rate as the cause") {
  const DriveFolder folder;
  Json json = quietDrive();
  json["sensors"][1]["rate"] = 10;
  json["outputs"] = {{{"format", "nuscenes"}, {"keyframes", 2}}};
  const auto warningsWith = [&](double rate, double offset) {
    json["sensors"][1]["rate"] = rate;
    json["sensors"][1]["offset"] = offset;
    std::string lines;
    for (const std::string& warning : folder.read(json).warnings)
      if (warning.find("samples") != warning.npos) lines += warning + "\n";
    return lines;
  };
  CHECK(warningsWith(10, 0.05) == "");
  CHECK(warningsWith(5, 0) == "");
  CHECK(warningsWith(5, 0.1) ==
        "outputs[0]: 'side' starts no scan in 5 of 5 samples, which lack its data, because its first scan starts 0.1 s "
        "after the start of the drive; choose another offset or other keyframes\n");
  CHECK(warningsWith(10, 0.3) ==
        "outputs[0]: 'side' starts no scan in 2 of 5 samples, which lack its data, because its first scan starts 0.3 s "
        "after the start of the drive; choose another offset or other keyframes\n");
  CHECK(
      warningsWith(2.5, 0) ==
      "outputs[0]: 'side' starts no scan in 2 of 5 samples, which lack its data, because it makes 2.5 scans a second; "
      "choose another rate or other keyframes\n");
}

TEST_CASE("long scans of a vehicle that shakes are warned of") {
  const auto shaken = [](double seconds, double hertz, double height = 50) {
    Json json = quietDrive(), waypoints = Json::array(), times = Json::array(), directions = Json::array();
    for (int i = 0; i <= 400 * seconds; ++i) {  // by half a degree
      const double half = 0.0087 / 2 * std::sin(2 * M_PI * hertz * i / 400 + 0.6);
      Json point = waypoint(i / 400.0, i / 400.0, 0, height);
      point["orientation"] = {std::sin(half), 0, 0, std::cos(half)};
      waypoints.push_back(std::move(point));
    }
    for (int i = 0; i < 100; ++i) {
      directions.push_back({0, 0, -1});
      times.push_back(seconds * i / 100);
    }
    json["ego"]["trajectory"] = {{"waypoints", waypoints}};
    json["actors"] = Json::array();
    json["weather"] = Json::array();
    json["sensors"] = {{{"name", "line"},
                        {"sensor",
                         {{"name", "line"},
                          {"range", {{"min", 1}, {"max", 2000}}},
                          {"patterns", {{{"directions", directions}, {"times", times}}}}}}}};
    json["rate"] = 1 / seconds;
    json["duration"] = seconds;
    return json;
  };
  CHECK(
      warningsOf(shaken(8, 100)) ==
      Warnings{"sensors[0].sensor: a scan of 'line' lasts 7.92 s and knows 2048 poses, between which beams 100 m long "
               "are up to 0.56 m off where the trajectory leads them; in scans of at most 0.1 s they are within a "
               "centimetre"});
  // The beams of an aircraft are longer, but no longer than it sees.
  const auto length = [&](double height) {
    const Warnings warnings = warningsOf(shaken(8, 100, height));
    REQUIRE(warnings.size() == 1);
    return warnings[0].substr(warnings[0].find("beams "), 35);
  };
  CHECK(length(1000) == "beams 1000 m long are up to 5.55 m ");
  CHECK(length(5000) == "beams 2000 m long are up to 11.11 m");
  CHECK(warningsOf(shaken(0.1, 100)).empty());
  CHECK(warningsOf(shaken(8, 0.1)).empty());  // a vehicle that rolls slowly
}

TEST_CASE("weather of the drive that the effects of a sensor turn off is warned of") {
  Json json = quietDrive();
  json["sensors"][1]["effects"] = {{"fog", {{"use", "off"}}}, {"snow", {{"use", "off"}}}};
  CHECK(warningsOf(json).empty());  // the drive has rain alone
  json["weather"] = {{{"time", 0}, {"visibility", 100}}, {{"time", 1}, {"snow", 2}, {"rain", 3}}};
  CHECK(warningsOf(json) ==
        Warnings{"sensors[1].effects: turn fog and snow off, so 'side' scans without this part of the drive's weather; "
                 "\"use\": \"auto\" adds it"});
}

TEST_CASE("causes in clouds that leave out the beams that have them are warned of") {
  Json json = quietDrive();
  json["outputs"] = {{{"format", "npy"}, {"fields", "range,cause"}}, {{"format", "mcap"}, {"fields", "x,y,z,cause"}}};
  const std::string why =
      ".fields: have cause, which is 0 (returned) everywhere, because these clouds leave out beams without a return; ";
  CHECK(warningsOf(json) ==
        Warnings{"outputs[0]" + why + "with \"compact\": false they have all beams",
                 "outputs[1]" + why + "an output pcd or npy with \"compact\": false has all beams"});
  json["outputs"][0]["compact"] = false;
  json["outputs"].erase(1);
  CHECK(warningsOf(json).empty());
}

TEST_CASE("motion within scans that effects turn off is warned of where points have times") {
  Json json = quietDrive();
  json["weather"] = Json::array();
  json["sensors"][1]["effects"] = "clean";
  CHECK(warningsOf(json) ==
        Warnings{"sensors[1].effects: turn sensor-motion and object-motion off, so a scan of 'side' shows its start "
                 "alone, although the times of its points in npy go on to 0.1 s; \"use\": \"auto\" lets them move"});
  json["outputs"] = {{{"format", "mcap"}}, {{"format", "npy"}, {"fields", "x,y,z"}}};
  REQUIRE(warningsOf(json).size() == 1);
  CHECK_THAT(warningsOf(json)[0], ContainsSubstring("of its points in mcap go on"));
  json["ego"]["trajectory"] = {{"waypoints", {waypoint(0, 0, 0, 0)}}};
  json["duration"] = 1;
  REQUIRE(warningsOf(json).size() == 1);
  CHECK_THAT(warningsOf(json)[0], ContainsSubstring("effects: turn object-motion off,"));
  json["sensors"][1]["ignores"] = {"car-1", "person-1"};  // the person stands, and comes and goes
  CHECK(warningsOf(json).empty());

  // Scans are from 0.05 to 0.15 s, from 0.25 to 0.35 s and so on.
  const auto stations = [&](double left, double arrived) {
    Json waypoints = {waypoint(0, -2, 0, 0), waypoint(left, -2, 0, 0), waypoint(arrived, 2, 0, 0),
                      waypoint(1, 2, 0, 0)};
    json["ego"]["trajectory"] = {{"waypoints", waypoints}};
    return warningsOf(json).size();
  };
  CHECK(stations(0.16, 0.24) == 0);
  CHECK(stations(0.14, 0.24) == 1);
  CHECK(stations(0.16, 0.26) == 1);
  CHECK(stations(0.01, 0.06) == 1);
  CHECK(stations(0.16, 0.64) == 1);  // two scans long

  json.erase("duration");
  json["ego"] = smallDrive()["ego"];
  json["outputs"] = {{{"format", "kitti"}, {"sensors", {"side"}}}, {{"format", "mcap"}, {"sensors", {"top"}}}};
  CHECK(warningsOf(json).empty());  // KITTI's points have no times
}

TEST_CASE("speeds of actors that effects turn off are warned of where they are written") {
  Json json = quietDrive();
  json["weather"] = Json::array();
  json["sensors"][1]["effects"] = {{"object-motion", {{"use", "off"}}}};
  json["outputs"] = {{{"format", "npy"}, {"fields", "x,y,z,radial_speed"}}};
  CHECK(warningsOf(json) ==
        Warnings{"sensors[1].effects: turn object-motion off, so radial_speed and velocity of 'side' have no speeds of "
                 "actors; \"use\": \"auto\" lets them move"});
  json["outputs"][0]["fields"] = "velocity,time";
  CHECK(warningsOf(json) ==
        Warnings{"sensors[1].effects: turn object-motion off, so a scan of 'side' shows its start alone, although the "
                 "times of its points in npy go on to 0.1 s, and radial_speed and velocity of 'side' have no speeds of "
                 "actors; \"use\": \"auto\" lets them move"});
  json["outputs"][0]["fields"] = "x,y,z";
  CHECK(warningsOf(json).empty());
  json["outputs"] = {{{"format", "npy"}, {"fields", "velocity"}, {"sensors", {"top"}}}};
  CHECK(warningsOf(json).empty());
  json["outputs"][0].erase("sensors");
  json["actors"] = Json::array();
  CHECK(warningsOf(json).empty());
  json["sensors"][1]["effects"] = {{"sensor-motion", {{"use", "off"}}}};  // a sensor measures its own speed even so
  CHECK(warningsOf(json).empty());
}

TEST_CASE("an actor that stands with any angle does not move") {
  Json json = quietDrive();
  json["start"] = 0.3;  // between two waypoints, where orientations are interpolated
  json["sensors"][1]["offset"] = 0;
  json["sensors"][0]["sensor"].erase("rotation_period");
  json["outputs"][0]["fields"] = "x,y,z,range,radial_speed,class,instance";
  json["outputs"][0]["sensors"] = {"top"};
  json["actors"].erase(1);
  Json& waypoints = json["actors"][0]["trajectory"]["waypoints"];
  CHECK(warningsOf(json).size() == 1);
  for (double yaw = 0; yaw < 180; yaw += 3.3) {
    CAPTURE(yaw);
    waypoints = {waypoint(0, 3, 3, 0.75), waypoint(0.7, 3, 3, 0.75)};
    for (Json& one : waypoints) one["yaw_deg"] = yaw;
    CHECK(warningsOf(json).empty());
  }
}
