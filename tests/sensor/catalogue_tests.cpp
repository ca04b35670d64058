// SPDX-License-Identifier: Apache-2.0
// The heads of the catalogue, against the figures of their data sheets and of their vendors' files.
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <numbers>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include "base/file.hpp"
#include "base/vector.hpp"
#include "gnosphere/error.hpp"
#include "gnosphere/sensor.hpp"
#include "sensor/beams.hpp"
#include "sensor/catalogue_heads.hpp"

using namespace gnosphere;
using Catch::Matchers::ContainsSubstring;

namespace {

bool isRefused(const std::string& name) {
  try {
    builtinSensor(name);
  } catch (const Error& error) {
    return error.code() == ErrorCode::invalidArgument;
  }
  return false;
}

/// The azimuth offset of a laser without the angle by which the head turns on until it fires.
double offsetDeg(const Sensor& sensor, size_t channel) {
  const Channel& c = sensor.channels.at(channel);
  return c.azimuthOffsetDeg - sensor.azimuthSpanDeg / sensor.rotationPeriod * c.timeOffset;
}

/// How many numbers a list of HeadFigures has; every word must be a number or a range of numbers.
size_t countOf(const char* list) {
  static const std::regex number("-?[0-9]+([.][0-9]+)?"), range("(-?[0-9.]+)[.][.](-?[0-9.]+)/([0-9]+)");
  std::istringstream words(list);
  size_t count = 0;
  for (std::string word; words >> word;) {
    INFO("the word '" << word << "'");
    std::smatch parts;
    if (std::regex_match(word, parts, range)) {
      CHECK(std::regex_match(parts[1].str(), number));
      CHECK(std::regex_match(parts[2].str(), number));
      CHECK(std::stoul(parts[3]) > 1);
      count += std::stoul(parts[3]);
    } else {
      CHECK(std::regex_match(word, number));
      ++count;
    }
  }
  return count;
}

bool isMasked(const Sensor& sensor, size_t channel, size_t column) {
  return std::binary_search(sensor.maskedBeams.begin(), sensor.maskedBeams.end(),
                            static_cast<uint32_t>(channel * sensor.columns + column));
}

}  // namespace

TEST_CASE("every head of the catalogue is valid in every mode and names its source") {
  CHECK(sensorCatalogue().size() >= 25);
  std::set<std::string> names;
  for (const Sensor& sensor : builtinSensors()) names.insert(sensor.name);
  for (const CatalogueHead& head : sensorCatalogue()) {
    INFO(head.name);
    CHECK(names.insert(head.name).second);
    CHECK(head.source.size() > 20);
    CHECK(!head.product.empty());
    REQUIRE(!head.modes.empty());
    const Sensor first = builtinSensor(head.name);
    for (const std::string& mode : head.modes) {
      const Sensor sensor = builtinSensor(head.name + ":" + mode);
      CHECK_NOTHROW(validate(sensor));
      CHECK(sensor.rangeMax > 0);
      CHECK(sensor.rangeAt10Percent == head.rangeAt10Percent);
      CHECK(head.rangeAt10Percent <= sensor.rangeMax);
      if (sensor.isGrid()) CHECK(sensorFromJson(toJson(sensor), "").rangeAt10Percent == head.rangeAt10Percent);
      CHECK(sensor.channels.size() == first.channels.size());
      if (mode == head.modes[0]) CHECK(sensor.columns == first.columns);
    }
  }
  CHECK(isRefused("Puck:7Hz"));
  CHECK_THROWS_WITH(builtinSensor("Puck:7Hz"), "the sensor Puck has no mode '7Hz', but 10Hz, 5Hz, 15Hz, 20Hz");
  CHECK_THROWS_WITH(builtinSensor("VLP-16:10Hz"), ContainsSubstring("ideal head of the paper and has no modes"));
}

TEST_CASE("every list of a head has only numbers, which repeat a whole number of times over the elevations") {
  for (const HeadFigures& head : kHeads) {
    INFO(head.name);
    const size_t elevations = countOf(head.elevations), divergences = countOf(head.divergence);
    CHECK(elevations > 0);
    CHECK((divergences == 0 || divergences == 2));
    for (const char* list : {head.azimuthOffsets, head.times, head.left, head.up, head.rests}) {
      const size_t count = countOf(list);
      INFO("the list " << list);
      CHECK((count == 0 || (count <= elevations && elevations % count == 0)));
    }
  }
}

TEST_CASE("docs/sensors.md lists every head with its modes and source") {
  const std::string page = readWholeFile(std::filesystem::path(GNOSPHERE_DOCS) / "sensors.md");
  for (const CatalogueHead& head : sensorCatalogue()) {
    const Sensor sensor = builtinSensor(head.name);
    std::string modes;
    for (const std::string& mode : head.modes) modes.append(modes.empty() ? "" : ", ").append(mode);
    const std::string cloud = std::to_string(sensor.width()) + " x " + std::to_string(sensor.height());
    CHECK_THAT(page,
               ContainsSubstring("| `" + head.name + "` | " + head.product + " | " + cloud + " | " + modes + " | "));
    CHECK_THAT(page, ContainsSubstring(head.source + ". " + head.remarks));
  }
}

TEST_CASE("pages that tell how many heads there are have the number of the catalogue") {
  const std::string heads = std::to_string(sensorCatalogue().size()) + " real heads";
  for (const char* page : {"../README.md", "instead-of.md", "tutorials/first-scan.md"}) {
    INFO(page);
    CHECK_THAT(readWholeFile(std::filesystem::path(GNOSPHERE_DOCS) / page), ContainsSubstring(heads));
  }
}

TEST_CASE("heads of the catalogue have the figures of their sheets") {
  const Sensor puck = builtinSensor("puck");
  // Firing 1 of a sequence is at +1 degree, 2.304 us after firing 0, while the head turns on by 3600 degrees a second.
  CHECK(puck.channels[8].elevationDeg == 1);
  CHECK(std::abs(puck.channels[8].timeOffset - 2.304e-6) < 1e-15);
  CHECK(std::abs(puck.channels[8].azimuthOffsetDeg + 3600 * 2.304e-6) < 1e-9);
  CHECK(std::abs(puck.channels[8].origin.z + 0.0007) < 1e-15);
  CHECK(puck.columns == 1808);
  CHECK(std::abs(puck.rotationPeriod - 1808 * 55.296e-6) < 1e-15);
  CHECK(std::abs(puck.azimuthSpanDeg + 360 * 1808 * 55.296e-5) < 1e-9);

  const Sensor ouster = builtinSensor("OS1-128:2048x10");
  CHECK(ouster.columns == 2048);
  CHECK(ouster.azimuthStartDeg == 180);
  CHECK(ouster.channels[0].azimuthOffsetDeg == -4.2);
  const Vec3& origin = ouster.channels[0].origin;
  CHECK(std::abs(std::hypot(origin.x, origin.y) - 0.015806) < 1e-12);
  CHECK(std::abs(std::atan2(origin.y, origin.x) * 180 / std::numbers::pi - 4.2) < 1e-9);  // towards the encoder's angle

  // The lasers of the Pucks cross 41.9 mm before the axis.
  for (const char* name : {"Puck", "Puck-Hi-Res"})
    for (const Channel& channel : builtinSensor(name).channels)
      CHECK(std::abs(channel.origin.z + 0.0419 * std::tan(channel.elevationDeg * std::numbers::pi / 180)) < 5e-4);
  CHECK(builtinSensor("Alpha-Prime").divergenceVertical == 1.5e-3);
  const Sensor helios = builtinSensor("RS-Helios-32");
  CHECK(helios.columns == 1800);
  CHECK(helios.channels[31].elevationDeg == 15);
  CHECK(helios.channels[31].timeOffset == 0);
  CHECK(helios.channels[22].elevationDeg == 0);
  CHECK(helios.channels[0].elevationDeg == -55.02);
  CHECK(std::abs(helios.channels[0].timeOffset - 45.15e-6) < 1e-15);

  CHECK(builtinSensor("Pandar64").columns == 1800);
  CHECK(builtinSensor("Pandar64:20Hz").columns == 900);
  CHECK(builtinSensor("AT128").azimuthSpanDeg == -120);
  CHECK(std::abs(builtinSensor("AT128").rotationPeriod - 0.05) < 1e-9);
  CHECK(std::abs(builtinSensor("TiM781").rotationPeriod - 811 / 16200.0) < 1e-12);
  CHECK(builtinSensor("TiM781").scanPeriod == 1 / 15.0);
  CHECK(builtinSensor("AT128").scanPeriod == 0.1);
  CHECK(builtinSensor("Puck:20Hz").scanPeriod == 0.05);
  CHECK(builtinSensor("OS1-128").scanPeriod == 0);  // the columns fill the turn
  for (const char* list : {"Mid-40", "Avia", "RS-M1"}) CHECK(builtinSensor(list).scanPeriod == 0.1);
  CHECK(std::abs(builtinSensor("TiM781").rangeAt10Percent - 5 * std::sqrt(0.1 / 0.05)) < 0.005);
  // A range image of Waymo's has the azimuth pi (1 - (2 c + 1) / columns) in column c.
  const Sensor waymo = builtinSensor("Waymo-Top");
  for (const size_t c : {0, 1324, 1325, 2649})
    CHECK(std::abs(std::remainder(azimuthOf(waymo, c) - std::numbers::pi * (1 - (2 * double(c) + 1) / 2650),
                                  2 * std::numbers::pi)) < 1e-9);
  // The lidar of nuScenes is an HDL-32E, whose lasers its list has from below.
  const Sensor nuscenes = builtinSensor("nuScenes"), hdl = builtinSensor("HDL-32E:20Hz");
  REQUIRE(nuscenes.beamCount() == hdl.beamCount());
  for (size_t beam = 0; beam < hdl.beamCount(); beam += 101) {
    CHECK(std::abs(timeOf(nuscenes, beam) - timeOf(hdl, beam)) < 1e-12);
    CHECK(std::abs(std::remainder(azimuthOf(nuscenes, beam) - azimuthOf(hdl, beam), 2 * std::numbers::pi)) < 1e-9);
  }
  CHECK(builtinSensor("HDL-64E-S2").channels[0].elevationDeg < -24.8);
  const Sensor ruby = builtinSensor("RS-Ruby-Plus");
  CHECK(ruby.channels[0].elevationDeg == -25);
  CHECK(ruby.channels[127].elevationDeg == 15);
  CHECK(std::abs(ruby.channels[64].origin.x - 0.02892) < 1e-15);
  const Sensor narrow = builtinSensor("RS-Helios-1615");
  CHECK(narrow.channels[0].elevationDeg == -16);
  CHECK(narrow.channels[31].elevationDeg == 15);
}

TEST_CASE("scanners of one plane have the beams, the sector and the rate of their sheets") {
  const struct {
    const char* name;
    uint32_t beams;
    double first, last, step, rate;  // degrees counter-clockwise, with 0 ahead; scans a second
    double least, most, between;     // metres; microseconds from beam to beam
    uint32_t returns;
  } sheets[] = {{"UST-10LX", 1081, -135, 135, 0.25, 40, 0.06, 10, 25e3 / 1440, 1},
                {"UST-20LX", 1081, -135, 135, 0.25, 40, 0.06, 20, 25e3 / 1440, 1},
                {"UTM-30LX", 1081, -135, 135, 0.25, 40, 0.1, 30, 25e3 / 1440, 1},
                {"UTM-30LX-EW", 1081, -135, 135, 0.25, 40, 0.1, 30, 25e3 / 1440, 3},
                {"LMS111", 541, -135, 135, 0.5, 50, 0.5, 20, 20e3 / 720, 2},
                {"LMS111:1081x25", 1081, -135, 135, 0.25, 25, 0.5, 20, 40e3 / 1440, 2},
                {"microScan3", 537, -137.5, 137.5, 0.51306, 1 / 0.03, 0.05, 64, 43, 1},
                {"nanoScan3", 1651, -137.5, 137.5, 1 / 6.0, 1 / 0.03, 0.1, 40, 14, 1},
                {"TiM781", 811, -135, 135, 1 / 3.0, 15, 0.05, 25, 1e6 / 16200, 1},
                {"RPLIDAR-A1", 1454, 0, -359.6175, -360 * 5.5 / 8000, 5.5, 0.15, 12, 125, 1},
                {"RPLIDAR-A2", 800, 0, -359.55, -0.45, 10, 0.15, 12, 125, 1},
                {"RPLIDAR-S2E", 3200, 0, -359.8875, -0.1125, 10, 0.05, 30, 31.25, 1}};
  for (const auto& sheet : sheets) {
    INFO(sheet.name);
    const Sensor sensor = builtinSensor(sheet.name);
    CHECK(sensor.beamCount() == sheet.beams);
    const auto azimuthDeg = [&](size_t beam) { return azimuthOf(sensor, beam) * 180 / std::numbers::pi; };
    CHECK(std::abs(std::remainder(azimuthDeg(0) - sheet.first, 360)) < 1e-9);
    CHECK(std::abs(std::remainder(azimuthDeg(sheet.beams - 1) - sheet.last, 360)) < 1e-6);
    CHECK(std::abs(std::remainder(azimuthDeg(1) - azimuthDeg(0) - sheet.step, 360)) < 1e-6);
    CHECK(std::abs(1 / scanPeriodOf(sensor) - sheet.rate) < 1e-6);
    CHECK(std::abs(1e6 * timeOf(sensor, 1) - sheet.between) < (sheet.beams == 537 || sheet.beams == 1651 ? 0.5 : 1e-9));
    // A mirror that turns evenly is back at the start of the sector when the next scan begins.
    CHECK(std::abs(sensor.azimuthSpanDeg / sensor.rotationPeriod * scanPeriodOf(sensor)) > 359.99);
    CHECK(std::abs(sensor.azimuthSpanDeg / sensor.rotationPeriod * scanPeriodOf(sensor)) < 360.01);
    CHECK(sensor.rangeMin == sheet.least);
    CHECK(sensor.rangeMax == sheet.most);
    CHECK(sensor.maxReturns == sheet.returns);
  }
  CHECK(builtinSensor("UST-10LX").rangeAt10Percent == 4);
  CHECK(builtinSensor("LMS111").rangeAt10Percent == 18);
  CHECK(std::abs(builtinSensor("microScan3").rangeAt10Percent - 9 * std::sqrt(0.1 / 0.02)) < 0.05);
  CHECK(builtinSensor("LMS111").divergenceHorizontal == 0.015);
}

TEST_CASE("the Alpha Prime has the angles of the vendor's calibration") {
  // Lasers 0, 2, 7, 36 and 59 of ros-drivers/velodyne, params/VLS128.yaml: vert_correction and rot_correction.
  const struct {
    double vertical, rotation;
  } lasers[] = {{-0.2049365607691742, -0.1108982206717197},
                {0.059341194567807204, -0.04768239516448509},
                {0.022863813201125717, 0.1108982206717197},
                {-0.4363323129985824, 0.015899949485668342},
                {0.2617993877991494, -0.015899949485668342}};
  const Sensor sensor = builtinSensor("Alpha-Prime");
  const double degree = std::numbers::pi / 180, turned = sensor.azimuthSpanDeg / sensor.rotationPeriod;
  for (const auto& laser : lasers) {
    INFO(laser.vertical / degree);
    const auto channel = std::find_if(sensor.channels.begin(), sensor.channels.end(), [&](const Channel& c) {
      return std::abs(c.elevationDeg - laser.vertical / degree) < 1e-3;
    });
    REQUIRE(channel != sensor.channels.end());
    CHECK(std::abs(channel->azimuthOffsetDeg - turned * channel->timeOffset - laser.rotation / degree) < 1e-3);
  }
}

TEST_CASE("the QT128 has the angles and times of the vendor's files, and 96 lasers fire in a column") {
  const Sensor sensor = builtinSensor("QT128");
  // Lasers 1, 33, 97 and 128 of PandarQT128_Correction.csv and PandarQT128_Firetimes.csv in HesaiLidar_Swift_ROS.
  const struct {
    size_t laser;
    double elevation, azimuth, time;
  } lasers[] = {{1, -52.62676282, 10.10830596, 92.574},
                {33, -18.33139172, -6.21699538, 17.118},
                {97, 19.19081372, -6.25017485, 8.734},
                {128, 52.62676282, -10.10830596, 41.222}};
  for (const auto& [laser, elevation, azimuth, time] : lasers) {
    CHECK(std::abs(sensor.channels.at(laser - 1).elevationDeg - elevation) < 1e-4);
    CHECK(std::abs(offsetDeg(sensor, laser - 1) + azimuth) < 1e-4);
    CHECK(std::abs(sensor.channels.at(laser - 1).timeOffset - 1e-6 * time) < 1e-12);
  }
  CHECK(sensor.columns == 900);
  CHECK(sensor.beamCount() - sensor.maskedBeams.size() == 900 * 96);  // 864,000 points per second
  for (size_t column : {0, 1, 2}) {
    CHECK(isMasked(sensor, 0, column) == (column % 2 == 0));
    CHECK(isMasked(sensor, 63, column) == (column % 2 == 1));
    CHECK_FALSE(isMasked(sensor, 64, column));
  }
}

TEST_CASE("a Pandar128E3X fires as the vendor's file says") {
  // Lasers 3, 8 and 26 of laser-ts.csv and correction.csv in HesaiLidar_Swift_ROS; far surfaces, operation mode 2.
  const Sensor standard = builtinSensor("Pandar128E3X");
  CHECK(standard.columns == 1800);
  CHECK(standard.maskedBeams.empty());
  CHECK(std::abs(standard.channels[2].timeOffset - 0.776e-6) < 1e-12);
  CHECK(std::abs(standard.channels[7].timeOffset - 33.456e-6) < 1e-12);
  CHECK(std::abs(standard.channels[25].timeOffset - 39.255e-6) < 1e-12);
  CHECK(std::abs(standard.channels[2].elevationDeg - 13.081786) < 1e-4);
  CHECK(std::abs(offsetDeg(standard, 2) + 1.091414) < 1e-4);
  // Operation mode 0 has four angle states: laser 3 rests in 1 and 3, laser 8 in 0 and 2.
  const Sensor fine = builtinSensor("Pandar128E3X-HR");
  CHECK(fine.columns == 3600);
  CHECK(fine.beamCount() - fine.maskedBeams.size() == 345600);  // 3,456,000 points per second
  CHECK(isMasked(fine, 2, 1));
  CHECK_FALSE(isMasked(fine, 2, 2));
  CHECK(isMasked(fine, 7, 2));
  CHECK_FALSE(isMasked(fine, 7, 3));
  CHECK(std::abs(fine.channels[7].timeOffset - 5.678e-6) < 1e-12);
  CHECK(std::abs(fine.channels[25].timeOffset - 11.227e-6) < 1e-12);
  CHECK(isRefused("Pandar128"));
}

TEST_CASE("heads of RoboSense fire from the lens centre at the times of rs_driver") {
  const Sensor rs16 = builtinSensor("RS-LiDAR-16");  // decoder_RS16.hpp: laser 8 is the first of the upper ones, at +15
  CHECK(rs16.columns == 1801);
  CHECK(rs16.channels[15].elevationDeg == 15);
  CHECK(std::abs(rs16.channels[15].timeOffset - 22.4e-6) < 1e-12);
  CHECK(std::abs(rs16.channels[8].timeOffset - 42e-6) < 1e-12);
  CHECK(std::abs(rs16.channels[0].origin.x - 0.03825) < 1e-12);
  const Sensor bpearl = builtinSensor("RS-Bpearl");  // decoder_RSBP.hpp: laser 16 fires after 1.28 us
  CHECK(bpearl.channels[0].elevationDeg == 2.3125);
  CHECK(bpearl.channels[0].timeOffset == 0);
  CHECK(std::abs(bpearl.channels[8].elevationDeg - 24.8125) < 1e-12);
  CHECK(std::abs(bpearl.channels[8].timeOffset - 1.28e-6) < 1e-12);
  CHECK(std::abs(bpearl.channels[31].timeOffset - 44.88e-6) < 1e-12);
  CHECK(std::abs(bpearl.channels[5].origin.x - 0.01473) < 1e-12);
  CHECK(std::abs(bpearl.channels[5].origin.z - 0.09427) < 1e-12);
  for (const char* name : {"RS-Helios-32", "RS-Helios-1615"})
    CHECK(std::abs(builtinSensor(name).channels[3].origin.x - 0.03498) < 1e-12);
  // ros-drivers/velodyne, driver.cc: 2,222,220 points per second, half of them in each return.
  const Sensor s3 = builtinSensor("HDL-64E-S3");
  CHECK(std::abs(s3.rotationPeriod / s3.columns - 64 / 1111110.0) < 1e-9);
}

TEST_CASE("heads of turning prisms have the field of view and the rate of their sheets") {
  const struct {
    const char* name;
    double horizontal, vertical, perSecond;
    uint32_t lasers;
  } sheets[] = {{"Mid-40", 38.4, 38.4, 100000, 1}, {"Mid-70", 70.4, 70.4, 100000, 1}, {"Avia", 70.4, 77.2, 240000, 6}};
  for (const auto& sheet : sheets) {
    INFO(sheet.name);
    const Sensor sensor = builtinSensor(sheet.name);
    double left = 0, right = 0, down = 0, up = 0;
    for (const BeamList& list : sensor.patterns) {
      CHECK(10.0 * static_cast<double>(list.size()) == sheet.perSecond);
      CHECK(std::abs(list.times.back() - (0.1 - 1 / sheet.perSecond)) < 1e-12);
      CHECK((list.rings.empty() ? 0u : list.rings.back()) + 1u == sheet.lasers);
      for (const Vec3& d : list.directions) {
        const double azimuth = std::atan2(d.y, d.x) * 180 / std::numbers::pi;
        const double elevation = std::asin(d.z) * 180 / std::numbers::pi;
        left = std::max(left, azimuth), right = std::min(right, azimuth);
        up = std::max(up, elevation), down = std::min(down, elevation);
      }
    }
    CHECK(std::abs(left - right - sheet.horizontal) < 0.3);
    CHECK(std::abs(up - down - sheet.vertical) < 0.2);
  }
}

TEST_CASE("the Mid-360 has the directions of Livox's table") {
  const Sensor sensor = builtinSensor("Mid-360");
  CHECK(sensor.patterns.size() == 40);
  double down = 1, up = -1;
  for (const BeamList& list : sensor.patterns) {
    CHECK(list.size() == 20000);
    for (const Vec3& d : list.directions) {
      CHECK_FALSE(std::abs(lengthOf(d) - 1) > 1e-12);
      down = std::min(down, d.z), up = std::max(up, d.z);
    }
  }
  // mid360.csv of Livox's simulation plug-in, MIT: its least and greatest elevation, and some of its 800,000 rows.
  const double degree = std::numbers::pi / 180;
  CHECK(std::abs(std::asin(down) + 7.2123 * degree) < 0.11 * degree);
  CHECK(std::abs(std::asin(up) - 52.164 * degree) < 0.11 * degree);
  const struct {
    size_t row;
    double azimuth, elevation;
  } rows[] = {{0, 268.99, 52.162},      {1, 269, 49.175},         {2, 269, 46.419},         {3, 269, 43.848},
              {5000, 91.984, 17.768},   {12345, 158.56, 4.34},    {19999, 180.11, 47.532},  {20000, 185.17, 47.943},
              {123456, 75.738, 26.751}, {333333, 237.35, 10.819}, {456789, 16.555, 29.386}, {600001, 180.05, 47.754},
              {777777, 104.74, 36.037}, {799999, 33.069, 49.939}};
  for (const auto& row : rows) {
    INFO(row.row);
    const BeamList& list = sensor.patterns[row.row / 20000];
    const double across = std::cos(row.elevation * degree);
    const Vec3 expected = {across * std::cos(row.azimuth * degree), across * std::sin(row.azimuth * degree),
                           std::sin(row.elevation * degree)};
    CHECK(lengthOf(list.directions[row.row % 20000] - expected) < 0.11 * degree);
    CHECK(list.rings[row.row % 20000] == row.row % 4);
    CHECK(std::abs(list.times[row.row % 20000] - double(row.row % 20000 / 4) * 20e-6) < 1e-12);
  }
}

TEST_CASE("two equal prisms deflect most when both are thickest on one side, and not at all on opposite sides") {
  const double wedge = 18 * std::numbers::pi / 180, index = 1.5089;
  // Snell's law in the plane of the wedges, all angles from the axis towards the thick side. The second prism's face
  // is inclined where light enters.
  const double first = std::asin(index * std::sin(wedge)) - wedge;
  const double inside = wedge - std::asin(std::sin(wedge - first) / index);
  const double most = std::asin(index * std::sin(inside));
  double least = 1, greatest = 0;
  for (const BeamList& list : builtinSensor("Mid-40").patterns)
    for (const Vec3& d : list.directions) {
      const double angle = std::atan2(std::hypot(d.y, d.z), d.x);
      least = std::min(least, angle), greatest = std::max(greatest, angle);
    }
  CHECK(greatest <= most + 1e-12);
  CHECK(greatest > most - 1e-6);
  CHECK(least < 1e-3);
  // The pattern begins with the thick sides on the left.
  const Vec3 start = builtinSensor("Mid-40").patterns[0].directions[0];
  CHECK(std::abs(std::atan2(start.y, start.x) - most) < 1e-4);
  CHECK(std::abs(start.z) < 2e-3);
}

TEST_CASE("the M1 has five zones of 126 lines and 125 columns that fire together") {
  const Sensor sensor = builtinSensor("RS-M1");
  const BeamList& list = sensor.patterns.at(0);
  REQUIRE(list.size() == 78750);
  CHECK(list.width == 625);
  CHECK(list.height == 126);
  const auto azimuth = [&](size_t beam) { return std::atan2(list.directions[beam].y, list.directions[beam].x); };
  const double degree = std::numbers::pi / 180;
  CHECK(std::abs(azimuth(0) - 60 * degree) < 1e-12);
  CHECK(std::abs(azimuth(124) - 35.2 * degree) < 1e-12);
  CHECK(std::abs(azimuth(624) + 60 * degree) < 1e-12);
  CHECK(std::abs(std::asin(list.directions[0].z) - 12.5 * degree) < 1e-12);
  CHECK(std::abs(std::asin(list.directions.back().z) + 12.5 * degree) < 1e-12);
  for (size_t zone = 0; zone < 5; ++zone) {
    CHECK(list.rings[125 * zone] == zone);
    CHECK(list.times[625 + 125 * zone + 7] == 0.1 * (125 + 7) / 15750);
  }
}
