// SPDX-License-Identifier: Apache-2.0
// The formats of a drive, byte by byte as their specifications have them, without any code of ours but the runner.
#include <algorithm>
#include <catch2/matchers/catch_matchers_floating_point.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <sstream>
#include <tuple>

#include "drive/fingerprint.hpp"
#include "drive_support.hpp"
#include "npy_rows.hpp"
#include "support.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::StartsWith;
using Catch::Matchers::WithinAbs;

namespace {

std::vector<std::vector<double>> numbersOf(const std::string& text) {
  std::vector<std::vector<double>> rows;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    rows.emplace_back();
    for (double number; words >> number;) rows.back().push_back(number);
  }
  return rows;
}

}  // namespace

TEST_CASE("KITTI odometry: points, times, and poses of a camera that looks ahead") {
  const DriveFolder& folder = made();
  const std::string sequence = "out/kitti/sequences/00/";
  const std::string points = folder.get(sequence + "velodyne/000002.bin");
  REQUIRE(points.size() % 16 == 0);
  REQUIRE(points.size() > 300 * 16);
  for (size_t i = 0; i < points.size(); i += 16) {
    const float intensity = at<float>(points, i + 12);
    CHECK((intensity >= 0 && intensity <= 1));
  }
  const auto times = numbersOf(folder.get(sequence + "times.txt")),
             poses = numbersOf(folder.get("out/kitti/poses/00.txt"));
  REQUIRE(times.size() == 10);
  REQUIRE(poses.size() == 10);
  CHECK_THAT(times[3][0], WithinAbs(0.3, 1e-9));
  // 1.2 m ahead after 0.3 s: along the camera's z.
  const double wanted[] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1.2};
  for (size_t i = 0; i < 12; ++i) CHECK_THAT(poses[3][i], WithinAbs(wanted[i], 1e-9));
  // "Tr" maps the lidar's frame to the camera's: ahead becomes z, left becomes -x, up becomes -y.
  CHECK_THAT(folder.get(sequence + "calib.txt"), Catch::Matchers::EndsWith("Tr: 0 -1 0 0 0 0 -1 0 1 0 0 0\n") &&
                                                     Catch::Matchers::StartsWith("P0: 1 0 0 0"));
}

TEST_CASE("poses and calibrations are those of a lidar beside the middle of a vehicle that turns") {
  constexpr double kTurnRate = 2;  // rad/s
  const DriveFolder folder;
  Json json = smallDrive();
  json["weather"] = json["actors"] = Json::array();
  Json& waypoints = json["ego"]["trajectory"]["waypoints"] = Json::array();
  for (int i = 0; i <= 10; ++i) {
    waypoints.push_back(waypoint(0.1 * i, 0, 0, 0));
    waypoints.back()["yaw_deg"] = 0.1 * i * kTurnRate * 180 / M_PI;
  }
  json["sensors"] = {json["sensors"][0]};
  json["sensors"][0]["mount"] = {{"position", {1, 0, 0.5}}, {"yaw_pitch_roll_deg", {90, 0, 0}}};
  json["outputs"] = {{{"format", "kitti"}}, {{"format", "kitti-raw"}}, {{"format", "npy"}}, {{"format", "boxes"}}};
  REQUIRE(folder.run(json).finished);
  const auto relative = numbersOf(folder.get("out/kitti/poses/00.txt")),
             world = numbersOf(folder.get("out/npy/top/poses.txt"));
  CHECK(folder.get("out/boxes/top/poses.txt") == folder.get("out/npy/top/poses.txt"));
  CHECK(folder.get("out/kitti/sequences/00/poses.txt") == folder.get("out/kitti/poses/00.txt"));
  REQUIRE(relative.size() == 10);
  REQUIRE(world.size() == 11);  // the first line is a comment
  for (size_t i = 0; i < 10; ++i) {
    CAPTURE(i);
    const double time = 0.1 * static_cast<double>(i), angle = kTurnRate * time, c = std::cos(angle),
                 s = std::sin(angle);
    const double half = (angle + M_PI / 2) / 2;
    const double place[] = {time, c, s, 0.5, 0, 0, std::sin(half), std::cos(half)};
    for (size_t k = 0; k < 8; ++k) CHECK_THAT(world[i + 1][k], WithinAbs(place[k], 1e-8));
    // The turn to the left is about the y axis of the camera, which points down, and the lidar looks along its way.
    const double moved[] = {c, 0, -s, c - 1, 0, 1, 0, 0, s, 0, c, s};
    for (size_t k = 0; k < 12; ++k) CHECK_THAT(relative[i][k], WithinAbs(moved[k], 1e-8));
  }
  const auto calibration = [&](const char* file, const char* part) {
    const std::string text = folder.get(std::string("out/kitti-raw/1970_01_01/") + file);
    const size_t begin = text.find(std::string("\n") + part + ": ") + 4;
    return numbersOf(text.substr(begin, text.find('\n', begin) - begin)).at(0);
  };
  const auto check = [](const std::vector<double>& found, const std::vector<double>& wanted) {
    REQUIRE(found.size() == wanted.size());
    for (size_t k = 0; k < wanted.size(); ++k) CHECK_THAT(found[k], WithinAbs(wanted[k], 1e-12));
  };
  check(calibration("calib_imu_to_velo.txt", "R"), {0, 1, 0, -1, 0, 0, 0, 0, 1});
  check(calibration("calib_imu_to_velo.txt", "T"), {0, 1, -0.5});
  check(calibration("calib_velo_to_cam.txt", "R"), {0, -1, 0, 0, 0, -1, 1, 0, 0});
  check(calibration("calib_velo_to_cam.txt", "T"), {0, 0, 0});
}

TEST_CASE("SemanticKITTI: a label per point, with the actor above and the class below") {
  const DriveFolder& folder = made();
  const std::string sequence = "out/semantickitti/sequences/00/";
  const std::string points = folder.get(sequence + "velodyne/000004.bin"),
                    labels = folder.get(sequence + "labels/000004.label");
  CHECK(points == folder.get("out/kitti/sequences/00/velodyne/000004.bin"));
  REQUIRE(labels.size() * 4 == points.size());
  std::map<uint32_t, int> counts;
  for (size_t i = 0; i < labels.size(); i += 4) {
    const auto label = at<uint32_t>(labels, i);
    ++counts[label];
    CHECK((label == 40) == (at<float>(points, 4 * i + 8) < -1.79));  // on the floor
  }
  CHECK(counts.size() == 3);
  CHECK(counts[252 | 1 << 16] > 0);  // the car moves
  CHECK(counts[30 | 2 << 16] > 0);   // the person stands
}

namespace {

/// Writes a map and a cube. The map is one mesh, with strips along x: asphalt and paint without a class, and grass of
/// class `grass`. The side of the cube towards -x is glass.
void putMaterialFiles(const DriveFolder& folder, uint16_t grass) {
  MeshBuilder strips, cube;
  for (const auto& [from, to] : {std::pair(-20, -1), {-1, 2}, {2, 20}})
    strips.quad({double(from), -20, 0}, {double(to - from), 0, 0}, {0, 40, 0});
  cube.box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5});
  Scene map = sceneOf(strips.take()), van = sceneOf(cube.take());
  map.materials.resize(3);
  map.materials[0].name = "asphalt 1";
  map.materials[1].name = "paint";
  map.materials[2].classId = grass;
  map.meshes[0].parts = {{0, 2, 0}, {2, 2, 1}, {4, 2, 2}};
  writeGlb(map, folder / "map.glb");
  van.materials.resize(2);
  van.materials[1].className = "glass";
  van.meshes[0].parts = {{0, 8, 0}, {8, 2, 1}, {10, 2, 0}};
  writeGlb(van, folder / "van.glb");
}

}  // namespace

TEST_CASE("points have the class of their material, else that of their instance; boxes have that of the actor") {
  const DriveFolder folder;
  putMaterialFiles(folder, 72);
  Json json = smallDrive();
  json["weather"] = Json::array();
  json["sensors"][0]["effects"] = "clean";
  json["classes"].update({{"road", {{"id", 41}}}, {"grass", {{"id", 72}}}, {"glass", {{"id", 5}, {"moving_id", 6}}}});
  json["scenes"] = {{{"file", "map.glb"}, {"class", "ground"}, {"materials", {{"asph*", "road"}}}}};
  json["models"] = {{"van", {{"file", "van.glb"}}}};
  json["actors"].erase(1);
  json["actors"][0]["model"] = "van";
  for (const char* format : {"semantickitti", "las", "boxes"}) json["outputs"].push_back({{"format", format}});
  REQUIRE(folder.run(json).finished);
  // At 0.4 s the sensor is at x = -0.4 m, and the van's side towards it at 3 m.
  const std::string labels = folder.get("out/semantickitti/sequences/00/labels/000004.label"),
                    las = folder.get("out/las/top/000004.las");
  const std::vector<Row> rows = rowsOf(folder.get("out/npy/top/000004.npy"));
  REQUIRE(labels.size() == 4 * rows.size());
  std::map<uint32_t, int> counts;
  for (size_t i = 0; i < rows.size(); ++i) {
    const double x = rows[i].x - 0.4, z = rows[i].z + 1.8;
    if (std::min(std::abs(x + 1), std::abs(x - 2)) < 1e-3) continue;
    const bool onVan = z > 1e-3, onGlass = onVan && std::abs(x - 3) < 1e-3;
    const int category = onGlass ? 5 : onVan ? 10 : x < -1 ? 41 : x < 2 ? 40 : 72;
    const auto label = at<uint32_t>(labels, 4 * i);
    INFO(x << ' ' << z);
    CHECK(rows[i].category == category);
    CHECK(label == (onGlass ? 6u | 1 << 16 : onVan ? 252u | 1 << 16 : static_cast<uint32_t>(category)));
    CHECK(at<uint8_t>(las, 621 + 34 * i + 16) == category);
    ++counts[label];
  }
  CHECK(counts.size() == 5);
  for (const auto& [label, count] : counts) CHECK(count > 2);
  const Json box = Json::parse(folder.get("out/boxes/top/000004.jsonl"));
  CHECK((box["class"] == "car" && box["class_id"] == 10));
  CHECK(box["points"] == counts[6 | 1 << 16] + counts[252 | 1 << 16]);

  const std::string before = folder.read(json).fingerprint;
  putMaterialFiles(folder, 73);
  CHECK(folder.read(json).fingerprint != before);
  putMaterialFiles(folder, 300);
  CHECK_THROWS_WITH(folder.read(json), ContainsSubstring("the file of material '' states the id 300"));
}

TEST_CASE("every member of an image with holes changes the fingerprint of a drive") {
  drive::Drive drive;
  drive.scenes.emplace_back().alphaImages.push_back({2, 8, std::vector<uint8_t>(16, 100)});
  AlphaImage& image = drive.scenes[0].alphaImages[0];
  std::set<std::string> fingerprints = {drive::fingerprintOf(drive, "")};
  const auto changes = [&] { return fingerprints.insert(drive::fingerprintOf(drive, "")).second; };
  std::swap(image.width, image.height);
  CHECK(changes());
  image.wrapU = AlphaImage::Wrap::mirror;
  CHECK(changes());
  image.wrapV = AlphaImage::Wrap::clamp;
  CHECK(changes());
  image.alpha[3] = 7;
  CHECK(changes());
}

TEST_CASE("the matrix of a node changes the fingerprint of a drive") {
  drive::Drive drive;
  Node& node = drive.scenes.emplace_back().animation.nodes.emplace_back();
  std::set<std::string> fingerprints = {drive::fingerprintOf(drive, "")};
  node.matrix = Transform{};
  CHECK(fingerprints.insert(drive::fingerprintOf(drive, "")).second);
  node.matrix->rows[3] = 2;
  CHECK(fingerprints.insert(drive::fingerprintOf(drive, "")).second);
}

TEST_CASE("KITTI raw data: times of the turn, and a vehicle that drives east") {
  const DriveFolder& folder = made();
  const std::string drive = "out/kitti-raw/2023_11_14/2023_11_14_drive_0001_sync/";
  CHECK(folder.get(drive + "velodyne_points/data/0000000002.bin") ==
        folder.get("out/kitti/sequences/00/velodyne/000002.bin"));
  const auto line = [&](const std::string& file, size_t number) {
    std::istringstream lines(folder.get(drive + file));
    std::string text;
    for (size_t i = 0; i <= number; ++i) std::getline(lines, text);
    return text;
  };
  CHECK(line("velodyne_points/timestamps_start.txt", 2) == "2023-11-14 22:13:20.200000000");
  CHECK(line("velodyne_points/timestamps.txt", 2) == "2023-11-14 22:13:20.250000000");
  CHECK(line("velodyne_points/timestamps_end.txt", 2) == "2023-11-14 22:13:20.300000000");
  const auto first = numbersOf(folder.get(drive + "oxts/data/0000000000.txt"))[0],
             later = numbersOf(folder.get(drive + "oxts/data/0000000005.txt"))[0];
  REQUIRE(first.size() == 30);
  CHECK(later[0] == first[0]);
  CHECK_THAT((later[1] - first[1]) * M_PI / 180 * 6378137 * std::cos(first[0] * M_PI / 180), WithinAbs(2, 1e-6));
  CHECK_THAT(later[7], WithinAbs(4, 1e-6));  // m/s to the east, and ahead
  CHECK_THAT(later[8], WithinAbs(4, 1e-6));
  for (const auto& oxts : {first, later})
    for (size_t value : {13, 16}) CHECK_THAT(oxts[value], WithinAbs(9.80665, 1e-6));  // az and au
  CHECK_THAT(first[8], WithinAbs(4, 1e-6));
}

TEST_CASE("KITTI raw data: clouds in the frame of the start of the scan, deskewed or without motion, have its time") {
  const DriveFolder folder;
  Json json = quietDrive();
  json["outputs"] = {{{"format", "kitti-raw"}}, {{"format", "pcd"}, {"fields", "x,y,z"}}};
  json["epoch"] = 1700000000;
  for (const auto& [out, word, value] : {std::tuple("still", "use", Json("off")), {"out", "deskew", Json(true)}}) {
    CAPTURE(out);
    json["sensors"][0]["effects"] = {{"sensor-motion", {{word, value}}}};
    folder.run(json, out);
    const std::string drive = std::string(out) + "/kitti-raw/2023_11_14/2023_11_14_drive_0001_sync/";
    const std::string starts = folder.get(drive + "velodyne_points/timestamps_start.txt");
    CHECK_THAT(starts, StartsWith("2023-11-14 22:13:20.000000000\n2023-11-14 22:13:20.100000000\n"));
    CHECK(folder.get(drive + "velodyne_points/timestamps.txt") == starts);
    CHECK(folder.get(drive + "oxts/timestamps.txt") == starts);
  }
  // Poses have the times of the trajectory, which a joined set of files must know.
  CHECK_THAT(folder.get("out/pcd/" + json["sensors"][0]["name"].get<std::string>() + "/poses.txt"),
             StartsWith("# t x y z qx qy qz qw\n# t is Unix time less 1700000000.0 s\n0.000000000 "));
}

TEST_CASE("KITTI raw data: the turn rates of a vehicle that leans, about its own axes and about level ones") {
  constexpr double kLean = 0.5, kTurnRate = 0.8;  // rad, rad/s
  const DriveFolder folder;
  std::ostringstream poses;
  for (int i = 0; i <= 20; ++i) {
    const double half = kTurnRate * i * 0.05 / 2, s = std::sin(half), c = std::cos(half);
    poses << i * 0.05 << " 0 0 0 " << c * std::sin(kLean / 2) << ' ' << s * std::sin(kLean / 2) << ' '
          << s * std::cos(kLean / 2) << ' ' << c * std::cos(kLean / 2) << '\n';
  }
  put(folder / "ego.tum", poses.str());
  Json json = smallDrive();
  json["weather"] = Json::array();
  json["duration"] = 0.6;
  json["epoch"] = 1700000000;
  json["ego"]["trajectory"] = {{"file", "ego.tum"}};
  json["outputs"] = {{{"format", "kitti-raw"}}};
  REQUIRE(folder.run(json).finished);
  const auto oxts =
      numbersOf(folder.get("out/kitti-raw/2023_11_14/2023_11_14_drive_0001_sync/oxts/data/0000000005.txt"))[0];
  const double own[] = {0, kTurnRate * std::sin(kLean), kTurnRate * std::cos(kLean)}, level[] = {0, 0, kTurnRate};
  CHECK_THAT(oxts[3], WithinAbs(kLean, 1e-4));
  for (size_t axis = 0; axis < 3; ++axis) {
    CHECK_THAT(oxts[17 + axis], WithinAbs(own[axis], 1e-4));
    CHECK_THAT(oxts[20 + axis], WithinAbs(level[axis], 1e-4));
  }
}

TEST_CASE(
    "a vehicle on a circle has the speed, the acceleration and the turn rate of the circle, from its first stamp to "
    "its last") {
  constexpr double kRadius = 20, kTurnRate = 0.5;
  for (const double step : {0.001, 0.01, 0.1}) {
    std::vector<drive::Trajectory::Stamp> stamps;
    for (int i = 0; i * step <= 2.0001; ++i) {
      const double angle = kTurnRate * i * step;
      stamps.push_back({i * step,
                        {{kRadius * std::cos(angle), kRadius * std::sin(angle), 1},
                         {0, 0, std::sin((angle + M_PI / 2) / 2), std::cos((angle + M_PI / 2) / 2)}}});
    }
    const drive::Trajectory circle(std::move(stamps));
    for (const double time : {0.0, 0.003, 0.3, 0.55, 1.0, 1.98, circle.end()}) {
      INFO("step " << step << " s, time " << time << " s");
      const drive::Trajectory::Rates rates = circle.ratesAt(time);
      const double angle = kTurnRate * time, speed = kRadius * kTurnRate, inwards = speed * kTurnRate;
      CHECK_THAT(rates.velocity.x, WithinAbs(-speed * std::sin(angle), 0.01));
      CHECK_THAT(rates.velocity.y, WithinAbs(speed * std::cos(angle), 0.01));
      CHECK_THAT(rates.acceleration.x, WithinAbs(-inwards * std::cos(angle), 0.3));
      CHECK_THAT(rates.acceleration.y, WithinAbs(-inwards * std::sin(angle), 0.3));
      CHECK_THAT(rates.turnRate.z, WithinAbs(kTurnRate, 1e-9));
    }
    const drive::Trajectory::Rates before = circle.ratesAt(-0.1);
    CHECK((before.velocity.x == 0 && before.velocity.y == 0 && before.acceleration.x == 0 && before.turnRate.z == 0));
  }
}

TEST_CASE("a vehicle that speeds up along a line has its speed and acceleration between uneven stamps") {
  constexpr double kAcceleration = 3;
  std::vector<drive::Trajectory::Stamp> stamps;
  for (const double time : {0.0, 0.1, 0.3, 0.6, 1.0, 1.1})
    stamps.push_back({time, {{kAcceleration / 2 * time * time, 0, 0}, {}}});
  const drive::Trajectory way(stamps);
  for (const double time : {0.1, 0.25, 0.3, 0.4, 0.6, 0.9, 1.0}) {
    INFO(time);
    CHECK_THAT(way.ratesAt(time).velocity.x, WithinAbs(kAcceleration * time, 1e-9));
    CHECK_THAT(way.ratesAt(time).acceleration.x, WithinAbs(kAcceleration, 1e-9));
  }
}

TEST_CASE("the signs of quaternions do not matter to turn rates") {
  constexpr double kTurnRate = 0.5;
  std::vector<drive::Trajectory::Stamp> stamps;
  for (int i = 0; i <= 10; ++i) {
    const double half = kTurnRate * 0.1 * i / 2, sign = i < 5 ? 1 : -1;
    stamps.push_back({0.1 * i, {{}, {0, 0, sign * std::sin(half), sign * std::cos(half)}}});
  }
  const drive::Trajectory turning(stamps);
  for (int i = 0; i <= 10; ++i) CHECK_THAT(turning.ratesAt(0.1 * i).turnRate.z, WithinAbs(kTurnRate, 1e-9));
}

TEST_CASE("dates have fractions of a second from 0 on, also before 1970") {
  CHECK(drive::dateText(1'700'000'000'250'000'000) == "2023-11-14 22:13:20.250000000");
  CHECK(drive::dateText(-1) == "1969-12-31 23:59:59.999999999");
  CHECK(drive::dateText(-1'000'000'000) == "1969-12-31 23:59:59.000000000");
}

TEST_CASE("KITTI: an output states the number of its sequence or drive") {
  const DriveFolder folder;
  Json json = smallDrive();
  json["duration"] = 0.1;
  json["outputs"] = {{{"format", "kitti"}, {"sequence", 3}},
                     {{"format", "semantickitti"}, {"sequence", 21}},
                     {{"format", "kitti-raw"}, {"sequence", 0}}};
  REQUIRE(folder.run(json).finished);
  for (const char* file :
       {"kitti/sequences/03/velodyne/000000.bin", "kitti/sequences/03/calib.txt", "kitti/poses/03.txt",
        "semantickitti/sequences/21/labels/000000.label", "semantickitti/poses/21.txt",
        "kitti-raw/1970_01_01/1970_01_01_drive_0000_sync/oxts/timestamps.txt"}) {
    INFO(file);
    CHECK(fs::exists(folder / "out" / file));
  }
}

// The tutorial for custom data sets of OpenPCDet, and its custom_dataset.py.
TEST_CASE(
    "OpenPCDet: the points of KITTI as an array, the boxes in the sensor's frame, and lists of frames with boxes") {
  const DriveFolder& folder = made();
  const std::string npy = folder.get("out/openpcdet/points/000003.npy");
  const std::string points = folder.get("out/kitti/sequences/00/velodyne/000003.bin");
  REQUIRE(npy.starts_with(std::string("\x93NUMPY\x01\x00", 8)));
  const size_t head = 10 + at<uint16_t>(npy, 8);
  CHECK(head % 64 == 0);
  CHECK_THAT(npy.substr(10, head - 10), ContainsSubstring("'<f4'") && ContainsSubstring("'fortran_order': False") &&
                                            ContainsSubstring("(" + std::to_string(points.size() / 16) + ", 4)"));
  CHECK(npy.substr(head) == points);

  std::istringstream labels(folder.get("out/openpcdet/labels/000003.txt")),
      boxes(folder.get("out/boxes/top/000003.jsonl"));
  size_t count = 0;
  for (std::string line; std::getline(boxes, line); ++count) {
    const Json box = Json::parse(line);
    double x = 0, y = 0, z = 0, length = 0, width = 0, height = 0, heading = 0;
    std::string name;
    labels >> x >> y >> z >> length >> width >> height >> heading >> name;
    const double found[] = {x, y, z, length, width, height};
    for (size_t axis = 0; axis < 3; ++axis) {
      CHECK_THAT(found[axis], WithinAbs(box["sensor_frame"]["position"][axis].get<double>(), 1e-4));
      CHECK_THAT(found[3 + axis], WithinAbs(box["size"][axis].get<double>(), 1e-4));
    }
    CHECK_THAT(std::sin(heading / 2), WithinAbs(box["sensor_frame"]["orientation"][2].get<double>(), 1e-5));
    CHECK(name == box["class"].get<std::string>());
  }
  CHECK(count > 0);
  CHECK_FALSE(labels >> count);

  std::istringstream train(folder.get("out/openpcdet/ImageSets/train.txt")),
      validate(folder.get("out/openpcdet/ImageSets/val.txt"));
  std::vector<std::string> frames, last;
  for (std::string frame; train >> frame;) frames.push_back(frame);
  for (std::string frame; validate >> frame;) last.push_back(frame);
  REQUIRE(frames.size() + last.size() == 10);
  CHECK(last == std::vector<std::string>{"000008", "000009"});
  CHECK(frames.front() == "000000");
}

TEST_CASE("OpenPCDet: points and boxes of a tilted sensor are in a frame with its yaw and the vehicle's z axis") {
  const DriveFolder folder;
  Json json = smallDrive();
  json["weather"] = Json::array();
  json["duration"] = 1;
  json["ego"]["trajectory"] = {{"waypoints", {waypoint(0, -2, 0, 0)}}};
  json["sensors"][0]["effects"] = "auto";
  json["sensors"][0]["mount"]["yaw_pitch_roll_deg"] = {30, 20, 175};
  json["classes"]["small car"] = {{"id", 11}};
  json["actors"][0]["class"] = "small car";
  json["outputs"] = {{{"format", "openpcdet"}}, {{"format", "boxes"}}};
  REQUIRE(folder.run(json).finished);
  const std::string npy = folder.get("out/openpcdet/points/000003.npy");
  size_t onFloor = 0, points = 0;
  for (size_t row = 10 + at<uint16_t>(npy, 8); row < npy.size(); row += 16, ++points)
    onFloor += std::abs(at<float>(npy, row + 8) + 1.8) < 1e-4;
  CHECK(points > 100);
  CHECK(onFloor > points / 2);

  std::istringstream labels(folder.get("out/openpcdet/labels/000003.txt")),
      boxes(folder.get("out/boxes/top/000003.jsonl"));
  std::string line;
  REQUIRE(std::getline(boxes, line));
  const Json world = Json::parse(line)["world_frame"]["position"];
  double x = 0, y = 0, z = 0, length = 0, width = 0, height = 0, heading = 0;
  REQUIRE(labels >> x >> y >> z >> length >> width >> height >> heading);
  const double ahead = world[0].get<double>() + 2, left = world[1].get<double>(), yaw = M_PI / 6;
  CHECK_THAT(x, WithinAbs(std::cos(yaw) * ahead + std::sin(yaw) * left, 1e-3));
  CHECK_THAT(y, WithinAbs(-std::sin(yaw) * ahead + std::cos(yaw) * left, 1e-3));
  CHECK_THAT(z, WithinAbs(0.75 - 1.8, 1e-3));
  CHECK_THAT(heading, WithinAbs(-yaw, 1e-6));
  std::string name;
  labels >> name;
  CHECK(name == "small_car");  // a line of labels has eight words
}

// https://mcap.dev/spec, the messages of ROS 2's common_interfaces, and OMG's CDR.
TEST_CASE("MCAP: records that follow each other, an index that leads to the chunks, clouds as ROS 2 has them") {
  const DriveFolder& folder = made();
  const std::string mcap = folder.get("out/mcap/drive.mcap");
  CHECK_FALSE(fs::exists(folder / "out/mcap/chunks"));
  const std::string magic("\x89MCAP0\r\n", 8);
  REQUIRE((mcap.starts_with(magic) && mcap.ends_with(magic)));
  std::map<uint8_t, std::vector<size_t>> records;  // places by opcode
  for (size_t p = 8; p < mcap.size() - 8; p += 9 + at<uint64_t>(mcap, p + 1))
    records[at<uint8_t>(mcap, p)].push_back(p);
  CHECK(records[1].size() == 1);
  CHECK(records[3].size() == 14);  // seven schemas, and again in the summary
  CHECK(records[4].size() == 10);
  REQUIRE(records[6].size() == 10);
  REQUIRE(records[8].size() == 10);
  REQUIRE(records[2].size() == 1);
  const auto summary = at<uint64_t>(mcap, records[2][0] + 9);
  CHECK(at<uint8_t>(mcap, summary) == 3);  // the summary begins with a schema
  CHECK(summary == records[15][0] + 9 + 4);
  const size_t statistics = records[11][0] + 9;
  const uint64_t messages = at<uint64_t>(mcap, statistics);
  CHECK(messages == 2 * (10 * 10 + 1) + 1 + 10 + 5);  // the last pose is at the end of the last scan
  for (size_t i = 0; i < 10; ++i) {
    const size_t index = records[8][i] + 9;
    CHECK(at<uint64_t>(mcap, index + 16) == records[6][i]);
    CHECK(at<uint64_t>(mcap, index + 24) == 9 + at<uint64_t>(mcap, records[6][i] + 1));
    // The map leads from each channel to its message index, and that to the channel's messages in the chunk.
    const size_t content = records[6][i] + 9 + 8 + 8 + 8 + 4 + 4 + 8, map = index + 36;
    for (size_t entry = map; entry < map + at<uint32_t>(mcap, index + 32); entry += 10) {
      const size_t messageIndex = at<uint64_t>(mcap, entry + 2);
      REQUIRE(messageIndex < mcap.size() - 100);
      CHECK(at<uint8_t>(mcap, messageIndex) == 7);
      CHECK(at<uint16_t>(mcap, messageIndex + 9) == at<uint16_t>(mcap, entry));
      const size_t message = content + at<uint64_t>(mcap, messageIndex + 23);
      CHECK(at<uint8_t>(mcap, message) == 5);
      CHECK(at<uint16_t>(mcap, message + 9) == at<uint16_t>(mcap, entry));
      CHECK(at<uint64_t>(mcap, message + 15) == at<uint64_t>(mcap, messageIndex + 15));
    }
  }
  // The cloud of the sensor "top", channel 3, in the chunk of frame 3.
  size_t p = records[6][3] + 9 + 8 + 8 + 8 + 4 + 4 + 8;
  const size_t end = records[6][3] + 9 + at<uint64_t>(mcap, records[6][3] + 1);
  while (p < end && at<uint16_t>(mcap, p + 9) != 3) p += 9 + at<uint64_t>(mcap, p + 1);
  REQUIRE(p < end);
  CHECK(at<uint64_t>(mcap, p + 15) == 1700000000400000000);  // a scan takes 0.1 s
  const std::string cdr = mcap.substr(p + 31, at<uint64_t>(mcap, p + 1) - 22);
  CHECK(at<uint32_t>(cdr, 0) == 0x100);  // plain CDR, little-endian
  CHECK(at<int32_t>(cdr, 4) == 1700000000);
  CHECK(at<uint32_t>(cdr, 8) == 300000000);
  CHECK(cdr.substr(16, 4) == std::string("top\0", 4));
  CHECK(at<uint32_t>(cdr, 20) == 1);  // height
  const std::string points = folder.get("out/kitti/sequences/00/velodyne/000003.bin");
  const auto width = at<uint32_t>(cdr, 24);
  CHECK(width == points.size() / 16);
  CHECK(at<uint32_t>(cdr, 28) == 8);  // fields
  const size_t data = cdr.size() - 1 - width * 28;
  CHECK(at<uint32_t>(cdr, data - 4) == width * 28);
  CHECK(at<uint32_t>(cdr, data - 8) == width * 28);
  CHECK(at<uint32_t>(cdr, data - 12) == 28);
  for (uint32_t i = 0; i < width; ++i) CHECK(cdr.substr(data + 28 * i, 16) == points.substr(16 * i, 16));
}

TEST_CASE("MCAP: the folder is a bag of rosbag2, whose metadata count the messages of the file") {
  const std::string text = made().get("out/mcap/metadata.yaml"), mcap = made().get("out/mcap/drive.mcap");
  const auto part = [&](const std::string& topic) {
    const size_t begin = text.find("name: " + topic + "\n"), end = text.find("message_count: ", begin);
    REQUIRE(end != text.npos);
    return text.substr(begin, text.find('\n', end) - begin);
  };
  CHECK_THAT(text,
             Catch::Matchers::StartsWith("rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n"));
  CHECK_THAT(text, ContainsSubstring("  message_count: 218\n  topics_with_message_count:\n"));
  CHECK_THAT(text, ContainsSubstring("\n  relative_file_paths:\n    - drive.mcap\n"));
  CHECK(part("/tf").ends_with("message_count: 101"));
  CHECK(part("/tf_static").ends_with("message_count: 1"));
  CHECK_THAT(part("/tf_static"), ContainsSubstring("durability: 1"));
  CHECK_THAT(part("/top/points"), ContainsSubstring("type: sensor_msgs/msg/PointCloud2\n"));
  CHECK(part("/top/points").ends_with("message_count: 10"));
  // The statistics of the file have the times of its first and its last message.
  size_t p = 8;
  while (at<uint8_t>(mcap, p) != 0x0b) p += 9 + at<uint64_t>(mcap, p + 1);
  CHECK(at<uint64_t>(mcap, p + 9) == 218);
  const auto begin = at<uint64_t>(mcap, p + 9 + 26), end = at<uint64_t>(mcap, p + 9 + 34);
  CHECK_THAT(text,
             ContainsSubstring("      starting_time:\n        nanoseconds_since_epoch: " + std::to_string(begin)));
  CHECK_THAT(text, ContainsSubstring("      duration:\n        nanoseconds: " + std::to_string(end - begin) + "\n"));
}

TEST_CASE("MCAP: intensities are 0 to 1 whatever the scale, and a drive without them has no such field") {
  Json json = smallDrive();
  json["sensors"][0]["effects"] = {{"intensity", {{"scale", "byte"}}}};
  json["duration"] = 0.1;
  json["outputs"] = {{{"format", "kitti"}}, {{"format", "mcap"}}};
  const DriveFolder folder;
  CHECK(folder.run(json).finished);
  const std::string points = folder.get("out/kitti/sequences/00/velodyne/000000.bin");
  REQUIRE(points.size() > 1600);
  const std::string mcap = folder.get("out/mcap/drive.mcap");
  for (size_t row = 0; row < points.size(); row += 16) {
    const float intensity = at<float>(points, row + 12);
    CHECK((intensity > 0 && intensity <= 1));
    CHECK(mcap.find(points.substr(row, 16)) != mcap.npos);
  }
  CHECK(mcap.find(std::string("intensity\0", 10)) != mcap.npos);
  json["sensors"][0]["effects"] = "clean";
  CHECK(folder.run(json, "clean").finished);
  CHECK(folder.get("clean/mcap/drive.mcap").find(std::string("intensity\0", 10)) == std::string::npos);
}

TEST_CASE("PCD: the header and the rows that it promises") {
  const std::string pcd = made().get("out/pcd/top/000003.pcd");
  CHECK_THAT(pcd, ContainsSubstring("FIELDS x y z intensity ring time class instance true_range\n"));
  const size_t data = pcd.find("DATA binary\n") + 12, points = pcd.find("POINTS ") + 7;
  CHECK(pcd.size() - data == std::stoul(pcd.substr(points)) * (6 * 4 + 2 + 2 + 4));
}
