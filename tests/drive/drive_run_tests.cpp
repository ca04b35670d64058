// SPDX-License-Identifier: Apache-2.0
// Frames of a drive: what is in them, and that nothing but the drive file decides it.
#include <algorithm>
#include <array>
#include <catch2/matchers/catch_matchers_exception.hpp>
#include <catch2/matchers/catch_matchers_floating_point.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <sstream>
#include <tuple>

#include "drive/pose_math.hpp"
#include "drive_support.hpp"
#include "no_more_threads.hpp"
#include "npy_rows.hpp"
#include "support.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring, Catch::Matchers::EndsWith, Catch::Matchers::MessageMatches,
    Catch::Matchers::StartsWith;
using Catch::Matchers::WithinAbs, Catch::Matchers::WithinRel;

TEST_CASE("a vertex that no triangle of a model uses does not change the size of its actor") {
  const DriveFolder folder;
  put(folder / "stray.obj",
      std::string("v 100 -50 30\n") + "v -0.5 -0.5 -0.5\nv 0.5 -0.5 -0.5\nv 0 0.5 0.5\nf 2 3 4\n");
  put(folder / "plain.obj", "v -0.5 -0.5 -0.5\nv 0.5 -0.5 -0.5\nv 0 0.5 0.5\nf 1 2 3\n");
  Json json = smallDrive();
  json["outputs"] = {{{"format", "boxes"}}, {{"format", "npy"}}};
  std::map<std::string, std::string> boxes;
  for (const std::string model : {"stray", "plain"}) {
    json["models"]["cube"]["file"] = model + ".obj";
    folder.run(json, model);
    boxes[model] = folder.get(model + "/boxes/top/000005.jsonl") + folder.get(model + "/npy/top/000005.npy");
  }
  CHECK(boxes["stray"] == boxes["plain"]);
}

TEST_CASE("points have the classes and objects of what they lie on, and objects keep their numbers") {
  const DriveFolder folder;
  Json json = smallDrive();
  json["weather"] = Json::array();
  json["sensors"][0]["effects"] = "auto";
  const drive::RunReport report = folder.run(json);
  CHECK(report.finished);
  CHECK(report.chosen == 10);
  CHECK(report.scans == 15);
  const Json objects = Json::parse(folder.get("out/objects.json"));
  REQUIRE(objects.size() == 3);
  std::set<int> framesWithPerson;
  for (int scan = 0; scan < 10; ++scan) {
    INFO("scan " << scan);
    const std::vector<Row> rows = rowsOf(folder.get("out/npy/top/00000" + std::to_string(scan) + ".npy"));
    REQUIRE(rows.size() > 300);
    for (const Row& row : rows) {
      // The sensor drives along x at 4 m/s, 1.8 m above the floor, and its points have the frame of their moment.
      const double now = 0.1 * scan + row.time, x = -2 + 4 * now + row.x, z = 1.8 + row.z;
      CHECK(std::abs(std::hypot(row.x, row.y, row.z) - row.range) < 1e-4);
      if (row.category == 40) {
        CHECK(row.instance == 0);
        CHECK_THAT(z, WithinAbs(0, 1e-4));
      } else if (row.category == 10) {
        CHECK(row.instance == 1);
        const double inCar[] = {x - (3 + 5 * now), row.y - 3.0, z - 0.75}, half[] = {2, 1, 0.75};
        double outside = -1;
        for (int axis = 0; axis < 3; ++axis) outside = std::max(outside, std::abs(inCar[axis]) - half[axis]);
        CHECK_THAT(outside, WithinAbs(0, 1e-3));  // on the surface of the car where it is at that moment
      } else {
        CHECK(row.category == 30);
        CHECK(row.instance == 2);
        framesWithPerson.insert(scan);
      }
    }
  }
  CHECK(framesWithPerson == std::set<int>{3, 4, 5, 6});  // there from 0.25 s to 0.65 s
}

TEST_CASE("a drive has the same bytes in one run, in shards and in parts, and complete frames are not made again") {
  const DriveFolder folder;
  Json json = smallDrive();
  json["outputs"] = everyOutput();
  const drive::Drive drive = folder.read(json);
  CHECK(drive::run(drive, optionsFor(folder / "whole")).finished);
  for (uint64_t shard : {2, 0, 3, 1}) {
    drive::RunOptions options = optionsFor(folder / "shards");
    options.shard = shard;
    options.shardCount = 4;
    const drive::RunReport report = drive::run(drive, options);
    CHECK(report.chosen == (shard < 2 ? 3 : 2));
    CHECK(report.finished == (shard == 1));
  }
  checkSameFiles(folder / "whole", folder / "shards");

  drive::RunOptions part = optionsFor(folder / "parts");
  part.firstFrame = 6;
  CHECK_FALSE(drive::run(drive, part).finished);
  part.firstFrame = 4;
  part.endFrame = 8;
  const drive::RunReport overlap = drive::run(drive, part);
  CHECK(overlap.chosen == 4);
  CHECK(overlap.kept == 2);
  const drive::RunReport rest = drive::run(drive, optionsFor(folder / "parts"));
  CHECK(rest.kept == 6);
  CHECK(rest.finished);
  checkSameFiles(folder / "whole", folder / "parts");

  const drive::RunReport again = drive::run(drive, optionsFor(folder / "parts"));
  CHECK(again.kept == 10);
  CHECK(again.device.empty());  // nothing was scanned
}

TEST_CASE("an actor that goes beyond the range of floats within a scan takes nothing else with it") {
  const DriveFolder folder;
  Json json = smallDrive();
  json["duration"] = 0.1;
  json["outputs"] = {{{"format", "npy"}, {"sensors", {"top"}}, {"fields", "x,y,z,range,time,class,instance"}}};
  const Json car = json["actors"][0];
  json["actors"] = Json::array();
  folder.run(json, "without");
  json["actors"] = {car};
  json["actors"][0]["trajectory"]["waypoints"][1]["position"] = {8, 1e300, 0.75};
  REQUIRE(folder.run(json).finished);
  CHECK(folder.get("out/npy/top/000000.npy") == folder.get("without/npy/top/000000.npy"));
}

TEST_CASE("a run warns of an effect that the accuracy of the drive leaves out") {
  needVulkan();
  const DriveFolder folder;
  Json json = smallDrive();
  json["sensors"].erase(json["sensors"].begin() + 1, json["sensors"].end());
  json["sensors"][0]["effects"] = "auto";
  json["weather"] = Json::array();  // whose kernels take long to compile
  drive::RunOptions options;
  options.out = folder / "warned";
  options.endFrame = 1;
  options.simulator = vulkanOptions();
  std::vector<std::string> warnings;
  options.simulator.warn = [&](const std::string& warning) { warnings.push_back(warning); };
  json["accuracy"] = "exact";
  run(folder.read(json), options);
  REQUIRE(warnings.size() == 2);
  CHECK(warnings[0] == "sensor '" + json["sensors"][0]["name"].get<std::string>() +
                           "': sensor-motion is left out: motion within a scan needs accuracy standard");
  CHECK_THAT(warnings[1], ContainsSubstring("object-motion is left out: motion within a scan needs accuracy standard"));
  warnings.clear();
  options.out = folder / "speeds";
  json["outputs"] = {{{"format", "npy"}, {"fields", "radial_speed"}}};
  run(folder.read(json), options);
  REQUIRE(warnings.size() == 2);
  CHECK_THAT(warnings[1], EndsWith(", so radial_speed and velocity have no speeds of what moves in the scene"));
  warnings.clear();
  options.out = folder / "unwarned";
  json["accuracy"] = "standard";
  run(folder.read(json), options);
  CHECK(warnings.empty());
}

TEST_CASE("options that change clouds are those of the drive file alone") {
  const DriveFolder folder;
  const drive::Drive drive = folder.read(smallDrive());
  const auto refused = [&](const auto& change, const std::string& words) {
    drive::RunOptions options = optionsFor(folder / "out");
    change(options.simulator);
    CHECK_THROWS_WITH(run(drive, options),
                      "RunOptions: simulator: " + words + " changes the clouds, so it belongs into the drive file");
    CHECK_FALSE(fs::exists(options.out));
  };
  refused([](SimulatorOptions& options) { options.faces = ReflectingFaces::front; }, "faces");
  refused([](SimulatorOptions& options) { options.accuracy = Accuracy::exact; }, "accuracy");
  refused([](SimulatorOptions& options) { options.materials.rows = {{"floor", 0.5f}}; }, "a material table");
}

TEST_CASE("a shard that there is not and an empty range of frames are refused before anything is written") {
  const DriveFolder folder;
  const drive::Drive drive = folder.read(smallDrive());
  const auto refused = [&](const drive::RunOptions& options, const std::string& words) {
    CHECK_THROWS_WITH(drive::run(drive, options), Catch::Matchers::StartsWith("RunOptions: " + words));
    CHECK_FALSE(fs::exists(options.out));
  };
  drive::RunOptions options = optionsFor(folder / "out");
  options.shardCount = 0;
  refused(options, "there is no shard 0 of 0");
  options.shardCount = options.shard = 4;
  refused(options, "there is no shard 4 of 4");
  options.shard = 3;
  options.firstFrame = options.endFrame = 5;
  refused(options, "the first frame is 5; it must be less than the end, 5");
  options.firstFrame = 10;
  options.endFrame = 12;
  refused(options, "the drive has the frames 0 to 9, so 10:12 is none");
}

TEST_CASE("a device that is not there leaves a folder as it is") {
  const DriveFolder folder;
  const drive::Drive drive = folder.read(smallDrive());
  const fs::path out = folder / "out";
  drive::RunOptions absent = optionsFor(out);
  absent.simulator.device = deviceByName("no device has this name");
  const auto isRefused = [&] { CHECK_THROWS_AS(drive::run(drive, absent), Error); };
  isRefused();
  CHECK_FALSE(fs::exists(out));
  fs::create_directory(out);
  isRefused();
  CHECK(fs::is_empty(out));
  // A drive that was finished stays so until a frame is made.
  REQUIRE(drive::run(drive, optionsFor(out)).finished);
  fs::remove(out / "manifest/frames/000003.json");
  const auto before = filesOf(out);
  isRefused();
  CHECK(filesOf(out) == before);
}

TEST_CASE("a run whose thread for writing cannot be started is refused, and can be repeated") {
  const DriveFolder folder;
  const Json json = smallDrive();
  {
    const NoMoreThreads none;
    CHECK_THROWS_MATCHES(
        folder.run(json), Error,
        MessageMatches(StartsWith("a drive: the thread that writes or publishes frames cannot be started (Resource "
                                  "temporarily unavailable)") &&
                       ContainsSubstring("raise the limits")));
  }
  CHECK(folder.run(json).finished);
}

TEST_CASE("a folder with frames of another drive is refused, and so is this drive after a change") {
  const DriveFolder folder;
  folder.run(smallDrive());
  Json json = smallDrive();
  json["seed"] = 2;
  CHECK_THROWS_WITH(folder.run(json), Catch::Matchers::ContainsSubstring("holds frames of another drive"));
  put(folder / "cube.obj", std::string(kCube) + "f 1 2 3\n");  // the drive file is the same, a model is not
  CHECK_THROWS_WITH(folder.run(smallDrive()), Catch::Matchers::ContainsSubstring("holds frames of another drive"));
}

TEST_CASE("a folder that holds a shorter drive, and is else of this one, tells both durations") {
  const DriveFolder folder;
  Json json = smallDrive();
  json["duration"] = 0.3;
  folder.run(json);
  json["duration"] = 0.5;
  CHECK_THROWS_WITH(folder.run(json),
                    ContainsSubstring("out: holds frames of this drive with a duration of 0.3 s, and it "
                                      "now has a duration of 0.5 s; a drive that has begun keeps its "
                                      "duration, so choose another folder or the old duration"));
  json.erase("duration");
  CHECK_THROWS_WITH(folder.run(json), ContainsSubstring("it now has the duration of the vehicle's trajectory"));
  json["seed"] = 2;
  CHECK_THROWS_WITH(folder.run(json), ContainsSubstring("holds frames of another drive"));
  json.erase("seed");
  put(folder / "cube.obj", std::string(kCube) + "f 1 2 3\n");  // a model is another one, too
  CHECK_THROWS_WITH(folder.run(json), ContainsSubstring("holds frames of another drive"));
}

TEST_CASE("clouds of a drive that are not compact have every beam, and why it has no return") {
  const DriveFolder folder;
  Json json = smallDrive();
  json["duration"] = 0.1;
  json["outputs"] = {{{"format", "npy"}, {"sensors", {"top"}}, {"fields", "x,y,z,range,cause"}, {"compact", false}},
                     {{"format", "pcd"}, {"sensors", {"top"}}, {"fields", "x,y,z,range"}}};
  folder.run(json);
  const Scan whole = readCloud(folder / "out/npy/top/000000.npy"),
             compact = readCloud(folder / "out/pcd/top/000000.pcd");
  const Sensor head = sensorFromJson(smallHead().dump(), "head");
  CHECK(whole.columns == head.columns);
  REQUIRE(whole.channels == head.channels.size());
  CHECK(whole.counters.misses > 10);
  CHECK(compact.beamCount() == whole.counters.hits);
  const auto causes = whole.column<uint8_t>(Field::cause);
  for (size_t beam = 0; beam < whole.beamCount(); ++beam)
    CHECK(whole.returned(beam) == (causes[beam] == static_cast<uint8_t>(Cause::returned)));
  json["outputs"] = {{{"format", "las"}, {"compact", false}}};
  CHECK_THROWS_WITH(folder.read(json),
                    Catch::Matchers::ContainsSubstring("outputs[0].compact: is only for pcd and npy"));
}

TEST_CASE("a material table of a drive gives reflectances to the materials of its scenes and models") {
  const DriveFolder folder;
  put(folder / "floor.obj", "usemtl asphalt\n" + std::string(kFloor));
  put(folder / "cube.obj", "usemtl paint\n" + std::string(kCube));
  Json json = smallDrive();
  json["material_table"] = "lidar.json";
  json["weather"] = Json::array();
  json["duration"] = 0.1;
  json["sensors"][0]["effects"] = {{"intensity", {{"use", "on"}}}};
  json["outputs"] = {{{"format", "npy"}, {"sensors", {"top"}}, {"fields", "intensity,class"}}};
  /// The intensities of points of a class, in the order of the beams.
  const auto intensities = [&](double asphalt, double paint, uint16_t category) {
    put(folder / "lidar.json",
        Json{{"materials",
              {{{"name", "asphalt"}, {"reflectance_905", asphalt}}, {{"name", "paint"}, {"reflectance_905", paint}}}}}
            .dump());
    const std::string out = "out-" + std::to_string(asphalt) + "-" + std::to_string(paint);
    folder.run(json, out);
    const std::string bytes = folder.get(out + "/npy/top/000000.npy");
    uint16_t header = 0;
    std::memcpy(&header, bytes.data() + 8, 2);
    std::vector<float> chosen;
    for (size_t at = 10 + header; at + 6 <= bytes.size(); at += 6) {
      uint16_t own = 0;
      std::memcpy(&own, bytes.data() + at + 4, 2);
      if (own != category) continue;
      chosen.emplace_back();
      std::memcpy(&chosen.back(), bytes.data() + at, 4);
    }
    return chosen;
  };
  // A Lambertian surface has an intensity in proportion to its reflectance.
  for (const auto& [category, factor] : {std::pair<uint16_t, float>{40, 2}, {10, 3}}) {
    const std::vector<float> dark = intensities(0.25, 0.125, category), light = intensities(0.5, 0.375, category);
    REQUIRE(dark.size() > 10);
    REQUIRE(light.size() == dark.size());
    for (size_t i = 0; i < dark.size(); ++i) CHECK_THAT(light[i], WithinRel(factor * dark[i], 1e-5f));
  }

  const std::string before = folder.read(json).fingerprint;
  put(folder / "lidar.json", R"({"materials": [{"name": "asphalt", "roughness": 0.5}, {"name": "glas", "retro": 1}]})");
  const drive::Drive changed = folder.read(json);
  CHECK(changed.fingerprint != before);
  CHECK(changed.warnings == std::vector<std::string>{"material_table: no scene or model has the material 'glas'"});
  drive::RunOptions options = optionsFor(folder / "quiet");
  std::vector<std::string> warnings;
  options.simulator.warn = [&](const std::string& warning) { warnings.push_back(warning); };
  drive::run(changed, options);
  for (const std::string& warning : warnings) CHECK_THAT(warning, !ContainsSubstring("material"));  // it was told above
  put(folder / "lidar.json", R"({"materials": [{"name": "asphalt", "reflectance_905": 2}]})");
  CHECK_THROWS_WITH(folder.read(json), ContainsSubstring("drive.json: material_table: ") &&
                                           ContainsSubstring("reflectance_905 must be 0..1, is 2"));
}

TEST_CASE("weather comes when the drive says so, and only to sensors that it can reach") {
  const DriveFolder folder;
  Json json = smallDrive(), dry = smallDrive();
  json["sensors"][0]["effects"] = dry["sensors"][0]["effects"] = "auto";
  dry["weather"] = {{{"time", 0}}};
  folder.run(json, "rain");
  folder.run(dry, "dry");
  const auto same = [&](const std::string& file) {
    return folder.get("rain/npy/" + file) == folder.get("dry/npy/" + file);
  };
  CHECK(same("top/000004.npy"));
  CHECK_FALSE(same("top/000005.npy"));
  CHECK(same("side/000004.npy"));  // at 0.85 s, but its effects are "clean"
}

TEST_CASE("a sensor keeps its dust, and its own fog, rain and snow where the weather of the drive states none") {
  const DriveFolder folder;
  Json json = smallDrive();
  json["outputs"][0]["sensors"] = {"top"};
  json["duration"] = 0.1;
  const auto cloud = [&](const Json& effects, const Json& weather, const std::string& name) {
    json["sensors"][0]["effects"] = effects;
    json["weather"] = weather;
    folder.run(json, name);
    return folder.get(name + "/npy/top/000000.npy");
  };
  const Json clear = {{"divergence", {{"use", "off"}}}};
  const auto with = [&](const char* effect, const Json& parameters) {
    Json effects = clear;
    effects[effect] = parameters;
    return effects;
  };
  const Json dust = with("volumes", {{"boxes", {{{"min", {-9, -9, 0}}, {"max", {9, 9, 3}}, {"extinction", 0.5}}}}});
  const Json fog = with("fog", {{"visibility", 10}}), rain = with("rain", {{"rate", 80}}),
             snow = with("snow", {{"rate", 20}});
  const Json none = Json::array(), dry = {{{"time", 0}, {"rain", 0}}}, calm = {{{"time", 0}, {"snow", 0}}};
  const std::string empty = cloud(clear, none, "empty");
  for (const auto& [name, effects, weather] : {std::tuple{"dust", dust, dry},
                                               {"fog", fog, dry},
                                               {"rain", rain, calm},
                                               {"snow", snow, dry},
                                               {"entry of a time alone", fog, {{{"time", 0}}}}}) {
    INFO(name);
    const std::string own = cloud(effects, none, name + std::string(" alone"));
    CHECK((own != empty));
    CHECK((cloud(effects, weather, name + std::string(" and weather")) == own));
  }
  CHECK((cloud(rain, dry, "replaced") == empty));
}

/// The bounds along x in the header of a file of LAS 1.4.
std::pair<double, double> boundsOfX(const std::string& las) {
  double bounds[2];  // the largest, then the least
  std::memcpy(bounds, las.data() + 179, sizeof(bounds));
  return {bounds[1], bounds[0]};
}

TEST_CASE("points and boxes are where a scan finds them if the accuracy leaves out motion within it") {
  needVulkan();  // the reference leaves nothing out
  const DriveFolder folder;
  put(folder / "wall.obj", "v 6 -3 -3\nv 6 3 -3\nv 6 3 3\nv 6 -3 3\nf 1 2 3\nf 1 3 4\n");
  Json json = smallDrive();
  json["scenes"] = {{{"file", "wall.obj"}}};
  json["actors"] = {json["actors"][0]};
  json["actors"][0]["trajectory"] = {{"waypoints", {waypoint(0, 0, 3, 1.5), waypoint(1, 10, 3, 1.5)}}};
  json["ego"]["trajectory"] = {{"waypoints", {waypoint(0, 0, 0, 0), waypoint(1, 30, 0, 0)}}};
  json["weather"] = Json::array();
  json["duration"] = 0.1;
  json["outputs"] = {{{"format", "las"}, {"sensors", {"top"}}}, {{"format", "boxes"}, {"sensors", {"top"}}}};
  for (const char* accuracy : {"standard", "exact"}) {
    INFO(accuracy);
    json["accuracy"] = accuracy;
    json["sensors"][0]["effects"] = {{"object-motion", {{"use", "auto"}}}, {"divergence", {{"use", "off"}}}};
    const std::string out = accuracy;
    drive::RunOptions options;
    options.out = folder / out;
    options.simulator = vulkanOptions();
    run(folder.read(json), options);
    Json box;
    std::istringstream(folder.get(out + "/boxes/top/000000.jsonl")) >> box;
    const bool moves = out == "standard";
    const double seenAt = box["time"];
    CHECK((seenAt > 0) == moves);
    // The car is at 10 t, and the sensor at 30 t, if they move within the scan.
    CHECK_THAT(box["sensor_frame"]["position"][0].get<double>(), WithinAbs(-20 * seenAt, 1e-6));
    const auto [least, most] = boundsOfX(folder.get(out + "/las/top/000000.las"));
    CHECK_THAT(most, WithinAbs(6, 0.002));
  }
}

TEST_CASE("a sensor beside the middle of a vehicle that turns goes along an arc within a scan") {
  const DriveFolder folder;
  put(folder / "wall.obj", "v 6 -9 -3\nv 6 9 -3\nv 6 9 3\nv 6 -9 3\nf 1 2 3\nf 1 3 4\n");
  Json json = smallDrive();
  json["scenes"] = {{{"file", "wall.obj"}}};
  json["actors"] = Json::array();
  Json end = waypoint(1, 0, 0, 0);
  end["yaw_deg"] = 170;
  json["ego"]["trajectory"] = {{"waypoints", {waypoint(0, 0, 0, 0), end}}};
  json["rate"] = 1;
  json["duration"] = 1;
  json["weather"] = Json::array();
  json["sensors"] = {json["sensors"][0]};
  json["sensors"][0]["sensor"]["rotation_period"] = 1;
  json["sensors"][0]["sensor"]["columns"] = 720;
  json["sensors"][0]["effects"] = {{"divergence", {{"use", "off"}}}};
  json["sensors"][0]["mount"] = {{"position", {3, 0, 0}}};
  json["outputs"] = {{{"format", "las"}}};
  folder.run(json);
  const auto [least, most] = boundsOfX(folder.get("out/las/top/000000.las"));
  CHECK_THAT(least, WithinAbs(6, 0.0011));
  CHECK_THAT(most, WithinAbs(6, 0.0011));
}

TEST_CASE("beams that fire before the start and after the end of a scan leave from where the sensor is then") {
  const DriveFolder folder;
  Json json = smallDrive();
  json["actors"] = Json::array();
  json["weather"] = Json::array();
  json["ego"]["trajectory"] = {{"waypoints", {waypoint(0, 0, 0, 0), waypoint(1, 0, 0, 10)}}};  // upwards
  json["sensors"] = {json["sensors"][0]};
  json["sensors"][0]["sensor"]["time_offset"] = {-0.09, 0.09, -0.05, 0.05, -0.01, 0.01, 0, 0};
  json["sensors"][0]["effects"] = "auto";
  folder.run(json);
  size_t before = 0, after = 0;
  for (int scan = 1; scan < 8; ++scan) {  // the sensor stands before 0 s and after 1 s
    for (const Row& row : rowsOf(folder.get("out/npy/top/00000" + std::to_string(scan) + ".npy"))) {
      before += row.time < 0;
      after += row.time > 0.1;
      CHECK_THAT(-row.z, WithinAbs(1.8 + 10 * (0.1 * scan + row.time), 2e-4));
    }
  }
  CHECK(before > 100);
  CHECK(after > 100);
}

TEST_CASE("a sensor that fires all beams at once measures the speed of its vehicle") {
  const DriveFolder folder;
  Json json = smallDrive();
  json["weather"] = Json::array();
  json["sensors"] = {json["sensors"][0]};
  json["ego"]["trajectory"] = {{"waypoints", {waypoint(0, -2, 0, 0), waypoint(0.4, -0.4, 0, 0), waypoint(1, 5, 0, 0)}}};
  json["sensors"][0]["sensor"].erase("rotation_period");
  json["sensors"][0]["effects"] = "auto";
  json["outputs"] = {{{"format", "npy"}, {"fields", "x,y,z,range,radial_speed,class,instance"}}};
  const drive::Drive drive = folder.read(json);
  REQUIRE(drive.warnings.size() == 1);
  CHECK_THAT(drive.warnings[0], StartsWith("sensors[0].sensor: all beams of 'top' fire at once") &&
                                    ContainsSubstring("have no speeds of actors"));
  folder.run(json);
  // m/s along x: between 0.05 s before and 0.05 s after a scan, or on one side of the trajectory's ends.
  for (const auto& [scan, speed] : {std::pair("000000", 4.0), std::pair("000004", 6.5), std::pair("000009", 9.0)}) {
    const std::vector<Row> rows = rowsOf(folder.get("out/npy/top/" + std::string(scan) + ".npy"));
    CHECK(rows.size() > 300);
    for (const Row& row : rows) CHECK_THAT(row.time, WithinAbs(-speed * row.x / row.range, 1e-4));
  }
}

TEST_CASE("a sensor that fires all beams at once measures the speed of a vehicle on a circle, wherever it is mounted") {
  constexpr double kRadius = 40, kTurn = 0.3;  // m, rad/s
  const DriveFolder folder;
  Json json = smallDrive(), waypoints = Json::array();
  for (int i = 0; i <= 25; ++i) {
    const double time = 0.02 * i, angle = kTurn * time;
    waypoints.push_back(waypoint(time, kRadius * std::sin(angle), kRadius * (1 - std::cos(angle)), 0));
    waypoints.back()["yaw_deg"] = angle / M_PI * 180;
  }
  json["ego"]["trajectory"] = {{"waypoints", waypoints}};
  json["duration"] = 0.4;
  json["weather"] = json["actors"] = Json::array();
  json["scenes"][0]["pose"] = {{"position", {0, 0, -1.8}}};
  json["sensors"] = {json["sensors"][0]};
  json["sensors"][0]["sensor"].erase("rotation_period");
  json["sensors"][0]["effects"] = "auto";
  json["outputs"] = {{{"format", "npy"}, {"fields", "x,y,z,range,radial_speed,class,instance"}}};
  for (const double arm : {0.0, 0.5, 1.0, 1.5, 3.0, 6.0}) {
    CAPTURE(arm);
    const std::string out = "out" + std::to_string(static_cast<int>(10 * arm));
    json["sensors"][0]["mount"]["position"] = {arm, 0, 0};
    folder.run(json, out);
    const std::vector<Row> rows = rowsOf(folder.get(out + "/npy/top/000002.npy"));
    CHECK(rows.size() > 300);
    const double ahead = kTurn * kRadius, left = kTurn * arm;  // m/s along the axes of the vehicle
    double worst = 0;
    for (const Row& row : rows)
      worst = std::max(worst, std::abs(row.time + (ahead * row.x + left * row.y) / row.range));
    CHECK(worst < 2e-3);
  }
}

TEST_CASE("a run warns once per sensor of an actor that turns far within a scan, unless the sensor ignores it") {
  const DriveFolder folder;
  Json json = smallDrive();
  json["weather"] = Json::array();
  Json& waypoints = json["actors"][0]["trajectory"]["waypoints"];
  int runs = 0;
  const auto warnings = [&] {
    std::vector<std::string> texts;
    drive::RunOptions options = optionsFor(folder / ("out" + std::to_string(runs++)));
    options.simulator.warn = [&](const std::string& text) { texts.push_back(text); };
    drive::run(folder.read(json), options);
    std::erase_if(texts, [](const std::string& text) { return text.find(" turns by ") == text.npos; });
    return texts;
  };
  waypoints[1]["yaw_deg"] = 90;  // by 9 degrees within a scan, which leads a corner of the car 7 mm off
  CHECK(warnings().empty());
  for (int i = 1; i <= 20; ++i) {  // by 60 degrees within a scan
    waypoints[i] = waypoint(0.05 * i, 3, 3, 0.75);
    waypoints[i]["yaw_deg"] = 30 * i;
  }
  waypoints[0] = waypoint(0, 3, 3, 0.75);
  waypoints[0]["yaw_deg"] = 0;
  // A corner is sqrt(5) m from the axis: 2.236 * (1 - cos 30 deg) = 0.30 m.
  CHECK(
      warnings() ==
      std::vector<std::string>{
          "within scan 0 of 'top' the actor 'car-1' turns by 60 degrees, and its points, which go straight from where "
          "they are at the start to where they are at the end of a scan, are up to 0.3 m off their ways; "
          "shorter scans keep nearer to them"});
  for (int i = 1; i <= 20; ++i) waypoints[i]["yaw_deg"] = 170 * i;  // almost a turn in a scan
  CHECK(warnings().size() == 1);
  // Ninety turns a second are a whole number of turns in a scan, and nearly one in an eighth of it.
  for (int i = 0; i <= 1000; ++i) {
    waypoints[i] = waypoint(0.001 * i, 3, 3, 0.75);
    waypoints[i]["yaw_deg"] = std::fmod(0.36 * 90 * i, 360);
  }
  const std::vector<std::string> turns = warnings();
  REQUIRE(turns.size() == 1);
  CHECK_THAT(turns[0], ContainsSubstring("turns by 3240 degrees"));
  json["sensors"][0]["ignores"] = {"car-1"};
  CHECK(warnings().empty());  // the sensor 'side' leaves motion out
}
