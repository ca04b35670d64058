// SPDX-License-Identifier: Apache-2.0
// Sensor files of every family: small ones written here, with beams computed by hand.
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_floating_point.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <cstring>
#include <numbers>
#include <random>

#include "base/file.hpp"
#include "base/sha256.hpp"
#include "folder.hpp"
#include "gnosphere/error.hpp"
#include "gnosphere/sensor.hpp"
#include "sensor/beams.hpp"
#include "sensor/sensor_file_samples.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::WithinAbs;

namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

std::string problemOf(std::string_view bytes, const std::string& name, const SensorFileOptions& options = {}) {
  try {
    readSensorFile(bytes, name, options);
  } catch (const Error& error) {
    CHECK((error.code() == ErrorCode::format || error.code() == ErrorCode::invalidArgument));
    CHECK_THAT(error.what(), ContainsSubstring(name.substr(0, 4)));
    return error.what();
  }
  return "nothing was wrong";
}

/// `text` with `to` in the place of the first `from`.
std::string replaced(std::string_view text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  REQUIRE(at != text.npos);
  std::string result(text.substr(0, at));
  result.append(to).append(text.substr(at + from.size()));
  return result;
}

double azimuthDeg(const Sensor& sensor, size_t beam, uint64_t frame = 0) {
  return kDegrees * azimuthOf(sensor, beam, frame);
}
double elevationDeg(const Sensor& sensor, size_t beam, uint64_t frame = 0) {
  return kDegrees * elevationOf(sensor, beam, frame);
}

void checkOrigin(const Vec3& found, const Vec3& expected) {
  CHECK_THAT(found.x, WithinAbs(expected.x, 1e-12));
  CHECK_THAT(found.y, WithinAbs(expected.y, 1e-12));
  CHECK_THAT(found.z, WithinAbs(expected.z, 1e-12));
}

bool lists(const std::vector<std::string>& texts, const std::string& part) {
  return std::any_of(texts.begin(), texts.end(), [&](const std::string& t) { return t.find(part) != t.npos; });
}

}  // namespace

TEST_CASE("Velodyne YAML: rings from below, angles and offsets as the driver of ROS places points") {
  const SensorFile file = readSensorFile(kVelodyneYaml, "two.yaml", {.columns = 4});
  CHECK(file.family == "Velodyne calibration");
  const Sensor& sensor = file.sensor;
  CHECK(sensor.name == "two");
  REQUIRE(sensor.channels.size() == 2);
  // The laser 1 is lower: -0.1 rad, and turned by 0.05 rad against the head's sense, which is ours.
  CHECK_THAT(elevationDeg(sensor, 0), WithinAbs(-0.1 * kDegrees, 1e-12));
  CHECK_THAT(azimuthDeg(sensor, 0), WithinAbs(0.05 * kDegrees, 1e-12));
  CHECK_THAT(azimuthDeg(sensor, 1), WithinAbs(0.05 * kDegrees - 90, 1e-12));  // clockwise
  // At distance 0 the driver has: forward -v sin(e), left h, up v cos(e).
  checkOrigin(sensor.channels[0].origin, {0.2 * std::sin(0.1), 0.026, 0.2 * std::cos(0.1)});
  CHECK_THAT(elevationDeg(sensor, 4), WithinAbs(0.2 * kDegrees, 1e-12));
  CHECK_THAT(sensor.rangeMax, WithinAbs(131.07, 1e-9));
  CHECK(lists(file.ignored, "dist_correction of"));
  CHECK_FALSE(lists(file.ignored, "focal_slope"));  // which is 0
  CHECK(lists(file.assumed, "10 turns per second"));
  CHECK_FALSE(lists(file.assumed, "columns"));
}

TEST_CASE("Velodyne YAML: mistakes are named with their lines") {
  const auto edited = [](const std::string& from, const std::string& to) {
    return problemOf(replaced(kVelodyneYaml, from, to), "two.yaml");
  };
  CHECK_THAT(edited("vert_correction: -0.1", "vert_correction: abc"), ContainsSubstring("line 5: 'vert_correction'"));
  CHECK_THAT(edited("vert_correction: -0.1", "vert_correction: .nan"), ContainsSubstring("expected is a number"));
  CHECK_THAT(edited("vert_correction: -0.1", "vert_correction: nan"), ContainsSubstring("expected is a finite number"));
  CHECK_THAT(edited(", vert_correction: -0.1", ""), ContainsSubstring("'vert_correction' is missing in this laser"));
  CHECK_THAT(edited("laser_id: 1", "laser_id: 0"), ContainsSubstring("two lasers with the 'laser_id' 0"));
  CHECK_THAT(edited("laser_id: 1", "laser_id: 7"), ContainsSubstring("expected is 0 to 1"));
  CHECK_THAT(edited("num_lasers: 2", "num_lasers: 3"), ContainsSubstring("'num_lasers' is 3, but 'lasers' lists 2"));
  CHECK_THAT(edited("vert_correction: -0.1", "vert_correction: -1.7"), ContainsSubstring("elevation of channel 0"));
  CHECK_THAT(edited("lasers:", "lasers: ["), ContainsSubstring("is not YAML"));
  CHECK_THAT(problemOf("lasers: []", "none.yml"), ContainsSubstring("there is no laser"));
  CHECK_THAT(problemOf("a: 1", "none.yml"), ContainsSubstring("no list 'lasers'"));
}

TEST_CASE("VeloView XML: degrees and centimetres, lasers that are not enabled are left out") {
  const SensorFile file = readSensorFile(kVeloViewXml, "db.xml");
  CHECK(file.family == "VeloView calibration");
  REQUIRE(file.sensor.channels.size() == 2);
  CHECK_THAT(file.sensor.channels[0].elevationDeg, WithinAbs(-7.5, 1e-12));
  CHECK_THAT(file.sensor.channels[0].azimuthOffsetDeg, WithinAbs(-3, 1e-12));
  const double e = -7.5 / kDegrees;
  checkOrigin(file.sensor.channels[0].origin, {-0.125 * std::sin(e), -0.026, 0.125 * std::cos(e)});
  CHECK_THAT(file.sensor.channels[1].elevationDeg, WithinAbs(2, 1e-12));
  CHECK(lists(file.ignored, "1 lasers that are not enabled"));
  CHECK(lists(file.ignored, "distCorrection_"));
  CHECK_THAT(file.sensor.rangeMax, WithinAbs(131.07, 1e-9));

  CHECK_THAT(problemOf(replaced(kVeloViewXml, "-7.5", "x"), "db.xml"),
             ContainsSubstring("'vertCorrection_' is 'x'") && ContainsSubstring("line "));
  CHECK_THAT(problemOf("<boost_serialization/>", "db.xml"), ContainsSubstring("boost_serialization/DB/points_"));
  CHECK_THAT(problemOf("<a/>", "db.xml"), ContainsSubstring("is XML of <a>, not of a lidar"));
  CHECK_THAT(problemOf("<a", "db.xml"), ContainsSubstring("is not XML"));
}

TEST_CASE("Ouster metadata: origins turn with the encoder, flat and nested say the same") {
  for (const std::string_view text : {kOusterFlat, kOusterNested}) {
    const SensorFile file = readSensorFile(text, "os.json");
    CHECK(file.family == "Ouster metadata");
    const Sensor& sensor = file.sensor;
    CHECK(sensor.columns == 512);
    CHECK(sensor.rotationPeriod == 0.05);
    REQUIRE(sensor.channels.size() == 2);
    // Column 0 fires when the encoder is at 0 in the lidar's frame, which the sensor's frame turns by 180 degrees.
    CHECK_THAT(azimuthDeg(sensor, 0), WithinAbs(180 - 3, 1e-12));
    CHECK_THAT(azimuthDeg(sensor, 128), WithinAbs(90 - 3, 1e-12));
    CHECK_THAT(azimuthDeg(sensor, 512 + 256), WithinAbs(1.5, 1e-12));
    CHECK(elevationDeg(sensor, 512) == -4);
    checkOrigin(originOf(sensor, 0), {-0.0125, 0, 0.03618});
    checkOrigin(originOf(sensor, 128), {0, 0.0125, 0.03618});
    checkOrigin(originOf(sensor, 512 + 256), {0.0125, 0, 0.03618});
    CHECK_THAT(timeOf(sensor, 512 + 1), WithinAbs(0.05 / 512, 1e-15));
    CHECK(sensor.maskedBeams.empty());
    CHECK(sensor.rangeMax == 170);
  }
  CHECK(readSensorFile(kOusterNested, "os.json").sensor.maxReturns == 2);
  std::string mounted(kOusterNested);
  mounted.insert(mounted.rfind('}'),
                 R"(, "ouster-sdk": {"extrinsic": [0,-1,0,1, 1,0,0,2, 0,0,1,3, 0,0,0,1]}, "return_order": "x")");
  const SensorFile file = readSensorFile(mounted, "os.json");
  CHECK(lists(file.ignored, "the extrinsic"));
  mounted.replace(mounted.find("[0,-1"), mounted.find("3, 0,0,0,1]") + 11 - mounted.find("[0,-1"), "null");
  CHECK(lists(readSensorFile(mounted, "os.json").ignored, "the extrinsic"));
  CHECK(lists(file.ignored, "return_order"));
}

TEST_CASE("Ouster metadata: every mode, and windows of columns are masked beams") {
  struct Mode {
    const char* name;
    uint32_t columns;
    double period;
  };
  for (const Mode& mode : {Mode{"512x10", 512, 0.1}, Mode{"512x20", 512, 0.05}, Mode{"1024x10", 1024, 0.1},
                           Mode{"1024x20", 1024, 0.05}, Mode{"2048x10", 2048, 0.1}, Mode{"4096x5", 4096, 0.2}}) {
    const Sensor sensor = readSensorFile(kOusterFlat, "os.json", {.mode = mode.name}).sensor;
    CHECK(sensor.columns == mode.columns);
    CHECK(sensor.rotationPeriod == mode.period);
  }
  const auto windowed = [](const char* window, const SensorFileOptions& options = {}) {
    return readSensorFile(replaced(kOusterNested, "[0, 511]", window), "os.json", options).sensor.maskedBeams;
  };
  const std::vector<uint32_t> middle = windowed("[128, 255]");
  CHECK(middle.size() == 2 * 384);
  CHECK(std::binary_search(middle.begin(), middle.end(), 127u));
  CHECK_FALSE(std::binary_search(middle.begin(), middle.end(), 128u));
  CHECK_FALSE(std::binary_search(middle.begin(), middle.end(), 512u + 255u));
  const std::vector<uint32_t> wrapped = windowed("[500, 9]");
  CHECK(wrapped.size() == 2 * (512 - 22));
  CHECK_FALSE(std::binary_search(wrapped.begin(), wrapped.end(), 511u));
  CHECK(std::binary_search(wrapped.begin(), wrapped.end(), 10u));
  CHECK(windowed("[128, 255]", {.mode = "1024x10"}).size() == 2 * 768);
  CHECK_THAT(problemOf(replaced(kOusterNested, "[0, 511]", "[0, 512]"), "os.json"),
             ContainsSubstring("'column_window' must be two columns from 0 to 511"));
}

TEST_CASE("Ouster metadata: old firmware states as many angles as the product has lasers") {
  const auto text = [](const std::string& product, int rows, bool padded) {
    std::string altitudes, azimuths;
    for (int row = 0; row < rows; ++row) {
      const bool laser = !padded || row % 4 == 3;
      altitudes.append(row ? ", " : "").append(std::to_string(laser ? 33.25 - row : 0));
      azimuths.append(row ? ", " : "").append(laser ? "-3.1" : "0");
    }
    return "{" + product + R"("lidar_mode": "1024x10", "beam_altitude_angles": [)" + altitudes +
           R"(], "beam_azimuth_angles": [)" + azimuths + "]}";
  };
  // ouster-sdk 1.0 refuses 1_13_os1-991937000062-16A0_legacy.json, an OS-1-16-A0 that lists 64 pixels, and reads it
  // without those that have no laser.
  const std::string small = R"("prod_line": "OS-1-16-A0", )";
  for (const bool padded : {true, false})
    CHECK_THAT(problemOf(text(small, 64, padded), "old.json"),
               ContainsSubstring("has 64 entries, but OS-1-16-A0 has 16 lasers"));
  const SensorFile file = readSensorFile(text(small, 16, false), "old.json");
  CHECK(file.sensor.channels.size() == 16);
  CHECK(file.sensor.maskedBeams.empty());
  CHECK(lists(file.assumed, "15.806 mm"));
  CHECK(lists(file.assumed, "lidar_to_sensor_transform"));
  CHECK_THAT(problemOf(text(small, 15, false), "old.json"), ContainsSubstring("has 15 entries, expected are 16"));
  CHECK(readSensorFile(text(R"("prod_line": "OS-1-64", )", 64, false), "old.json").sensor.channels.size() == 64);

  const Sensor unnamed = readSensorFile(text("", 64, true), "old.json").sensor;
  CHECK(unnamed.channels.size() == 64);
  CHECK(unnamed.maskedBeams.size() == 48 * 1024);
  CHECK(unnamed.maskedBeams[3 * 1024] == 4 * 1024);  // row 3 has a laser
  CHECK_THAT(problemOf(text("", 16, false), "old.json"), ContainsSubstring("expected are 64"));
}

TEST_CASE("Ouster metadata: columns of less than one per turn are refused, because no window divides them") {
  for (const char* count : {"-1e300", "1e-300", "0", "0.5"}) {
    std::string text(kOusterFlat);
    const std::string stated = "\"columns_per_frame\": ";
    text.replace(text.find(stated), stated.size() + 3, stated + count + ", \"column_window\": [0, 0]");
    INFO(count);
    CHECK_THROWS_AS(readSensorFile(text, "a.json", {.mode = "512x10"}), Error);
  }
}

TEST_CASE("Ouster metadata: mistakes are named with their keys") {
  const auto edited = [](const std::string& from, const std::string& to) {
    return problemOf(replaced(kOusterNested, from, to), "os.json");
  };
  CHECK_THAT(edited("[4, -4]", "[4]"), ContainsSubstring("has 1 entries, 'beam_azimuth_angles' 2"));
  CHECK_THAT(edited("[4, -4]", "[0, 0]"), ContainsSubstring("all 'beam_altitude_angles' are 0"));
  CHECK_THAT(edited("[4, -4]", "[4, \"x\"]"), ContainsSubstring("'beam_altitude_angles' has \"x\" at place 1"));
  CHECK_THAT(edited("[4, -4]", "[4, [[[]]]]"), ContainsSubstring("has a list at place 1"));
  CHECK_THAT(edited("[4, -4]", "7"), ContainsSubstring("is not a list of numbers"));
  CHECK_THAT(edited("512x20", "513x20"), ContainsSubstring("known are 512x10, 512x20"));
  CHECK_THAT(edited("512x20", "1024x10"), ContainsSubstring("'columns_per_frame' is 512"));
  CHECK_THAT(edited("\"columns_per_frame\": 512", "\"columns_per_frame\": 4000000000"),
             ContainsSubstring("'columns_per_frame' is 4000000000, which"));
  CHECK_THAT(edited("\"sensor_info\"", "\"sensor\""), ContainsSubstring("lacks 'sensor_info'"));
  CHECK_THAT(edited("\"columns_per_frame\": 512, ", ""), ContainsSubstring("'columns_per_frame' is missing in"));
  CHECK_THAT(edited("\"pixels_per_column\": 2", "\"pixels_per_column\": 3"), ContainsSubstring("expected are 3"));
  CHECK_THAT(edited("0, 0, 1, 36.18,", "0, 1, 0, 36.18,"), ContainsSubstring("more than a turn about z"));
  CHECK_THAT(edited("\"beam_azimuth_angles\"", "\"azimuths\""), ContainsSubstring("'beam_azimuth_angles' is missing"));
  CHECK_THAT(problemOf(kOusterFlat, "os.json", {.columns = 3}), ContainsSubstring("--columns does not apply"));
}

TEST_CASE("Hesai angle correction: rows in any order, clockwise azimuths, a checksum at the end") {
  const SensorFile file = readSensorFile(
      "Channel,Elevation,Azimuth\r\n2,-3.5,-1.042\r\n1,14.25,3.125\r\n"
      "8e6fa4250b12829703efcb5919c2dcbab300635e6f128eaf27bc716e40d8484f,,\r\n",
      "angles.csv", {.scanRate = 20, .columns = 360});
  CHECK(file.family == "Hesai angle correction");
  CHECK(azimuthDeg(file.sensor, 0) == -3.125);
  CHECK_THAT(azimuthDeg(file.sensor, 90), WithinAbs(-93.125, 1e-12));
  CHECK(file.sensor.channels[0].elevationDeg == 14.25);
  CHECK_THAT(azimuthDeg(file.sensor, 360), WithinAbs(1.042, 1e-12));
  CHECK(file.sensor.rotationPeriod == 0.05);
  CHECK(file.assumed.size() == 1);  // the range
  CHECK_THAT(readSensorFile("EEFF,1,1\nLaser id,Azimuth,Elevation\n1,2,3\n", "q.csv").sensor.channels[0].elevationDeg,
             WithinAbs(3, 0));
}

TEST_CASE("Hesai angle correction: the SHA-256 in the last row is that of the rows above with CR LF") {
  const std::string hash = "8e6fa4250b12829703efcb5919c2dcbab300635e6f128eaf27bc716e40d8484f";  // of Python
  const std::string rows = "Channel,Elevation,Azimuth\n2,-3.5,-1.042\n1,14.25,3.125\n";
  CHECK(readSensorFile(rows + hash + ",,\n", "a.csv").sensor.channels.size() == 2);
  CHECK_THAT(problemOf(replaced(rows, "3.125", "3.126") + hash + ",,\n", "a.csv"),
             ContainsSubstring("is damaged: the lines above line 4 do not have the SHA-256"));
}

TEST_CASE("Hesai angle correction: a flash lidar has a row per pixel") {
  // Pixels of PandarFT_Correction.csv in HesaiLidar_Swift_ROS: the first two of its last column but one.
  const std::string text =
      "Channel,Column_id,Elevation,Azimuth\n2,1,26.71708365,133.1570662\n1,1,27.16471035,133.2859485\n"
      "2,2,26.65549469,133.6896303\n1,2,27.10187776,133.819671\n";
  const Sensor sensor = readSensorFile(text, "ft.csv").sensor;
  CHECK(sensor.width() == 2);
  CHECK(sensor.height() == 2);
  CHECK_THAT(azimuthDeg(sensor, 1), WithinAbs(90 - 133.819671, 1e-9));
  CHECK_THAT(elevationDeg(sensor, 2), WithinAbs(26.71708365, 1e-9));
  CHECK(ringOf(sensor, 2) == 1);
  CHECK_THAT(problemOf(replaced(text, "1,2,27", "1,1,27"), "ft.csv"), ContainsSubstring("was there before"));
  CHECK_THAT(problemOf(replaced(text, "1,2,27", "3,2,27"), "ft.csv"), ContainsSubstring("lists 4 pixels, but has 3"));
  CHECK_THAT(problemOf(replaced(text, "1,2,27", "1,5000,27"), "ft.csv"), ContainsSubstring("expected is 1 to 4096"));
}

TEST_CASE("RoboSense's angles are clockwise, and rings are numbered from below") {
  // The lines are the first four lasers of the file RobosenseBpearl.csv of tier4/nebula.
  const SensorFile file = readSensorFile("2.31,-0.03\t\n47.32,-0.67\n5.12,-0.05\n50.13,-0.74,\n", "angle.csv");
  CHECK(file.family == "RoboSense angles");
  REQUIRE(file.sensor.channels.size() == 4);
  CHECK(file.sensor.channels[1].elevationDeg == 5.12);
  CHECK(file.sensor.channels[1].azimuthOffsetDeg == 0.05);
  CHECK(file.sensor.channels[3].azimuthOffsetDeg == 0.74);
  CHECK(file.sensor.azimuthSpanDeg == -360);
  CHECK_THAT(problemOf("2.31,-0.03\n47,32,-0,67\n", "angle.csv"), ContainsSubstring("line 2 has 4 cells"));
  CHECK_THAT(problemOf("2.31,-0.03\nx,1\n", "angle.csv"), ContainsSubstring("line 2, vertical angle is 'x'"));
}

TEST_CASE("Hesai angle correction: mistakes are named with their lines") {
  const auto rows = [](const std::string& text) { return problemOf("Channel,Elevation,Azimuth\n" + text, "a.csv"); };
  CHECK_THAT(rows("1,2,3\n1,2,3\n"), ContainsSubstring("line 3: channel 1 was there before"));
  CHECK_THAT(rows("1,2,3\n3,2,3\n"), ContainsSubstring("channel 2 is missing"));
  CHECK_THAT(rows("1,2\n"), ContainsSubstring("line 2 has 2 cells"));
  CHECK_THAT(rows("1,14,882,-1,042\n"), ContainsSubstring("line 2 has 5 cells, expected are 3; decimals need a point"));
  CHECK_THAT(problemOf("1,2,3\n2,14,882,-1\n", "a.csv", {.columns = 8}), ContainsSubstring("line 2 has 4 cells"));
  CHECK_THAT(rows("1,x,3\n"), ContainsSubstring("line 2, elevation is 'x'"));
  CHECK_THAT(rows("1,inf,3\n"), ContainsSubstring("finite"));
  CHECK_THAT(rows("65536,1,3\n"), ContainsSubstring("expected is 1 to 65535"));
  CHECK_THAT(rows("1,91,3\n"), ContainsSubstring("line 2, elevation is '91', expected is -90 to 90"));
  CHECK_THAT(rows(""), ContainsSubstring("there is no channel"));
}

TEST_CASE("Hesai firing times delay channels, turn the head on, and alternate with the columns") {
  const Folder folder;
  const std::string angles = "Channel,Elevation,Azimuth\n1,1,0\n2,-1,5\n";
  const auto read = [&](const std::string& times, const std::string& mode = "") {
    put(folder / "times.csv", times);
    return readSensorFile(angles, "a.csv",
                          {.mode = mode, .scanRate = 10, .columns = 360, .fireTimes = folder / "times.csv"});
  };
  SECTION("one time per channel") {
    const Sensor sensor = read("Channel,fire time(us)\n2,-50\n1,-3.5\n").sensor;
    CHECK_THAT(sensor.channels[0].timeOffset, WithinAbs(-3.5e-6, 1e-18));
    CHECK_THAT(sensor.channels[1].timeOffset, WithinAbs(-50e-6, 1e-18));
    CHECK_THAT(azimuthDeg(sensor, 360), WithinAbs(-5 + 3600 * 50e-6, 1e-12));
  }
  SECTION("states") {
    const std::string states = "Operational State,0,0,2\nAzimuth State,0,1,0\n1,-,10,30\n2,0,2.5,1\n";
    const Sensor sensor = read(states).sensor;
    REQUIRE(sensor.patterns.size() == 1);
    CHECK(sensor.width() == 360);
    CHECK(sensor.height() == 2);
    CHECK(sensor.maskedBeams.size() == 180);
    CHECK(sensor.maskedBeams[1] == 2);
    CHECK_THAT(timeOf(sensor, 1), WithinAbs(0.1 / 360 + 10e-6, 1e-15));
    CHECK_THAT(azimuthDeg(sensor, 1), WithinAbs(-1 - 3600 * 10e-6, 1e-9));
    CHECK_THAT(timeOf(sensor, 360 + 3), WithinAbs(0.3 / 360 + 2.5e-6, 1e-15));
    CHECK(ringOf(sensor, 363) == 1);
    CHECK_THAT(read(states, "2").sensor.channels[0].timeOffset, WithinAbs(30e-6, 1e-18));
    CHECK_THROWS_WITH(read(states, "1"), ContainsSubstring("no operational state '1'"));
  }
  SECTION("loops of pairs") {
    const Sensor sensor = read("EEFF,1,1\nChannel num,2,Loop num,2\nID,us,ID,us\n1,4,2,8\n2,6,1,10\n").sensor;
    CHECK_THAT(timeOf(sensor, 0), WithinAbs(4e-6, 1e-15));
    CHECK_THAT(timeOf(sensor, 360 + 1), WithinAbs(0.1 / 360 + 8e-6, 1e-15));
  }
  SECTION("surplus cells") {
    CHECK_THROWS_WITH(read("Channel,fire time(us)\n1,2,5\n2,3,0\n"), ContainsSubstring("line 2 has 3 cells"));
    CHECK_THAT(read("Channel,fire time(us)\n1,2.5,,\n2,3,\n").sensor.channels[0].timeOffset, WithinAbs(2.5e-6, 1e-18));
    CHECK_THROWS_WITH(read("Operational State,0,2\nAzimuth State,0,0\n1,1,5,2,5\n"), ContainsSubstring("has 5 cells"));
  }
  SECTION("a Pandar128E3X does not fire in the states in which it states 0 twice") {
    // Channels 25 and 26 of laser-ts.csv in HesaiLidar_Swift_ROS.
    const char* text =
        "2.85,distance>=A1,distance<A1,distance>=A1,distance<A1,distance>=A1,distance<A1,distance>=A1,distance<A1,"
        "distance>=A1,distance<A1,distance>=A1,distance<A1,distance>=A1,distance<A1,distance>=A1,distance<A1\n"
        "operation mode,0,0,0,0,0,0,0,0,2,2,2,2,3,3,3,3\n"
        "angle state,0,0,1,1,2,2,3,3,0,0,1,1,0,0,1,1\n"
        "1,4558,4558,0,0,4558,4558,0,0,4558,4558,4558,4558,4558,4558,4558,4558\n"
        "2,11227,11227,11477,13130,11227,11227,10811,10811,39255,40908,38589,38589,39255,40908,38589,38589\n";
    const Sensor sensor = read(text).sensor;
    REQUIRE(sensor.patterns.size() == 1);
    CHECK(sensor.beamCount() == 2 * 360);
    CHECK(sensor.maskedBeams.size() == 180);  // channel 1 rests in every second column
    CHECK(sensor.maskedBeams[0] == 1);
    CHECK_THAT(timeOf(sensor, 2), WithinAbs(0.2 / 360 + 4.558e-6, 1e-15));
    CHECK_THAT(timeOf(sensor, 360 + 3), WithinAbs(0.3 / 360 + 10.811e-6, 1e-15));
    CHECK(read(text, "2").sensor.maskedBeams.empty());
    CHECK_THAT(problemOf(text, "times.csv"), ContainsSubstring("is a Hesai file of firing times"));
  }
  SECTION("a channel configuration says which channels fire in turn") {
    const char* text = "EEFF,1,1\nChannel num,2,Block num,2\nLoop 1,Loop 2\n1,2\n2,0\n";
    const SensorFile file = read(text);
    CHECK(file.sensor.maskedBeams.size() == 180);  // channel 1 rests in every second column
    CHECK(file.sensor.maskedBeams[0] == 1);
    CHECK(lists(file.assumed, "no firing times are stated"));
    CHECK_THAT(problemOf(text, "config.csv"), ContainsSubstring("is a Hesai file of firing times"));
  }
  SECTION("far and near") {
    std::string text = "Distance 2.85\nx\ny\n";
    for (const char* row : {"1", "2"}) {
      text += row;
      for (int i = 1; i <= 16; ++i) text.append(",").append(std::to_string(1000 * i));
      text += "\n";
    }
    const SensorFile file = read(text, "2");
    CHECK_THAT(timeOf(file.sensor, 0), WithinAbs(9e-6, 1e-15));
    CHECK_THAT(timeOf(file.sensor, 1), WithinAbs(0.1 / 360 + 11e-6, 1e-15));
    CHECK(lists(file.ignored, "near surfaces"));
  }
  SECTION("mistakes") {
    CHECK_THROWS_WITH(read("Channel,fire time(us)\n1,2\n"), ContainsSubstring("channel 2 of the angle correction"));
    CHECK_THROWS_WITH(read("Channel,fire time(us)\n3,2\n"), ContainsSubstring("line 2: the channel is 3"));
    CHECK_THROWS_WITH(read("Channel,fire time(us)\n1,x\n"), ContainsSubstring("line 2, time is 'x'"));
    CHECK_THROWS_WITH(read("nothing\n"), ContainsSubstring("is no file of Hesai's firing times"));
    CHECK_THROWS_WITH(read(""), ContainsSubstring("is empty"));
    CHECK_THAT(problemOf("Channel,fire time(us)\n1,2\n", "times.csv"), ContainsSubstring("--fire-times"));
  }
}

TEST_CASE("Hesai binary: AT128 has a pattern per mirror face, whose corrections depend on the column") {
  const SensorFile file = readSensorFile(hesaiMirrors(), "at.dat");
  CHECK(file.family == "Hesai binary angle correction");
  const Sensor& sensor = file.sensor;
  REQUIRE(sensor.patterns.size() == 2);
  CHECK(sensor.width() == 1200);
  CHECK(sensor.height() == 2);
  // Channel 0: azimuth -2.4, elevation 1.5 degrees. The head is at 20 + 15 degrees in the first column of face 0, where
  // the corrections are those of 34 and 36 degrees, 4 and 8 hundredths, in the middle: 6.
  CHECK_THAT(azimuthDeg(sensor, 0), WithinAbs(90 - (30 + 2.4 + 0.06), 1e-9));
  CHECK_THAT(elevationDeg(sensor, 0), WithinAbs(1.5 - 0.06, 1e-9));
  // A column later they are rounded: at 35.05 degrees of the head, 6.1 to 6.
  CHECK_THAT(azimuthDeg(sensor, 1), WithinAbs(90 - (30.1 + 2.4 + 0.06), 1e-9));
  CHECK_THAT(azimuthDeg(sensor, 600), WithinAbs(90 - (90 + 2.4), 1e-9));
  CHECK_THAT(azimuthDeg(sensor, 1200), WithinAbs(90 - (30 - 0.65), 1e-9));
  CHECK_THAT(azimuthDeg(sensor, 0, 1), WithinAbs(90 - (30 + 2.4), 1e-9));
  CHECK_THAT(timeOf(sensor, 2), WithinAbs(0.1 / 1200, 1e-15));  // 0.1 degrees of the head's 1200 per second
  const std::string bytes = hesaiMirrors();
  CHECK_THAT(problemOf(std::string_view(bytes).substr(0, 100), "at.dat"), ContainsSubstring("ends after 100 bytes"));
  CHECK_THAT(problemOf(std::string_view(bytes).substr(0, bytes.size() - 1), "at.dat"),
             ContainsSubstring("its SHA-256"));
  for (const std::string& whole : {hesaiMirrors(), hesaiParity()}) {
    std::string damaged = whole;
    damaged[whole.size() - 40] = static_cast<char>(damaged[whole.size() - 40] ^ 1);
    CHECK_THAT(problemOf(damaged, "at.dat"), ContainsSubstring("is damaged: its content does not have the SHA-256"));
  }
  CHECK_THAT(problemOf("\xee\xff\x07\x07", "at.dat"), ContainsSubstring("version 7.7"));
  CHECK_THAT(problemOf("not a binary file", "at.dat"), ContainsSubstring("does not start with EE FF, as Hesai"));
}

TEST_CASE("Hesai binary: ATX has a pattern for even and one for odd frames") {
  const Folder folder;
  put(folder / "times.csv", "Channel,Even_fire time(ns),Odd_fire time(ns)\n1,4960,500\n2,0,7000\n");
  const std::string bytes = hesaiParity();
  const Sensor sensor = readSensorFile(bytes, "atx.dat", {.fireTimes = folder / "times.csv"}).sensor;
  REQUIRE(sensor.patterns.size() == 2);
  CHECK_THAT(azimuthDeg(sensor, 0, 0), WithinAbs(90 - (30 + 4.0), 1e-9));
  CHECK_THAT(azimuthDeg(sensor, 0, 1), WithinAbs(90 - (30 - 2.0), 1e-9));
  CHECK_THAT(elevationDeg(sensor, 1200), WithinAbs(-7.5, 1e-9));
  CHECK_THAT(timeOf(sensor, 0, 0), WithinAbs(4.96e-6, 1e-18));
  CHECK_THAT(timeOf(sensor, 1200, 1), WithinAbs(7e-6, 1e-18));

  put(folder / "times.csv", "Channel,Even_fire time(ns),Odd_fire time(ns)\n1,-4960,500\n2,0,7000\n");
  const SensorFile early = readSensorFile(bytes, "atx.dat", {.fireTimes = folder / "times.csv"});
  CHECK(timeOf(early.sensor, 0, 0) == 0);
  CHECK_THAT(timeOf(early.sensor, 1200, 1), WithinAbs(11.96e-6, 1e-18));
  CHECK(lists(early.assumed, "4.96 us before its first column"));
  put(folder / "times.csv", "Channel,Even_fire time(ns),Odd_fire time(ns)\n1,-,500\n2,0,7000\n");
  CHECK_THAT(problemOf(bytes, "atx.dat", {.fireTimes = folder / "times.csv"}),
             ContainsSubstring("channel 1 does not fire"));
}

TEST_CASE("Hesai binary: a flash lidar lists its pixels column by column") {
  std::string bytes("\xee\xff\x01\x00\x00\x00\x02\x03\x05", 9);  // 2 columns, 3 rows, units of 0.05 degrees
  for (const int azimuth : {40, 41, 42, 140, 141, 142}) put<int16_t>(bytes, static_cast<int16_t>(20 * azimuth));
  for (const int elevation : {-30, 0, 30, -31, 1, 31}) put<int16_t>(bytes, static_cast<int16_t>(20 * elevation));
  bytes += std::string(32, 'h');
  const Sensor sensor = readSensorFile(bytes, "ft.dat").sensor;
  CHECK(sensor.width() == 2);
  CHECK(sensor.height() == 3);
  CHECK_THAT(azimuthDeg(sensor, 0), WithinAbs(50, 1e-9));
  CHECK_THAT(azimuthDeg(sensor, 5), WithinAbs(90 - 142, 1e-9));
  CHECK_THAT(elevationDeg(sensor, 4), WithinAbs(30, 1e-9));
  CHECK(ringOf(sensor, 4) == 2);
  CHECK_THAT(problemOf(bytes.substr(0, 20), "ft.dat"), ContainsSubstring("ends after 20 bytes"));
}

TEST_CASE("beam tables: azimuth and zenith, times of one scan or a count of beams") {
  const SensorFile file = readSensorFile("Time/s,Azimuth/deg,Zenith/deg\n0,10,90\n0.00001,350,60\n\n", "l.csv");
  CHECK(file.family == "beam table");
  REQUIRE(file.sensor.patterns.size() == 1);
  CHECK_THAT(azimuthDeg(file.sensor, 0), WithinAbs(10, 1e-12));
  CHECK_THAT(azimuthDeg(file.sensor, 1), WithinAbs(-10, 1e-12));
  CHECK_THAT(elevationDeg(file.sensor, 1), WithinAbs(30, 1e-12));
  CHECK_THAT(timeOf(file.sensor, 1), WithinAbs(1e-5, 1e-18));

  const std::string counted = "Time/s,Azimuth/deg,Zenith/deg\n1,0,90\n2,1,90\n3,2,90\n800000,3,90\n5,4,90\n";
  const SensorFile scans = readSensorFile(counted, "l.csv", {.scanRate = 20, .beamsPerScan = 2});
  REQUIRE(scans.sensor.patterns.size() == 2);
  CHECK_THAT(azimuthDeg(scans.sensor, 1, 1), WithinAbs(3, 1e-12));
  CHECK(timeOf(scans.sensor, 1, 1) == 0.025);
  CHECK(lists(scans.ignored, "800000"));
  CHECK(lists(scans.ignored, "the last 1 beams"));
  CHECK(readSensorFile(counted, "l.csv").sensor.patterns[0].times.empty());

  CHECK_THAT(problemOf("Time/s,Azimuth/deg,Zenith/deg\n0,1\n", "l.csv"), ContainsSubstring("line 2 has 2 cells"));
  CHECK_THAT(problemOf("Time/s,Azimuth/deg,Zenith/deg\n0,0,1,5,90\n", "l.csv"),
             ContainsSubstring("decimals need a point"));
  CHECK(readSensorFile("Time/s,Azimuth/deg,Zenith/deg\n0,1,90,,\n", "l.csv").sensor.beamCount() == 1);
  CHECK_THAT(problemOf("Time/s,Azimuth/deg,Zenith/deg\n0,1,b\n", "l.csv"), ContainsSubstring("Zenith/deg is 'b'"));
  CHECK_THAT(problemOf("Time/s,Azimuth/deg,Zenith/deg\n0,1,200\n", "l.csv"), ContainsSubstring("no angles of a beam"));
  CHECK_THAT(problemOf("Time/s,Azimuth/deg,Zenith/deg\n", "l.csv"), ContainsSubstring("the pattern has no beam"));
  CHECK_THAT(problemOf("Azimuth/deg,Zenith/deg,ring\n0,1,65536\n", "l.csv"), ContainsSubstring("0..65535"));
}

TEST_CASE("beam tables: stated firing times, units, origins, windows and patterns, and columns of other names") {
  const std::string timed = "Time/us,Azimuth/deg,Zenith/deg\n5,10,90\n6,20,80\n7,10,90\n9,20,80\n";
  const SensorFile cut = readSensorFile(timed, "l.csv", {.scanRate = 20, .beamsPerScan = 2});
  REQUIRE(cut.sensor.patterns.size() == 2);
  CHECK_THAT(timeOf(cut.sensor, 0, 0), WithinAbs(0, 1e-15));
  CHECK_THAT(timeOf(cut.sensor, 1, 0), WithinAbs(1e-6, 1e-15));
  CHECK_THAT(timeOf(cut.sensor, 1, 1), WithinAbs(2e-6, 1e-15));
  CHECK(lists(cut.ignored, "the scan rate"));

  // Each scan of a long recording has its own start.
  std::string recording = "Time/s,Azimuth/deg,Zenith/deg\n";
  for (int i = 0; i < 40; ++i) recording += std::to_string(0.5 * i) + ",10,90\n";
  const SensorFile scans = readSensorFile(recording, "l.csv", {.beamsPerScan = 4});
  REQUIRE(scans.sensor.patterns.size() == 10);
  CHECK_THAT(timeOf(scans.sensor, 3, 9), WithinAbs(1.5, 1e-12));
  CHECK(lists(readSensorFile(recording, "l.csv").ignored, "which are not those of one scan"));
  const Sensor spread =
      readSensorFile("azimuth,elevation,pattern\n0,0,0\n1,0,0\n0,0,1\n1,0,1\n", "p.csv", {.scanRate = 20}).sensor;
  CHECK_THAT(timeOf(spread, 1, 1), WithinAbs(0.025, 1e-12));
  // The scan of a head whose sector is less than a turn takes all the time.
  std::string beams = "azimuth,elevation\n";
  for (int i = 0; i < 811; ++i) beams += std::to_string(i / 3.0) + ",0\n";
  const Sensor tim = readSensorFile(beams, "t.csv", {.head = "TiM781"}).sensor;
  CHECK_THAT(timeOf(tim, 810), WithinAbs(810 / 16200.0, 1e-9));
  CHECK_THAT(readSensorFile("azimuth,elevation,origin_x_mm,origin_y_mm,origin_z_mm\n0,0,1,2,3\n", "o.csv")
                 .sensor.patterns[0]
                 .origins[0]
                 .y,
             WithinAbs(0.002, 1e-12));

  const SensorFile file = readSensorFile(
      "index,azimuth_deg,elevation_deg,origin_x,origin_y,origin_z,range_min,range_max,pattern,foo\n"
      "0,10,5,0.1,0.2,0.3,5,60,0,1\n0,20,5,0,0,0,6,70,1,1\n",
      "b.csv");
  REQUIRE(file.sensor.patterns.size() == 2);
  checkOrigin(originOf(file.sensor, 0, 0), {0.1, 0.2, 0.3});
  CHECK_THAT(azimuthDeg(file.sensor, 0, 1), WithinAbs(20, 1e-12));
  CHECK(rangeWindowOf(file.sensor, 0, 0).least == 5);
  CHECK(rangeWindowOf(file.sensor, 0, 1).most == 70);
  CHECK(file.sensor.rangeMax == 70);
  CHECK(file.ignored == std::vector<std::string>{"the column 'foo'"});
  CHECK_THAT(problemOf("azimuth,elevation,origin_x\n0,0,0\n", "b.csv"), ContainsSubstring("origin_y and origin_z"));
  CHECK_THAT(problemOf("azimuth,elevation,range_max\n0,0,0\n", "b.csv"), ContainsSubstring("range_min and range_max"));
  CHECK_THAT(problemOf("azimuth,elevation,range_min,range_max\n0,0,60,50\n", "b.csv"),
             ContainsSubstring("range min of beam 0 must be at most its range max, 50, is 60"));
  CHECK_THAT(problemOf("azimuth,elevation,pattern\n0,0,1\n", "b.csv"), ContainsSubstring("directions are empty"));
}

TEST_CASE("NumPy arrays: angles, directions and poses, in either order of bytes and of indices") {
  const std::vector<double> directions = {2, 0, 0, 0, 0, 3};
  for (const char* type : {"<f4", ">f4", "<f8", ">f8"}) {
    const Sensor sensor = readSensorFile(npy(type, false, {2, 3}, directions), "d.npy").sensor;
    CHECK(sensor.direction(0).x == 1);
    CHECK(sensor.direction(1).z == 1);
  }
  const Sensor halves = readSensorFile(npy("<f2", false, {2, 3}, {-1, 0, 0, 0, 0, 1}), "h.npy").sensor;
  CHECK(halves.direction(0).x == -1);
  CHECK(halves.direction(1).z == 1);
  // 1.5, -2 and the smallest half above 0, as NumPy's float16 has them.
  std::string bits = npy("<f2", false, {1, 3}, {0, 0, 0});
  bits.resize(bits.size() - 6);
  const Vec3 d = readSensorFile(bits + std::string("\x00\x3e\x00\xc0\x01\x00", 6), "h.npy").sensor.direction(0);
  CHECK_THAT(d.x, WithinAbs(0.6, 1e-7));
  CHECK_THAT(d.y, WithinAbs(-0.8, 1e-7));
  CHECK_THAT(d.z, WithinAbs(std::ldexp(1, -24) / 2.5, 1e-15));
  for (const char* type : {"<i4", ">i4", "|i1"}) {
    const Vec3 whole = readSensorFile(npy(type, false, {1, 3}, {-3, 0, 4}), "i.npy").sensor.direction(0);
    CHECK(whole.x == -0.6);
    CHECK(whole.z == 0.8);
  }
  const Sensor fortran = readSensorFile(npy("<f8", true, {2, 3}, {2, 0, 0, 0, 0, 3}), "d.npy").sensor;
  CHECK(fortran.direction(1).z == 1);
  CHECK(fortran.direction(0).x == 1);

  const Sensor angles = readSensorFile(npy("<f4", false, {1, 2}, {0.5, -0.25}), "l.npy").sensor;
  CHECK_THAT(azimuthDeg(angles, 0), WithinAbs(0.5 * kDegrees, 1e-12));
  CHECK_THAT(elevationDeg(angles, 0), WithinAbs(-0.25 * kDegrees, 1e-12));

  const std::vector<double> pose = {0, 0, -1, 1, 0, 1, 0, 2, 1, 0, 0, 3};  // z points to -x
  for (const std::vector<uint64_t>& shape : {std::vector<uint64_t>{1, 12}, {1, 3, 4}}) {
    const Sensor sensor = readSensorFile(npy("<f8", false, shape, pose), "p.npy").sensor;
    CHECK(sensor.direction(0).x == -1);
    checkOrigin(sensor.patterns[0].origins[0], {1, 2, 3});
  }
  std::vector<double> square = pose;
  square.insert(square.end(), {0, 0, 0, 1});
  CHECK(readSensorFile(npy("<f8", false, {1, 4, 4}, square), "p.npy").sensor.direction(0).x == -1);
  const Sensor image = readSensorFile(npy("<f8", false, {2, 1, 3}, directions), "i.npy").sensor;
  CHECK(image.height() == 2);
  CHECK(image.width() == 1);
}

TEST_CASE("NumPy arrays: mistakes") {
  CHECK_THAT(problemOf(npy("<f8", false, {2, 5}, std::vector<double>(10)), "a.npy"), ContainsSubstring("shape 2 x 5"));
  CHECK_THAT(problemOf(npy("<f8", false, {0, 3}, {}), "a.npy"), ContainsSubstring("no beam"));
  CHECK_THAT(problemOf(npy("<f8", false, {1, 3}, {0, 0, 0}), "a.npy"), ContainsSubstring("beam 0 has no length"));
  CHECK_THAT(problemOf(npy("<f8", false, {1, 3}, {0, NAN, 0}), "a.npy"), ContainsSubstring("is not finite"));
  CHECK_THAT(problemOf(npy("<f8", false, {1, 2}, {0, INFINITY}), "a.npy"), ContainsSubstring("not finite"));
  CHECK_THAT(problemOf(npy("<f8", false, {2, 3}, {1, 0, 0}), "a.npy"), ContainsSubstring("its shape needs 48"));
  CHECK_THAT(problemOf(npy("<c8", false, {1, 3}, {1, 0, 0}), "a.npy"), ContainsSubstring("expected are floats"));
  CHECK_THAT(problemOf("\x93NUMPY\x01", "a.npy"), ContainsSubstring("too short"));
  CHECK_THAT(problemOf("glTF" + std::string(60, '\2'), "a.npy"), ContainsSubstring("as NPY files do"));
  CHECK_THAT(problemOf(npy("<f4", false, {1000, 2}, {0, 0}), "a.npy"),
             ContainsSubstring("has 8 bytes of data, its shape needs more"));
}

TEST_CASE("ray matrices: a ray starts at the translation and points along z") {
  const float pose[12] = {0, 0, 0, 0.5f, 0, 0, 2, 0.25f, 0, 0, 0, -1};
  std::string bytes(reinterpret_cast<const char*>(pose), sizeof(pose));
  const SensorFile file = readSensorFile(bytes, "r.mat3x4f");
  CHECK(file.family == "ray matrices");
  CHECK(file.sensor.direction(0).y == 1);
  checkOrigin(file.sensor.patterns[0].origins[0], {0.5, 0.25, -1});
  CHECK(readSensorFile(bytes, "without ending").family == "ray matrices");
  bytes.pop_back();
  CHECK_THAT(problemOf(bytes, "r.mat3x4f"), ContainsSubstring("has 47 bytes, expected is a multiple of 48"));
  CHECK_THAT(problemOf(std::string(48, '\0'), "r.mat3x4f"), ContainsSubstring("has no length"));
  CHECK_THAT(problemOf("", "r.mat3x4f"), ContainsSubstring("is empty"));
}

TEST_CASE("Isaac Sim: a rotary profile is a grid at exact firing times") {
  const SensorFile file = readSensorFile(kIsaacRotary, "i.json");
  CHECK(file.family == "Isaac Sim profile");
  const Sensor& sensor = file.sensor;
  CHECK(sensor.isGrid());
  CHECK(sensor.columns == 333);  // 3333 firings a second, 10 turns
  CHECK_THAT(azimuthDeg(sensor, 0), WithinAbs(6.5, 1e-12));
  CHECK_THAT(azimuthDeg(sensor, 10), WithinAbs(6.5 - 36000.0 / 3333, 1e-12));
  CHECK_THAT(timeOf(sensor, 333 + 10), WithinAbs(10.0 / 3333 + 2.665e-6, 1e-15));
  checkOrigin(sensor.channels[1].origin, {0, 0.01, 0.066});
  CHECK(rangeWindowOf(sensor, 0).most == 200);
  CHECK(rangeWindowOf(sensor, 333).least == 2);
  CHECK(rangeWindowOf(sensor, 333).most == 50);
  CHECK(sensor.maxReturns == 2);
  CHECK(lists(file.ignored, "wavelengthNm"));
  CHECK(lists(file.ignored, "bank of the emitters"));
  CHECK_FALSE(lists(file.ignored, "comment"));

  const std::string turned = replaced(kIsaacRotary, "\"CW\"", "\"CCW\"");
  CHECK_THAT(azimuthDeg(readSensorFile(turned, "i.json").sensor, 10), WithinAbs(6.5 + 36000.0 / 3333, 1e-12));
}

TEST_CASE("Isaac Sim: emitter states follow each other, in a turn or from scan to scan") {
  std::string text = replaced(kIsaacRotary, "\"emitterStateCount\": 1", "\"emitterStateCount\": 2");
  text =
      replaced(text, "\"emitterStates\": [", R"("emitterStates": [{"azimuthDeg": [1, 2], "elevationDeg": [30, 40]}, )");
  const Sensor turning = readSensorFile(text, "i.json").sensor;
  REQUIRE(turning.patterns.size() == 1);
  CHECK(turning.width() == 333);
  CHECK_THAT(elevationDeg(turning, 0), WithinAbs(30, 1e-12));
  CHECK_THAT(elevationDeg(turning, 1), WithinAbs(-11.75, 1e-12));
  CHECK_THAT(azimuthDeg(turning, 333 + 2), WithinAbs(2 - 2 * 3600.0 / 3333, 1e-12));
  CHECK(ringOf(turning, 333) == 1);

  const Sensor solid = readSensorFile(replaced(text, "rotary", "solidState"), "i.json").sensor;
  REQUIRE(solid.patterns.size() == 2);
  CHECK_THAT(elevationDeg(solid, 1, 0), WithinAbs(40, 1e-12));
  CHECK_THAT(elevationDeg(solid, 0, 1), WithinAbs(-11.75, 1e-12));
}

TEST_CASE("Isaac Sim: mistakes are named with their keys") {
  const auto edited = [](const std::string& from, const std::string& to) {
    return problemOf(replaced(kIsaacRotary, from, to), "i.json");
  };
  CHECK_THAT(edited("[-11.75, 3.5]", "[-11.75]"), ContainsSubstring("'elevationDeg' has 1 entries, 'azimuthDeg' 2"));
  CHECK_THAT(edited("\"numberOfEmitters\": 2", "\"numberOfEmitters\": 3"),
             ContainsSubstring("'numberOfEmitters' is 3"));
  CHECK_THAT(edited("\"emitterStateCount\": 1", "\"emitterStateCount\": 9"), ContainsSubstring("has 1 entries"));
  CHECK_THAT(edited("\"rangeId\": [0, 1]", "\"rangeId\": [0, 2]"), ContainsSubstring("'ranges' has 2 entries"));
  CHECK_THAT(edited("\"bank\"", "\"channelId\": [0, 65536], \"bank\""), ContainsSubstring("no ring from 0 to 65535"));
  CHECK_THAT(edited("\"rotary\"", "\"spinning\""), ContainsSubstring("expected is rotary or solidState"));
  CHECK_THAT(edited("3333", "5"), ContainsSubstring("firings and turns per second"));
  CHECK_THAT(edited("-11.75", "-98"), ContainsSubstring("elevation of channel 0"));
  CHECK_THAT(edited("\"profile\"", "\"profil\""), ContainsSubstring("of no known family"));
}

TEST_CASE("Hesai binary: an ET25's lasers are led by mirrors, as the vendor's decoder does") {
  std::string bytes("\xee\xff\x03\x02\x00\x00\x02\x01\x00\x01", 10);  // two channels, units of 1/256 degree
  for (const double degrees : {1.0, -2.0, 0.5, 3.0, -5.0, 4.0, -8.0})
    put<int16_t>(bytes, static_cast<int16_t>(256 * degrees));
  bytes += std::string("\x78\x19", 2);  // nodes every 60 and 12.5 degrees: 3 x 3 of them
  for (const int node : {0, 1, 2, 3, 4, 5, 6, 7, 8}) put<int16_t>(bytes, static_cast<int16_t>(16 * node));
  for (const int node : {0, -1, -2, -3, -4, -5, -6, -7, -8}) put<int16_t>(bytes, static_cast<int16_t>(16 * node));
  const Sensor sensor = readSensorFile(bytes + sha256(bytes), "et.dat").sensor;
  CHECK(sensor.width() == 1200);
  CHECK(sensor.height() == 2);
  // Three beams by the formulas of udp2_5_parser.cc in Python.
  const struct {
    size_t beam;
    double azimuth, elevation;
  } expected[] = {{600, 3.339440698928, 4.671368404628},
                  {300, -26.712613421997, 4.673608171651},
                  {2100, 25.112889187530, -7.180650509172}};
  for (const auto& [beam, azimuth, elevation] : expected) {
    CHECK_THAT(azimuthDeg(sensor, beam), WithinAbs(-azimuth, 1e-9));
    CHECK_THAT(elevationDeg(sensor, beam), WithinAbs(elevation, 1e-9));
  }
  CHECK_THAT(problemOf(bytes + std::string(32, 'h'), "et.dat"), ContainsSubstring("is damaged"));
}

TEST_CASE("SDF: both ends of a range of angles are beams, of a whole turn one of them") {
  const std::string text = R"(<?xml version="1.0"?><sdf version="1.9"><model name="m"><link name="l">
    <sensor name="camera" type="camera"/>
    <sensor name="front" type="gpu_lidar"><update_rate>10</update_rate><lidar><scan>
      <horizontal><samples>5</samples><resolution>1</resolution><min_angle>-0.7853981633974483</min_angle>
        <max_angle>0.7853981633974483</max_angle></horizontal>
      <vertical><samples>3</samples><min_angle>-0.2617993877991494</min_angle><max_angle>0.5235987755982988</max_angle>
      </vertical></scan><range><min>0.08</min><max>10.5</max><resolution>0.01</resolution></range></lidar></sensor>
    <sensor name="round" type="ray"><ray><scan><horizontal><samples>9</samples><min_angle>-3.141592653589793</min_angle>
        <max_angle>3.141592653589793</max_angle></horizontal></scan><range><min>1</min><max> 30 </max></range></ray>
    </sensor></link></model></sdf>)";
  const SensorFile file = readSensorFile(text, "model.sdf");
  CHECK(file.family == "SDF lidar");
  CHECK(file.sensor.name == "front");
  CHECK(file.sensor.columns == 5);
  REQUIRE(file.sensor.channels.size() == 3);
  CHECK_THAT(azimuthDeg(file.sensor, 0), WithinAbs(-45, 1e-9));
  CHECK_THAT(azimuthDeg(file.sensor, 4), WithinAbs(45, 1e-9));
  CHECK_THAT(elevationDeg(file.sensor, 0), WithinAbs(-15, 1e-9));
  CHECK_THAT(elevationDeg(file.sensor, 5), WithinAbs(7.5, 1e-9));
  CHECK(file.sensor.rangeMin == 0.08);
  CHECK(file.sensor.rangeMax == 10.5);
  CHECK(lists(file.assumed, "the first of the lidars front, round"));
  const SensorFile round = readSensorFile(text, "model.sdf", {.mode = "round"});
  CHECK(round.sensor.columns == 8);
  CHECK(round.sensor.channels.size() == 1);
  CHECK_THAT(azimuthDeg(round.sensor, 2), WithinAbs(-90, 1e-9));
  CHECK(round.sensor.rangeMax == 30);
  CHECK(lists(round.ignored, "the last column"));
  CHECK_THAT(problemOf(text, "model.sdf", {.mode = "back"}), ContainsSubstring("no lidar 'back', but front, round"));
  CHECK_THAT(problemOf(replaced(text, "<samples>5", "<samples>x"), "model.sdf"), ContainsSubstring("<samples> is 'x'"));
  CHECK_THAT(problemOf(replaced(text, "<max>10.5</max>", ""), "model.sdf"), ContainsSubstring("<max> of <range>"));
}

TEST_CASE("HELIOS++: a spinning head of several channels, whose y axis points forward") {
  // From vlp16 of scanners_tls.xml, with an origin and a second turn.
  const std::string text = R"(<?xml version="1.0"?><document>
    <scanner id="als" optics="oscillating" pulseFreqs_Hz="100"/>
    <scanner id="vlp16" optics="rotating" beamDivergence_rad="0.0007" pulseFreqs_Hz="18750,300" rangeMin_m="0.01"
      rangeMax_m="100" maxNOR="2" headRotatePerSecMax_deg="7200" wavelength_nm="903"><channels>
      <channel id="0"><beamOrigin x="0" y="0" z="0"><rot axis="x" angle_deg="-15"/></beamOrigin></channel>
      <channel id="1"><beamOrigin x="0.1" y="0.2" z="0.3"><rot axis="x" angle_deg="1"/><rot axis="z" angle_deg="30"/>
      </beamOrigin></channel></channels></scanner></document>)";
  const SensorFile file = readSensorFile(text, "scanners.xml");
  CHECK(file.family == "HELIOS++ scanner");
  const Sensor& sensor = file.sensor;
  CHECK(sensor.name == "vlp16");
  CHECK(sensor.columns == 937);  // 18750 pulses per second, 20 turns
  CHECK_THAT(sensor.rotationPeriod, WithinAbs(937 / 18750.0, 1e-15));
  CHECK_THAT(azimuthDeg(sensor, 1), WithinAbs(7200 / 18750.0, 1e-9));
  CHECK_THAT(elevationDeg(sensor, 0), WithinAbs(-15, 1e-9));
  CHECK_THAT(elevationDeg(sensor, 937), WithinAbs(1, 1e-9));
  CHECK_THAT(azimuthDeg(sensor, 937), WithinAbs(30, 1e-9));
  checkOrigin(originOf(sensor, 937), {0.2, -0.1, 0.3});
  CHECK(sensor.divergenceVertical == 0.0007);
  CHECK(sensor.maxReturns == 2);
  CHECK(lists(file.assumed, "the first of the pulse rates 18750,300"));
  CHECK(lists(file.ignored, "wavelength_nm"));
  CHECK(readSensorFile(text, "scanners.xml", {.scanRate = 10}).sensor.columns == 1875);
  CHECK_THAT(problemOf(text, "scanners.xml", {.mode = "als"}),
             ContainsSubstring("'als' has oscillating optics and one line"));
  CHECK_THAT(problemOf("<document><assets/></document>", "scene.xml"),
             ContainsSubstring("is XML of <document>, not of a lidar"));

  const auto changed = [&](std::string_view from, const std::string& to) {
    std::string other = text;
    return other.replace(other.find(from), from.size(), to);
  };
  // Local turns are about axes that have been turned: z is then that of the tilted beam, so y goes to -x of HELIOS++.
  const Sensor local =
      readSensorFile(changed(R"(z="0.3"><rot axis="x" angle_deg="1"/><rot axis="z" angle_deg="30"/>)",
                             R"(z="0" rotations="local"><rot axis="x" angle_deg="30"/><rot axis="z" angle_deg="90"/>)"),
                     "s.xml")
          .sensor;
  CHECK_THAT(elevationDeg(local, 937), WithinAbs(0, 1e-9));
  CHECK_THAT(azimuthDeg(local, 937), WithinAbs(90, 1e-9));
  const SensorFile own = readSensorFile(
      changed(R"(<channel id="1">)", R"(<channel id="1" rangeMin_m="7" beamDivergence_rad="0.001">)"), "s.xml");
  CHECK(rangeWindowOf(own.sensor, 0).least == 0.01);
  CHECK(rangeWindowOf(own.sensor, 937).least == 7);
  CHECK(rangeWindowOf(own.sensor, 937).most == 100);
  CHECK(lists(own.ignored, "beamDivergence_rad of the channel '1'"));
  CHECK_THAT(
      problemOf(changed(R"(headRotatePerSecMax_deg="7200")", R"(scanFreqMax_Hz="600")"), "s.xml", {.scanRate = 9}),
      ContainsSubstring("'vlp16' has a mirror that turns and a head that does not"));
  CHECK_THAT(problemOf(changed("<channels>", R"(<headRotateAxis x="0" y="1" z="0"/><channels>)"), "s.xml"),
             ContainsSubstring("does not turn about z"));
}

TEST_CASE("Isaac Sim: OmniLidar prims in USD's text are profiles") {
  const std::string text = R"(#usda 1.0
def OmniLidar "lidar" (
    prepend apiSchemas = ["OmniSensorGenericLidarCoreAPI"]
)
{
    float omni:sensor:tickRate = 10.0
    uint omni:sensor:Core:scanRateBaseHz = 10
    uint omni:sensor:Core:patternFiringRateHz = 3333
    token omni:sensor:Core:scanType = "ROTARY"
    token omni:sensor:Core:rotationDirection = "CW"
    float omni:sensor:Core:nearRangeM = 0.3
    float omni:sensor:Core:farRangeM = 120
    uint omni:sensor:Core:maxReturns = 2
    uint omni:sensor:Core:numberOfEmitters = 2
    float2[] omni:sensor:Core:ranges = [(0, 1)]
    float[] omni:sensor:Core:emitterState:s001:azimuthDeg = [6.5,
        -6.5]
    float[] omni:sensor:Core:emitterState:s001:elevationDeg = [-11.75, 3.5]
    uint[] omni:sensor:Core:emitterState:s001:channelId = [1, 2]
    uint[] omni:sensor:Core:emitterState:s001:fireTimeNs = [0, 2665]
}
)";
  const SensorFile file = readSensorFile(text, "lidar.usda");
  CHECK(file.family == "Isaac Sim USD");
  CHECK(file.sensor.isGrid());
  CHECK(file.sensor.columns == 333);
  CHECK_THAT(azimuthDeg(file.sensor, 10), WithinAbs(6.5 - 36000.0 / 3333, 1e-12));
  CHECK_THAT(timeOf(file.sensor, 333 + 10), WithinAbs(10.0 / 3333 + 2.665e-6, 1e-15));
  CHECK(file.sensor.rangeMax == 120);
  CHECK(file.sensor.maxReturns == 2);
  CHECK(lists(file.ignored, "ranges"));
  const std::string fine = replaced(text, "uint omni:sensor:Core:patternFiringRateHz = 3333",
                                    "float omni:sensor:Core:rotPatternFiringResDeg = 0.4");
  CHECK(readSensorFile(fine, "lidar.usda").sensor.columns == 900);
  CHECK_THAT(problemOf(replaced(text, "\"ROTARY\"", "\"SPINNING\""), "lidar.usda"), ContainsSubstring("'SPINNING'"));
  CHECK_THAT(problemOf(replaced(text, "s001:azimuthDeg", "s001:azimuth"), "lidar.usda"),
             ContainsSubstring("is missing"));
  CHECK_THAT(problemOf("#usda 1.0\ndef Xform \"a\" {}\n", "lidar.usda"), ContainsSubstring("without an OmniLidar"));
  CHECK_THAT(problemOf("PXR-USDC" + std::string(80, '\1'), "lidar.usd"), ContainsSubstring("is binary USD"));
}

TEST_CASE("CARLA: lasers from the top, clockwise, defaults where an attribute is missing") {
  const SensorFile file = readSensorFile(kCarla, "objects.json");
  CHECK(file.family == "CARLA attributes");
  const Sensor& sensor = file.sensor;
  CHECK(sensor.name == "top");
  CHECK(sensor.columns == 50);
  CHECK(sensor.rotationPeriod == 0.05);
  REQUIRE(sensor.channels.size() == 4);
  CHECK(elevationDeg(sensor, 0) == 2);
  CHECK(elevationDeg(sensor, 150) == -28);
  CHECK_THAT(elevationDeg(sensor, 50), WithinAbs(-8, 1e-12));
  CHECK_THAT(azimuthDeg(sensor, 0), WithinAbs(60, 1e-12));
  CHECK_THAT(azimuthDeg(sensor, 25), WithinAbs(0, 1e-12));
  CHECK_THAT(azimuthDeg(sensor, 49), WithinAbs(60 - 120 * 0.98, 1e-12));
  CHECK(sensor.rangeMax == 50);
  CHECK(lists(file.ignored, "spawn_point"));
  CHECK(lists(file.ignored, "dropoff_general_rate"));
  CHECK_FALSE(lists(file.ignored, "noise_stddev"));
  CHECK(lists(file.assumed, "top, second"));
  const SensorFile second = readSensorFile(kCarla, "objects.json", {.mode = "second"});
  CHECK(second.sensor.channels.size() == 32);
  CHECK(lists(second.assumed, "'channels' 32, CARLA's default"));
  CHECK_THAT(problemOf(kCarla, "objects.json", {.mode = "third"}), ContainsSubstring("but top, second"));
  CHECK_THAT(problemOf(R"({"type": "sensor.camera.rgb"})", "o.json"), ContainsSubstring("no 'sensor.lidar.ray_cast'"));
  CHECK_THAT(problemOf(R"({"type": "sensor.lidar.ray_cast", "channels": 1.5})", "o.json"),
             ContainsSubstring("'channels' is 1.5"));
  CHECK_THAT(problemOf(R"([{"type": "sensor.lidar.ray_cast", "rotation_frequency": "x"}])", "o.json"),
             ContainsSubstring("'rotation_frequency' is 'x'"));
}

TEST_CASE("the content decides the family, and a name that belies it is refused") {
  CHECK(readSensorFile(kOusterFlat, "metadata").family == "Ouster metadata");
  CHECK(readSensorFile(kVelodyneYaml, "cal.txt").family == "Velodyne calibration");
  CHECK_THAT(problemOf(kOusterFlat, "os.yaml"),
             ContainsSubstring("looks like a file of the family 'Ouster metadata'") && ContainsSubstring(".yaml"));
  CHECK_THAT(problemOf(kVelodyneYaml, "cal.json"), ContainsSubstring("'Velodyne calibration'"));
  CHECK_THAT(problemOf(kVeloViewXml, "db.csv"), ContainsSubstring("'VeloView calibration'"));
  CHECK_THAT(problemOf("Channel,Elevation,Azimuth\n1,2,3\n", "a.dat"), ContainsSubstring("'Hesai angle correction'"));
  CHECK_THAT(problemOf(npy("<f8", false, {1, 3}, {1, 0, 0}), "a.mat3x4f"), ContainsSubstring("'NumPy array'"));
  CHECK_THAT(problemOf("{\"a\": 1}", "a.json"), ContainsSubstring("JSON, but of no known family"));
  const std::string nan = "{\"name\": \"x\", \"azimuth\": 1, \"elevation_deg\": [NaN], \"columns\": 8}";
  for (const char* name : {"a.json", "a"}) CHECK_THAT(problemOf(nan, name), ContainsSubstring("is not JSON"));
  CHECK_THAT(problemOf("{lasers: [1]}", "a.yaml"), !ContainsSubstring("JSON"));  // YAML may begin so
  CHECK_THAT(problemOf("{\"a\": 1", "a.json"), ContainsSubstring("is not JSON") && ContainsSubstring("line 1"));
  CHECK_THAT(problemOf("nonsense", "file"), ContainsSubstring("known are GnoSphere sensor, Ouster metadata"));
  CHECK_THAT(problemOf("", "file"), ContainsSubstring("is empty"));
  CHECK_THAT(problemOf(std::string("\xff\xfe"
                                   "C\0h\0",
                                   6),
                       "utf16.csv"),
             ContainsSubstring("is text in UTF-16"));
  const std::string raw = problemOf("Channel,Elevation,Azimuth\n1,\x01\xc3\x28,3\n", "a.csv");
  CHECK(raw.find_first_of("\x01\xc3") == raw.npos);
  CHECK_THAT(raw, ContainsSubstring("expected is a number"));
  CHECK_THAT(problemOf(kVelodyneYaml, "cal.yaml", {.columns = 5000000}), ContainsSubstring("more than a million"));
  std::string many = "Channel,Elevation,Azimuth\n";
  for (int row = 1; row <= 128; ++row) many += std::to_string(row) + ",1,1\n";
  CHECK_THAT(problemOf(many, "many.csv", {.columns = 1000000}),
             ContainsSubstring("makes 128000000 beams, of 1000000 columns"));
  CHECK_THAT(problemOf(kIsaacRotary, "i.json", {.mode = "1"}), ContainsSubstring("--mode does not apply"));
}

TEST_CASE("a built-in head states what a calibration leaves open") {
  std::string yaml = "lasers:\n";
  for (int id = 0; id < 16; ++id)
    yaml += "- {laser_id: " + std::to_string(id) + ", vert_correction: " + std::to_string(0.035 * (15 - id) - 0.26) +
            ", rot_correction: 0}\n";
  const SensorFile file = readSensorFile(yaml, "puck.yaml", {.head = "Puck"});
  const Sensor head = builtinSensor("Puck");
  CHECK(file.sensor.columns == head.columns);
  CHECK(file.sensor.rotationPeriod == head.rotationPeriod);
  CHECK(file.sensor.channels[3].timeOffset == head.channels[3].timeOffset);
  CHECK(file.sensor.channels[3].azimuthOffsetDeg == head.channels[3].azimuthOffsetDeg);
  CHECK(file.sensor.maxReturns == 2);
  CHECK(file.assumed.empty());
  std::vector<double> angles(2 * 20000);
  const Sensor livox = readSensorFile(npy("<f4", false, {20000, 2}, angles), "mid40.npy", {.head = "Mid-40"}).sensor;
  CHECK(livox.patterns.size() == 2);
  CHECK(livox.rangeMax == 260);
  CHECK_THAT(problemOf(yaml, "puck.yaml", {.head = "HDL-32E"}), ContainsSubstring("has 16 channels"));
  CHECK_THROWS_WITH(readSensorFile(yaml, "puck.yaml", {.head = "Pucks"}), ContainsSubstring("no built-in sensor"));
  // The same number of columns in the same time turns by 360 degrees in a little more.
  const Sensor whole = readSensorFile(yaml, "puck.yaml", {.head = "Puck", .columns = head.columns}).sensor;
  CHECK_THAT(whole.rotationPeriod, WithinAbs(0.1, 1e-12));

  std::string angleTable = "Channel,Elevation,Azimuth\n", times = "Channel,fire time(us)\n";
  for (int id = 1; id <= 128; ++id) {
    angleTable += std::to_string(id) + "," + std::to_string(id - 64) + ",0\n";
    times += std::to_string(id) + "," + std::to_string(id - 1) + "\n";
  }
  const Sensor resting = readSensorFile(angleTable, "qt.csv", {.head = "QT128"}).sensor;
  CHECK(resting.maskedBeams == builtinSensor("QT128").maskedBeams);
  const Sensor fewer = readSensorFile(angleTable, "qt.csv", {.head = "QT128", .columns = 10}).sensor;
  CHECK(fewer.maskedBeams.size() * 4 == fewer.beamCount());
  // A firing time of 0 is stated as well.
  const Folder folder;
  put(folder / "times.csv", times);
  const Sensor timed = readSensorFile(angleTable, "p.csv", {.head = "OT128", .fireTimes = folder / "times.csv"}).sensor;
  CHECK(timed.channels[0].timeOffset == 0);
  CHECK_THAT(timed.channels[5].timeOffset, WithinAbs(5e-6, 1e-18));
  CHECK_THROWS_WITH(readSensorFile(angleTable, "p.csv", {.mode = "2"}), ContainsSubstring("--fire-times"));
}

TEST_CASE("the built-in HDL-64E-S2 starts its beams where the calibration that it comes from starts them") {
  // A vertical offset is at right angles to the beam, as the reader of calibrations has it.
  for (const Channel& channel : builtinSensor("HDL-64E-S2").channels) {
    const double e = channel.elevationDeg / kDegrees;
    CHECK_THAT(channel.origin.x * std::cos(e) + channel.origin.z * std::sin(e), WithinAbs(0, 1e-15));
    CHECK_THAT(std::abs(channel.origin.y), WithinAbs(0.026, 1e-15));
    CHECK(std::hypot(channel.origin.x, channel.origin.z) > 0.1);
  }
}

TEST_CASE("SHA-256 of texts that Python's hashlib has hashed") {
  CHECK(sha256("") == bytesOfHex("e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"));
  CHECK(sha256("abc") == bytesOfHex("ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"));
  CHECK(sha256(std::string(119, 'a')) ==
        bytesOfHex("31eba51c313a5c08226adf18d4a359cfdfd8d2e816b13f4af952f7ea6584dcfb"));
}

TEST_CASE("no change of a byte or two makes a reader crash or return what is not valid") {
  std::mt19937 random(18);
  for (const Sample& sample : samples()) {
    INFO(sample.name);
    CHECK_NOTHROW(readSensorFile(sample.bytes, sample.name));
    for (int round = 0; round < 1000; ++round) {
      std::string bytes = sample.bytes.substr(0, 60000);
      const auto place = [&] { return random() % std::max<size_t>(bytes.size(), 1); };
      for (size_t edits = 1 + random() % 3; edits > 0 && !bytes.empty(); --edits) switch (random() % 5) {
          case 0: bytes[place()] = static_cast<char>(random()); break;
          case 1: bytes.resize(place()); break;
          case 2: bytes.erase(place(), 1 + random() % 8); break;
          case 3: bytes.insert(place(), bytes.substr(place(), 1 + random() % 8)); break;
          default: bytes[place()] = "0123456789-eE.,[]{}\""[random() % 20]; break;
        }
      // A damaged file with a good checksum gets further.
      if (sample.name.ends_with(".dat") && round % 3 > 0 && bytes.size() > 32)
        bytes = bytes.substr(0, bytes.size() - 32) + sha256(std::string_view(bytes).substr(0, bytes.size() - 32));
      try {
        validate(readSensorFile(bytes, round % 2 ? sample.name : "file").sensor);
      } catch (const Error& error) {
        CHECK(error.code() == ErrorCode::format);
      }
    }
  }
}
