// SPDX-License-Identifier: Apache-2.0
// Sensor files of vendors: small ones written here, with beams computed by hand.
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_floating_point.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <utility>

#include "base/sha256.hpp"
#include "folder.hpp"
#include "gnosphere/error.hpp"
#include "gnosphere/sensor.hpp"
#include "sensor/beams.hpp"
#include "sensor/sensor_file_samples.hpp"
#include "sensor/sensor_file_support.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::WithinAbs;

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
  CHECK_THAT(problemOf("lasers: [7]", "none.yml"), ContainsSubstring("line 1: a laser is a map of its corrections"));
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
  CHECK(file.ignored == std::vector<std::string>{"1 lasers that are not enabled", "distCorrection_ of the lasers"});
  CHECK_THAT(file.sensor.rangeMax, WithinAbs(131.07, 1e-9));
  std::string mounted = replaced(kVeloViewXml, "<item>0</item></xyz>", "<item>-0.5</item></xyz>");
  mounted = replaced(mounted, "</position_>",
                     "</position_><orientation_><rpy><item>0</item><item>2</item></rpy></orientation_>"
                     "<minIntensity_/><maxIntensity_/>");
  mounted = replaced(mounted, "<distCorrection_>120<", "<distCorrection_>0<");
  CHECK(readSensorFile(mounted, "db.xml").ignored ==
        std::vector<std::string>{"1 lasers that are not enabled", "position_ of the head", "orientation_ of the head",
                                 "minIntensity_", "maxIntensity_"});

  CHECK_THAT(problemOf(replaced(kVeloViewXml, "-7.5", "x"), "db.xml"),
             ContainsSubstring("'vertCorrection_' is 'x'") && ContainsSubstring("line "));
  CHECK_THAT(problemOf("<boost_serialization/>", "db.xml"), ContainsSubstring("boost_serialization/DB/points_"));
  CHECK_THAT(problemOf(replaced(kVeloViewXml, "<points_><count>3", "<points_><count>4"), "db.xml"),
             ContainsSubstring("'count' is 4, but 3 lasers follow"));
  CHECK_THAT(problemOf(replaced(kVeloViewXml, "<vertCorrection_>5</vertCorrection_>", ""), "db.xml"),
             !ContainsSubstring("vertCorrection_"));  // of the laser that is not enabled
  CHECK_THAT(problemOf(replaced(kVeloViewXml, "<vertCorrection_>2</vertCorrection_>", ""), "db.xml"),
             ContainsSubstring("line 9: 'vertCorrection_' is missing"));
  CHECK_THAT(problemOf(replaced(kVeloViewXml, "<id_>2</id_>", "<id_>0</id_>"), "db.xml"),
             ContainsSubstring("line 11: there are two lasers with this 'id_'"));
  CHECK_THAT(problemOf(replaced(kVeloViewXml, "</points_>", "<item/></points_>"), "db.xml"),
             ContainsSubstring("line 14: 'px' is missing"));
  const SensorFile all = readSensorFile(
      replaced(kVeloViewXml, "<item>0</item><item>1</item></enabled_>", "<item>1</item><item>1</item></enabled_>"),
      "db.xml");
  CHECK(all.sensor.channels.size() == 3);
  CHECK_FALSE(lists(all.ignored, "enabled"));
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
    CHECK(sensor.rangeAt10Percent == 90);
    CHECK(sensor.divergenceHorizontal == 5.34e-3);
    CHECK_FALSE(lists(file.ignored, "rotation"));
    CHECK(lists(file.assumed,
                "a largest range of 170 m, 90 m at 10 % and a divergence of 5.34 mrad, as the catalogue's "
                "OS1-32 has them"));
  }
  CHECK(readSensorFile(kOusterNested, "os.json").sensor.maxReturns == 2);
  CHECK(lists(readSensorFile(kOusterNested, "os.json").assumed, "returns.mode=strongest-second-strongest"));
  for (const auto& [from, to] :
       {std::pair("[1, 0, 0, 12.5", "[1, 1e-3, 0, 12.5"), {"[1, 0, 0, 12.5", "[0.999, 0, 0, 12.5"}})
    CHECK(lists(readSensorFile(replaced(kOusterNested, from, to), "os.json").ignored,
                "the rotation in beam_to_lidar_transform"));
  CHECK_FALSE(lists(readSensorFile(kOusterFlat, "os.json").assumed, "echoes"));
  std::string mounted(kOusterNested);
  mounted.insert(mounted.rfind('}'),
                 R"(, "ouster-sdk": {"extrinsic": [0,-1,0,1, 1,0,0,2, 0,0,1,3, 0,0,0,1]}, "return_order": "x")");
  const SensorFile file = readSensorFile(mounted, "os.json");
  CHECK(lists(file.ignored, "the extrinsic"));
  mounted.replace(mounted.find("[0,-1"), mounted.find("3, 0,0,0,1]") + 11 - mounted.find("[0,-1"), "null");
  CHECK(lists(readSensorFile(mounted, "os.json").ignored, "the extrinsic"));
  CHECK(lists(file.ignored, "return_order"));
}

TEST_CASE("Ouster metadata: a head whose connector is at its side, and its least range in centimetres") {
  std::string text = replaced(kOusterNested, "[-1, 0, 0, 0, 0, -1, 0, 0,", "[0, -1, 0, 0, 1, 0, 0, 0,");
  text = replaced(text, "\"lidar_mode\"", "\"min_range_threshold_cm\": 30, \"lidar_mode\"");
  const Sensor sensor = readSensorFile(text, "os.json").sensor;
  // The matrix turns the lidar's x axis, along which column 0 looks, to the sensor's y axis.
  CHECK_THAT(azimuthDeg(sensor, 0), WithinAbs(90 - 3, 1e-12));
  checkOrigin(originOf(sensor, 0), {0, 0.0125, 0.03618});
  CHECK(sensor.rangeMin == 0.3);
}

TEST_CASE("Ouster metadata: the product has the figures of its head in the catalogue, or of the head that is named") {
  const auto ofProduct = [](const char* product, const SensorFileOptions& options = {}) {
    return readSensorFile(replaced(kOusterNested, "OS-1-2", product), "os.json", options);
  };
  const SensorFile far = ofProduct("OS-2-128-U1");
  CHECK(far.sensor.rangeAt10Percent == builtinSensor("OS2-128").rangeAt10Percent);
  CHECK(far.sensor.divergenceVertical == builtinSensor("OS2-128").divergenceVertical);
  CHECK(far.sensor.rangeMax == builtinSensor("OS2-128").rangeMax);
  CHECK(lists(far.assumed, "as the catalogue's OS2-128 has them"));
  CHECK_FALSE(lists(far.assumed, "data sheet"));
  const SensorFile dome = ofProduct("OS-DOME-128");
  CHECK(dome.sensor.rangeMax == 45);
  CHECK(dome.sensor.rangeAt10Percent == 0);
  CHECK(lists(dome.assumed, "a target of 10 % is seen up to the largest range"));
  CHECK(ofProduct("OS-").sensor.rangeMax == 170);
  const SensorFile named = ofProduct("OS-1-64", {.head = "OS0-64"});
  CHECK(named.sensor.rangeAt10Percent == 35);
  CHECK(named.sensor.rangeMax == 75);
  CHECK(named.sensor.divergenceVertical == builtinSensor("OS0-64").divergenceVertical);
  CHECK_FALSE(lists(named.assumed, "OS1-64"));
  CHECK(named.sensor.columns == 512);  // which the metadata state
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
  // The window has the columns 100 and 101 of 2048, and only column 25 of 512 looks into the window.
  std::string wide = replaced(kOusterNested, "512x20", "2048x10");
  wide =
      replaced(replaced(wide, "[0, 511]", "[100, 101]"), "\"columns_per_frame\": 512", "\"columns_per_frame\": 2048");
  const std::vector<uint32_t> narrow = readSensorFile(wide, "os.json", {.mode = "512x10"}).sensor.maskedBeams;
  CHECK(narrow.size() == 2 * 511);
  CHECK_FALSE(std::binary_search(narrow.begin(), narrow.end(), 25u));
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
  // The radii are those of default_lidar_origin_to_beam_origin() in ouster-sdk.
  for (const auto& [line, metres] :
       {std::pair("OS-0", 0.02767), std::pair("OS-1", 0.015806), std::pair("OS-2", 0.013762)}) {
    const std::string product = std::string(R"("prod_line": ")") + line + R"(-16", )";
    checkOrigin(originOf(readSensorFile(text(product, 16, false), "old.json").sensor, 0), {-metres, 0, 0.03618});
  }

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
  CHECK_THAT(edited("[4, -4]", "[]"), ContainsSubstring("'beam_altitude_angles' is empty"));
  CHECK_THAT(edited("[4, -4]", "[4, {}]"), ContainsSubstring("'beam_altitude_angles' has an object at place 1"));
  CHECK_THAT(edited("\"pixels_per_column\": 2", "\"pixels_per_column\": \"2\""),
             ContainsSubstring("'pixels_per_column' is \"2\", expected is a number"));
  std::string many = "[0.5";
  for (int i = 0; i < 65535; ++i) many += ", 0.5";
  CHECK_THAT(edited("[4, -4]", many + "]"), ContainsSubstring("has more than 65535 entries"));
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
  CHECK(file.assumed.size() == 2);  // the largest range, and that at 10 %
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
  const std::string hash = "429277b5377e9c57f0e3dd3b439e832c38f1b7602699cee14303f0821258959e,,,\n";  // of Python
  CHECK(readSensorFile(text + hash, "ft.csv").sensor.beamCount() == 4);
  CHECK(readSensorFile(text + "\n\n" + hash.substr(32), "ft.csv").sensor.beamCount() == 4);  // of another kind
  CHECK_THAT(problemOf(replaced(text, "26.7", "26.8") + hash, "ft.csv"),
             ContainsSubstring("is damaged: the lines above line 6 do not have the SHA-256"));
  CHECK_THAT(problemOf(replaced(text, "1,2,27", "1,1,27"), "ft.csv"), ContainsSubstring("was there before"));
  CHECK_THAT(problemOf(replaced(text, "1,2,27", "3,2,27"), "ft.csv"), ContainsSubstring("lists 4 pixels, but has 3"));
  CHECK_THAT(problemOf(replaced(text, "1,2,27", "1,5000,27"), "ft.csv"), ContainsSubstring("expected is 1 to 4096"));
  CHECK(sensor.scanPeriod == 0);
  CHECK(readSensorFile(text, "ft.csv", {.scanRate = 8}).sensor.scanPeriod == 0.125);
  const auto refuses = [&](const SensorFileOptions& options) {
    return problemOf(text, "ft.csv", options).find("does not apply to a flash lidar") != std::string::npos;
  };
  CHECK(refuses({.columns = 9}));
  CHECK(refuses({.mode = "x"}));
  CHECK(refuses({.fireTimes = "times.csv"}));
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
  CHECK(readSensorFile("+2.31,-0.03\n", "angle.csv").sensor.channels.at(0).elevationDeg == 2.31);
  std::string many;
  for (int i = 0; i < 1025; ++i) many += "0.5,1\n";
  CHECK_THAT(problemOf(many, "angle.csv"), ContainsSubstring("has more than 1024 lasers"));
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
    CHECK_THAT(read("Channel,fire time/ns\n2,-50\n1,-3\n").sensor.channels[1].timeOffset, WithinAbs(-50e-9, 1e-18));
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
    CHECK_THROWS_WITH(read("Channel,fire time(us)\n1,2\n2,3\n", "2"), ContainsSubstring("has no operational states"));
  }
  SECTION("loops of pairs") {
    const Sensor sensor = read("EEFF,1,1\nChannel num,2,Loop num,2\nID,us,ID,us\n1,4,2,8\n2,6,1,10\n").sensor;
    CHECK_THAT(timeOf(sensor, 0), WithinAbs(4e-6, 1e-15));
    CHECK_THAT(timeOf(sensor, 360 + 1), WithinAbs(0.1 / 360 + 8e-6, 1e-15));
    for (const char* loops : {"0", "17", "nan"})
      CHECK_THROWS_WITH(read("EEFF,1,1\nChannel num,2,Loop num," + std::string(loops) + "\nID,us,ID,us\n1,4,2,8\n"),
                        ContainsSubstring("line 2") && ContainsSubstring("loop number"));
    CHECK_THROWS_WITH(read("EEFF,1,1\nChannel num,2\n"), ContainsSubstring("ends before the names of its columns"));
    CHECK_THROWS_WITH(read("EEFF,1,1\nChannel num,2\nID,us\n1,4\n"), ContainsSubstring("expected is 'Channel num, N"));
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
    CHECK_THROWS_WITH(read(text, "1"), ContainsSubstring("no operational state '1', but 0, 2 and 3"));
  }
  SECTION("mistakes") {
    CHECK_THROWS_WITH(read("Channel,fire time(us)\n1,2\n"), ContainsSubstring("channel 2 of the angle correction"));
    CHECK_THROWS_WITH(read("Channel,fire time(us)\n3,2\n"), ContainsSubstring("line 2: the channel is 3"));
    CHECK_THROWS_WITH(read("Channel,fire time(us)\n1,x\n"), ContainsSubstring("line 2, time is 'x'"));
    CHECK_THROWS_WITH(read("Channel,fire time(us)\n1\n"), ContainsSubstring("line 2 has 1 cells, expected are more"));
    CHECK(read("Channel,fire time(us)\n1,2\n\n2,3\n0123456789abcdef,\n").sensor.channels.size() == 2);
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
  // In the next column, at 35.05 degrees of the head, the corrections are rounded from 6.1 to 6.
  CHECK_THAT(azimuthDeg(sensor, 1), WithinAbs(90 - (30.1 + 2.4 + 0.06), 1e-9));
  CHECK_THAT(azimuthDeg(sensor, 600), WithinAbs(90 - (90 + 2.4), 1e-9));
  CHECK_THAT(azimuthDeg(sensor, 1200), WithinAbs(90 - (30 - 0.65), 1e-9));
  CHECK_THAT(azimuthDeg(sensor, 0, 1), WithinAbs(90 - (30 + 2.4), 1e-9));
  CHECK_THAT(timeOf(sensor, 2), WithinAbs(0.1 / 1200, 1e-15));  // 0.1 degrees of the head's 1200 per second
  CHECK(sensor.scanPeriod == 0.1);                              // a third of a turn
  CHECK(lists(file.assumed, "10 scans per second, three to a turn"));
  CHECK(lists(file.assumed, "1200 columns 0.1 degrees apart"));
  const SensorFile faster = readSensorFile(hesaiMirrors(), "at.dat", {.scanRate = 20});
  CHECK(faster.sensor.scanPeriod == 0.05);
  CHECK_FALSE(lists(faster.assumed, "scans per second"));
  CHECK_THAT(problemOf(hesaiMirrors(), "at.dat", {.fireTimes = "times.csv"}),
             ContainsSubstring("--fire-times does not apply to this angle correction"));
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
  put(folder / "times.csv", "Channel,Even_fire time(ns),Odd_fire time(ns)\n1,500,-4960\n2,0,7000\n");
  CHECK_THAT(timeOf(readSensorFile(bytes, "atx.dat", {.fireTimes = folder / "times.csv"}).sensor, 0, 0),
             WithinAbs(5.46e-6, 1e-18));
  put(folder / "times.csv", "Channel,Even_fire time(ns),Odd_fire time(ns)\n1,-,500\n2,0,7000\n");
  CHECK_THAT(problemOf(bytes, "atx.dat", {.fireTimes = folder / "times.csv"}),
             ContainsSubstring("channel 1 does not fire"));
}

TEST_CASE("Hesai binary: an ATX of version 4.1 fires alike in all frames, an ET25 of version 3.1 has no table") {
  std::string atx("\xee\xff\x04\x01\x00\x00\x02\x00\x01", 9);  // two channels, units of 1/256 degree
  for (const double degrees : {4.0, 1.0, 2.5, -7.5}) put<int16_t>(atx, static_cast<int16_t>(256 * degrees));
  const Sensor alike = readSensorFile(atx + sha256(atx), "atx.dat").sensor;
  REQUIRE(alike.patterns.size() == 1);
  CHECK_THAT(azimuthDeg(alike, 0), WithinAbs(90 - (30 + 4.0), 1e-9));
  CHECK_THAT(elevationDeg(alike, 1200), WithinAbs(-7.5, 1e-9));

  // With mirrors and lasers at 0 the azimuth is that of the column, and the elevation that of the laser.
  const auto et = [](char version, const std::string& more) {
    std::string bytes("\xee\xff\x03\x01\x00\x00\x01\x01\x00\x01", 10);
    bytes[3] = version;
    for (const int degrees : {0, 0, 0, 0, 3}) put<int16_t>(bytes, static_cast<int16_t>(256 * degrees));
    bytes += more;
    return bytes + sha256(bytes);
  };
  const Sensor plain = readSensorFile(et(1, ""), "et.dat").sensor;
  CHECK_THAT(azimuthDeg(plain, 900), WithinAbs(-30, 1e-9));
  CHECK_THAT(elevationDeg(plain, 900), WithinAbs(3, 1e-9));
  CHECK_THAT(problemOf(et(2, std::string("\x00\x19", 2)), "et.dat"),
             ContainsSubstring("states adjustments that are 0 degrees apart"));
}

TEST_CASE("Hesai binary: an ATX of version 4.3 corrects elevations by a table over azimuths of 20 to 158 degrees") {
  std::string bytes("\xee\xff\x04\x03\x00\x00\x03\x00\x01", 9);  // three channels, units of 1/256 degree
  const auto add = [&](double degrees) { put<int16_t>(bytes, static_cast<int16_t>(256 * degrees)); };
  for (const double azimuth : {0.0, -20.0, 118.0, 0.0, 0.0, 0.0}) add(azimuth);  // even frames, odd ones
  for (const double elevation : {1.0, 2.0, 3.0}) add(elevation);
  for (int node = 0; node < 70; ++node) add(0.25 * (node % 4));
  const Sensor sensor = readSensorFile(bytes + sha256(bytes), "atx.dat").sensor;
  const auto up = [&](size_t channel, size_t column) { return elevationDeg(sensor, channel * 1200 + column); };
  CHECK_THAT(up(0, 0), WithinAbs(1 + 0.25, 1e-9));    // at 30 degrees, node 5
  CHECK_THAT(up(0, 5), WithinAbs(1 + 0.3125, 1e-9));  // a quarter of the way to node 6, which has 0.5
  CHECK_THAT(up(0, 30), WithinAbs(1 + 0.625, 1e-9));  // half the way from node 6 to node 7
  CHECK_THAT(up(1, 99), WithinAbs(2, 1e-9));          // before the table, at 19.9 degrees
  CHECK_THAT(up(2, 90), WithinAbs(3 + 0.125, 1e-9));  // at 157 degrees, half the way to node 69, the last
  CHECK_THAT(up(2, 100), WithinAbs(3 + 0.25, 1e-9));  // at the last node
  CHECK_THAT(up(2, 101), WithinAbs(3, 1e-9));
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
  const SensorFile rated = readSensorFile(bytes, "ft.dat", {.scanRate = 8});
  CHECK(rated.sensor.scanPeriod == 0.125);
  CHECK_FALSE(lists(rated.assumed, "1200 columns"));
  CHECK_THAT(problemOf(bytes.substr(0, 20), "ft.dat"), ContainsSubstring("ends after 20 bytes"));
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
