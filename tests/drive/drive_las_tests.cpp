// SPDX-License-Identifier: Apache-2.0
// The clouds of a drive as LAS.
#include <algorithm>
#include <catch2/matchers/catch_matchers_floating_point.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include "drive_support.hpp"
#include "support.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::WithinAbs;

// Offsets of LAS 1.4 R15, table 3 (header), 15 (point data record format 6) and 24 (extra bytes).
TEST_CASE("LAS 1.4: header, point format 6, and points in the world") {
  const DriveFolder& folder = made();
  const std::string las = folder.get("out/las/top/000003.las");
  CHECK(las.substr(0, 4) == "LASF");
  CHECK(at<uint16_t>(las, 6) == 17);  // adjusted GPS time, WKT
  CHECK((at<uint8_t>(las, 24) == 1 && at<uint8_t>(las, 25) == 4));
  CHECK(at<uint16_t>(las, 94) == 375);
  const auto offset = at<uint32_t>(las, 96);
  CHECK(offset == 375 + 54 + 192);
  CHECK(at<uint32_t>(las, 100) == 1);
  CHECK(at<uint8_t>(las, 104) == 6);
  const auto length = at<uint16_t>(las, 105);
  CHECK(length == 34);
  CHECK(at<uint32_t>(las, 107) == 0);
  const auto count = at<uint64_t>(las, 247);
  CHECK(las.size() == offset + count * length);
  CHECK(at<uint64_t>(las, 255) == count);  // first returns
  CHECK(las.substr(377, 9) == "LASF_Spec");
  CHECK(at<uint16_t>(las, 393) == 4);
  CHECK(at<uint8_t>(las, 375 + 54 + 2) == 5);  // the object is a u32
  const std::string points = folder.get("out/kitti/sequences/00/velodyne/000003.bin");
  REQUIRE(count == points.size() / 16);
  double maxX = -1e9, minZ = 1e9;
  for (uint64_t i = 0; i < count; ++i) {
    const size_t p = offset + i * length;
    double xyz[3];
    for (size_t axis = 0; axis < 3; ++axis)
      xyz[axis] = at<int32_t>(las, p + 4 * axis) * at<double>(las, 131 + 8 * axis) + at<double>(las, 155 + 8 * axis);
    const auto category = at<uint8_t>(las, p + 16);
    const auto object = at<uint32_t>(las, p + 30);
    const double time = at<double>(las, p + 22) + 1e9 + 315964800 - 18 - 1700000000;  // on the drive's clock
    CHECK((time > 0.3 - 1e-6 && time < 0.4));
    // The sensor is at x = -2 + 4 t, and sees along the axes of the world.
    CHECK_THAT(xyz[0] - (-2 + 4 * time), WithinAbs(at<float>(points, 16 * i), 2e-3));
    CHECK_THAT(xyz[1], WithinAbs(at<float>(points, 16 * i + 4), 1e-3));
    CHECK_THAT(xyz[2] - 1.8, WithinAbs(at<float>(points, 16 * i + 8), 1e-3));
    CHECK((category == 40 ? object == 0 : category == 10 ? object == 1 : category == 30 && object == 2));
    CHECK(at<uint8_t>(las, p + 14) == 0x11);                                          // the first of one return
    const double angle = std::atan2(-xyz[1], 1.8 - xyz[2]) * 180 / std::numbers::pi;  // to the right of the x axis
    CHECK_THAT(at<int16_t>(las, p + 18) * 0.006, WithinAbs(angle, 0.05));
    maxX = std::max(maxX, xyz[0]);
    minZ = std::min(minZ, xyz[2]);
  }
  CHECK_THAT(at<double>(las, 179), WithinAbs(maxX, 1e-9));
  CHECK_THAT(at<double>(las, 219), WithinAbs(minZ, 1e-9));
}

TEST_CASE("LAS: the returns of a beam have their number below and their count above") {
  const DriveFolder folder;
  putPane(folder);
  Json json = smallDrive();
  json["weather"] = Json::array();
  json["duration"] = 0.1;
  json["scenes"].push_back({{"file", "pane.glb"}, {"class", "ground"}});
  json["sensors"][0]["effects"] = {{"returns", {{"count", 2}}}};
  json["outputs"] = {{{"format", "las"}}};
  REQUIRE(folder.run(json).finished);
  const std::string las = folder.get("out/las/top/000000.las");
  std::map<int, uint64_t> counts;
  for (size_t p = at<uint32_t>(las, 96); p < las.size(); p += 34) ++counts[at<uint8_t>(las, p + 14)];
  CHECK(counts.size() == 3);
  CHECK(counts[0x21] > 0);
  CHECK(counts[0x22] == counts[0x21]);
  CHECK(at<uint64_t>(las, 255) == counts[0x11] + counts[0x21]);
  CHECK(at<uint64_t>(las, 263) == counts[0x22]);
}

TEST_CASE("LAS: the direction in which a mirror moves, and the ends of its lines") {
  // A mirror that swings, and one with facets, which goes on from the left after it has reached the right.
  const auto flags = [](const std::vector<double>& degrees, uint32_t lines = 1) {
    const DriveFolder folder;
    Json directions = Json::array(), rings = Json::array(), json = smallDrive();
    for (size_t i = 0; i < degrees.size(); ++i) {
      const double angle = degrees[i] * std::numbers::pi / 180;  // below the vehicle, to its right
      directions.push_back({std::cos(angle), std::sin(angle), 0});
      rings.push_back(i % lines);
    }
    json["weather"] = Json::array();
    json["actors"] = Json::array();
    json["duration"] = 0.1;
    json["ego"]["trajectory"] = {{"waypoints", {waypoint(0, 0, 0, 5)}}};
    json["sensors"] = {{{"name", "mirror"},
                        {"mount", {{"yaw_pitch_roll_deg", {0, 90, 0}}}},
                        {"sensor",
                         {{"name", "mirror"},
                          {"range", {{"min", 1}, {"max", 100}}},
                          {"patterns", {{{"directions", directions}, {"rings", rings}}}}}}}};
    json["outputs"] = {{{"format", "las"}}};
    REQUIRE(folder.run(json).finished);
    const std::string las = folder.get("out/las/mirror/000000.las");
    std::vector<int> all;
    for (size_t p = at<uint32_t>(las, 96); p < las.size(); p += 34) {
      all.push_back(at<uint8_t>(las, p + 15));
      CHECK_THAT(at<int16_t>(las, p + 18) * 0.006, WithinAbs(-degrees[all.size() - 1], 0.01));
    }
    return all;
  };
  constexpr int kRight = 1 << 6, kEnd = 1 << 7;
  CHECK(flags({20, 10, 0, -10, -20, -10, 0, 10}) == std::vector{kEnd, kRight, kRight, kRight, kRight | kEnd, 0, 0, 0});
  CHECK(flags({22, 11, 1, -10, -20, 21, 11, 0, -10, -21}) ==
        std::vector{kRight, kRight, kRight, kRight, kRight | kEnd, kRight, kRight, kRight, kRight, kRight | kEnd});
  CHECK(flags({20, 10, 0, -10}, 2) == std::vector{0, 0, 0, 0});
}

TEST_CASE("LAS: a coordinate reference system, and times of a trajectory whose clock is small") {
  const DriveFolder folder;
  Json json = smallDrive();
  json["epoch"] = 1700000000;
  json["outputs"] = {{{"format", "las"}, {"sensors", {"top"}}, {"crs", "LOCAL_CS[\"pit\"]"}}};
  folder.run(json);
  const std::string las = folder.get("out/las/top/000003.las");
  CHECK(at<uint32_t>(las, 100) == 2);  // variable length records
  const size_t record = 375 + 54 + 192;
  CHECK(las.substr(record + 2, 15) == "LASF_Projection");
  CHECK(at<uint16_t>(las, record + 18) == 2112);
  CHECK(at<uint16_t>(las, record + 20) == 16);
  CHECK(las.substr(record + 54, 16) == std::string("LOCAL_CS[\"pit\"]") + '\0');
  const auto offset = at<uint32_t>(las, 96);
  CHECK(offset == record + 54 + 16);
  for (uint64_t i = 0; i < at<uint64_t>(las, 247); ++i) {
    constexpr double kEpoch = 1700000000.0 - 315964800 + 18 - 1e9;  // adjusted GPS time
    const double time = at<double>(las, offset + 34 * i + 22) - kEpoch;
    // The columns of the head are 0.1 s / 90 apart, and doubles of such seconds 0.06 us.
    const double column = (time - 0.3) / (0.1 / 90);
    CHECK_THAT(column, WithinAbs(std::round(column), 0.04e-6 / (0.1 / 90)));
  }
  json["outputs"][0]["crs"] = std::string(65535, 'x');
  CHECK_THROWS_WITH(folder.read(json), ContainsSubstring("outputs[0].crs: must be well-known text of at most 65534"));
  json["outputs"][0]["format"] = "pcd";
  CHECK_THROWS_WITH(folder.read(json), ContainsSubstring("outputs[0].crs: is only for las"));
}

TEST_CASE("LAS: one file of a whole drive has the points of the files of its scans, and fields as extra dimensions") {
  const DriveFolder folder;
  Json json = smallDrive();
  json["outputs"] = {{{"format", "las"}, {"folder", "scans"}, {"fields", "range,ring,incidence"}},
                     {{"format", "las"},
                      {"folder", "line"},
                      {"fields", "range,ring,incidence"},
                      {"one_file", true},
                      {"flight_line", 12}},
                     {{"format", "npy"}, {"fields", "range,ring,incidence"}}};
  REQUIRE(folder.run(json).finished);
  CHECK_FALSE(fs::exists(folder / "out/line/parts"));
  const std::string whole = folder.get("out/line/top.las");
  constexpr size_t kStart = 375 + 54 + 4 * 192, kLength = 34 + 4 + 2 + 4;
  CHECK(at<uint16_t>(whole, 4) == 12);                            // file source
  CHECK(at<uint16_t>(folder.get("out/line/side.las"), 4) == 13);  // that of the second sensor
  CHECK(at<uint32_t>(whole, 96) == kStart);
  CHECK(at<uint16_t>(whole, 105) == kLength);
  const char* names[] = {"object", "range", "ring", "incidence"};
  const uint8_t types[] = {5, 9, 3, 9};
  for (size_t i = 0; i < 4; ++i) {
    CHECK(at<uint8_t>(whole, 375 + 54 + 192 * i + 2) == types[i]);
    CHECK(std::string(&whole[375 + 54 + 192 * i + 4]) == names[i]);
  }
  CHECK(std::string(&whole[375 + 54 + 192 + 160]) == "m along the beam");
  uint64_t count = 0;
  double maxX = -1e9;
  for (int scan = 0; scan < 10; ++scan) {
    const std::string number = "/top/00000" + std::to_string(scan);
    const std::string las = folder.get("out/scans" + number + ".las"), rows = folder.get("out/npy" + number + ".npy");
    CHECK(at<uint16_t>(las, 4) == 0);
    CHECK(las.substr(155, 24) == whole.substr(155, 24));  // one offset, so that files can be put together
    const uint64_t points = at<uint64_t>(las, 247);
    REQUIRE(las.size() == kStart + points * kLength);
    REQUIRE(rows.size() > points * 10);
    for (uint64_t i = 0; i < points; ++i, ++count) {
      std::string point = las.substr(kStart + i * kLength, kLength);
      CHECK(at<uint16_t>(point, 20) == 1);
      CHECK(point.substr(34) == rows.substr(rows.size() - (points - i) * 10, 10));
      point[20] = 12;  // the point source is the flight line
      CHECK(point == whole.substr(kStart + count * kLength, kLength));
      maxX = std::max(maxX, at<int32_t>(point, 0) * 0.001 + at<double>(las, 155));
    }
  }
  CHECK(whole.size() == kStart + count * kLength);
  CHECK(at<uint64_t>(whole, 247) == count);
  CHECK(at<uint64_t>(whole, 255) == count);
  CHECK_THAT(at<double>(whole, 179), WithinAbs(maxX, 1e-9));
}

TEST_CASE("LAS: a finer scale keeps more digits, the source may be the number of the scan, and poses stand beside") {
  const DriveFolder folder;
  Json json = smallDrive();
  const auto las = [&](const char* name, double scale) {
    return Json{{"format", "las"}, {"folder", name}, {"one_file", true}, {"source_per_scan", true}, {"scale", scale}};
  };
  json["outputs"] = {las("coarse", 0.001), las("fine", 0.00001), {{"format", "npy"}}};
  REQUIRE(folder.run(json).finished);
  const std::string coarse = folder.get("out/coarse/top.las"), fine = folder.get("out/fine/top.las");
  REQUIRE(coarse.size() == fine.size());
  CHECK(at<double>(coarse, 131) == 0.001);
  CHECK(at<double>(fine, 131) == 0.00001);
  CHECK_THAT(at<double>(fine, 179), WithinAbs(at<double>(coarse, 179), 0.00051));  // the greatest x
  uint64_t between = 0;
  std::map<int, uint64_t> sources;
  for (size_t p = at<uint32_t>(fine, 96); p < fine.size(); p += 34) {
    for (size_t axis = 0; axis < 12; axis += 4) {
      const auto steps = at<int32_t>(fine, p + axis);
      CHECK(std::abs(steps * 0.01 - at<int32_t>(coarse, p + axis)) < 0.51);
      between += steps % 100 != 0 ? 1 : 0;
    }
    ++sources[at<uint16_t>(fine, p + 20)];
  }
  CHECK(between > 100);
  CHECK((sources.size() == 10 && sources.begin()->first == 1 && sources.rbegin()->first == 10));
  CHECK(folder.get("out/fine/top/poses.txt") == folder.get("out/npy/top/poses.txt"));
}

TEST_CASE("LAS: the one file of a sensor that meets nothing is there, and without points") {
  const DriveFolder folder;
  Json json = smallDrive();
  json.erase("weather");  // drops of rain return light, too
  for (Json& sensor : json["sensors"]) sensor["mount"] = {{"position", {0, 0, 5000}}};
  json["outputs"] = {{{"format", "las"}, {"one_file", true}}};
  REQUIRE(folder.run(json).finished);
  const std::string whole = folder.get("out/las/top.las");
  CHECK(at<uint64_t>(whole, 247) == 0);
  CHECK(at<uint32_t>(whole, 96) == whole.size());
}

TEST_CASE("LAS: coordinates too far from the start of the drive have an offset of their own, or are refused") {
  const DriveFolder folder;
  Json json = smallDrive();
  json["weather"] = json["actors"] = Json::array();
  json["scenes"].push_back({{"file", "floor.obj"}, {"pose", {{"position", {30000, 0, 0}}}}});
  json["ego"]["trajectory"]["waypoints"] = {waypoint(0, 0, 0, 0), waypoint(0.4, 0, 0, 0), waypoint(0.5, 30000, 0, 0),
                                            waypoint(1, 30000, 0, 0)};
  json["sensors"] = {json["sensors"][0]};
  json["sensors"][0]["effects"] = {{"divergence", {{"use", "off"}}}};
  json["outputs"] = {{{"format", "las"}, {"scale", 0.00001}}};
  REQUIRE(folder.run(json).finished);
  for (const auto& [scan, offsetX, offsetZ] : {std::tuple("000002", 0.0, 0.0), {"000007", 30000.0, 2.0}}) {
    CAPTURE(scan);
    const std::string las = folder.get("out/las/top/" + std::string(scan) + ".las");
    CHECK((at<double>(las, 155) == offsetX && at<double>(las, 163) == 0 && at<double>(las, 171) == offsetZ));
    size_t points = 0;
    for (size_t p = at<uint32_t>(las, 96); p < las.size(); p += 34, ++points) {
      CHECK(std::abs(at<int32_t>(las, p) * 0.00001) < 20.01);  // the floor around the sensor
      CHECK_THAT(at<int32_t>(las, p + 8) * 0.00001 + offsetZ, WithinAbs(0, 1e-4));
    }
    CHECK(points > 300);
  }
  json["outputs"][0]["one_file"] = true;
  CHECK_THROWS_WITH(folder.run(json, "one"),
                    "outputs: with 'one_file' and a 'scale' of 1e-05 m LAS has coordinates up to 10 km from the start "
                    "of the drive, and the vehicle goes beyond; leave 'one_file' out, or state a greater scale");

  // 32 bits hold 21.5 km in such units.
  put(folder / "far.obj", "v 25000 -9000 -90\nv 25000 9000 -90\nv 25000 9000 90\nv 25000 -9000 90\nf 1 2 3\nf 1 3 4\n");
  json["duration"] = 0.1;
  json["ego"]["trajectory"] = {{"waypoints", {waypoint(0, 0, 0, 0)}}};
  json["scenes"] = {{{"file", "far.obj"}, {"up", "z"}}};
  json["sensors"][0]["sensor"]["range"]["max"] = 40000;
  json["sensors"][0]["effects"] = "clean";
  for (const bool oneFile : {false, true}) {
    json["outputs"][0]["one_file"] = oneFile;
    CHECK_THROWS_WITH(folder.run(json, oneFile ? "far-one" : "far"),
                      "outputs: LAS has no coordinates of 25000 m from their offset with a 'scale' of 1e-05 m; state "
                      "a greater one");
  }
  json["outputs"][0]["scale"] = 0.0001;
  CHECK(folder.run(json, "coarser").finished);
}

TEST_CASE("LAS: what an output of a survey must not say") {
  const DriveFolder folder;
  const auto problem = [&](const Json& output) {
    Json json = smallDrive();
    json["outputs"] = {output};
    try {
      folder.read(json);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  for (const char* crs : {"EPSG:25832", "+proj=utm +zone=32", "{\"type\": \"ProjectedCRS\"}", "PROJCS[\"cut off\","})
    CHECK_THAT(problem({{"format", "las"}, {"crs", crs}}),
               ContainsSubstring("outputs[0].crs: must be well-known text (WKT), as pyproj.CRS(25832).to_wkt("));
  CHECK(problem({{"format", "las"}, {"crs", " PROJCRS[\"a\"]\n"}}) == "none");
  CHECK_THAT(problem({{"format", "las"}, {"fields", "width,intensity"}}),
             ContainsSubstring("outputs[0].fields: the points of LAS have 'intensity' without it"));
  CHECK_THAT(problem({{"format", "las"}, {"fields", "normal"}}),
             ContainsSubstring("outputs[0].fields: 'normal' has several components, and LAS takes one"));
  CHECK_THAT(problem({{"format", "las"}, {"fields", "tie"}}), ContainsSubstring("'tie' is of beams without returns"));
  CHECK_THAT(problem({{"format", "las"}, {"flight_line", 65535}}),
             ContainsSubstring("outputs[0].flight_line: is 65535, and each of 2 sensors has a number of its own"));
  CHECK(problem({{"format", "las"}, {"flight_line", 65534}}) == "none");
  CHECK_THAT(problem({{"format", "las"}, {"flight_line", 1}, {"source_per_scan", true}}),
             ContainsSubstring("outputs[0].source_per_scan: makes the point source the number of the scan, and "
                               "'flight_line' states another; keep one"));
  CHECK_THAT(problem({{"format", "las"}, {"scale", 0}}), ContainsSubstring("outputs[0].scale"));
  CHECK_THAT(problem({{"format", "pcd"}, {"scale", 0.01}}), ContainsSubstring("outputs[0].scale: is only for las"));
  Json frequent = smallDrive();
  frequent["duration"] = 10000;
  frequent["outputs"] = {{{"format", "las"}, {"source_per_scan", true}}};
  CHECK_THROWS_WITH(folder.read(frequent), ContainsSubstring("outputs[0].source_per_scan: 'top' makes more scans than "
                                                             "LAS has point sources (65535)"));
  Json early = quietDrive();
  early["outputs"] = {{{"format", "las"}}};
  const std::vector<std::string> warnings = folder.read(early).warnings;
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0],
             ContainsSubstring("outputs[0].format: LAS has GPS times, and the drive begins before 2000; give "
                               "an epoch, of adjusted standard GPS times 1315964782"));
  early["epoch"] = 315964800;
  CHECK(folder.read(early).warnings.empty());
  early["epoch"] = 315964799.5;
  REQUIRE(folder.read(early).warnings.size() == 1);
  CHECK_THAT(folder.read(early).warnings[0], ContainsSubstring("begins before 1980; give another epoch"));
  early["sensors"][1]["offset"] = 0;  // so that its last scan ends with the drive
  early["start"] = early["duration"] = 0.5;
  CHECK(folder.read(early).warnings.empty());
  early["epoch"] = 1.7e9;
  early["sensors"][0]["effects"]["intensity"]["scale"] = "raw";
  REQUIRE(folder.read(early).warnings.size() == 1);
  CHECK_THAT(folder.read(early).warnings[0], ContainsSubstring("of those of 'top', whose intensity.scale is raw, "
                                                               "nearly nothing is left"));
  Json many = smallDrive();
  many["classes"]["car"]["id"] = 300;
  many["outputs"] = {{{"format", "las"}}};
  CHECK_THROWS_WITH(folder.read(many),
                    ContainsSubstring("outputs[0].format: LAS has classes 0 to 255; 'car' has the id 300"));
  CHECK_THAT(problem({{"format", "pcd"}, {"one_file", true}}),
             ContainsSubstring("outputs[0].one_file: is only for las"));
  CHECK_THAT(problem({{"format", "pcd"}, {"flight_line", 1}}), ContainsSubstring("flight_line: is only for las"));
}
