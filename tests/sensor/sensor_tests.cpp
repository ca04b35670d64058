// SPDX-License-Identifier: Apache-2.0
// Sensors: their beams, JSON and what is refused.
#include <algorithm>
#include <bit>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "gnosphere/error.hpp"
#include "gnosphere/sensor.hpp"
#include "problem.hpp"
#include "sensor/beams.hpp"

using namespace gnosphere;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::EndsWith;

namespace {

uint64_t bits(double value) {
  return std::bit_cast<uint64_t>(value);
}

ErrorCode codeOf(const auto& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.code();
  }
  FAIL("no Error was thrown");
  return {};
}

std::string problemOf(const std::string& json) {
  return test::problemOf([&] { sensorFromJson(json, "test.json"); }, ErrorCode::format);
}

Sensor small() {
  Sensor sensor;
  sensor.name = "small";
  sensor.columns = 4;
  sensor.rangeMax = 10;
  sensor.channels = {{-10, 0}, {10, 0}};
  return sensor;
}

}  // namespace

TEST_CASE("the built-in sensors are those of Table 2 of the paper") {
  struct Row {
    const char* name;
    double low, high;
    uint32_t columns;
    size_t channels;
    double range;
  };
  const Row rows[] = {{"VLP-16", -15, 15, 1800, 16, 100},
                      {"VLP-32", -25, 15, 3600, 32, 100},
                      {"HDL-64E", -25, 2, 4500, 64, 120},
                      {"Hypothetical-256", -45, 45, 18000, 256, 200},
                      {"Hypothetical-350", -45, 45, 18000, 350, 200}};
  REQUIRE(builtinSensors().size() == std::size(rows));
  for (size_t i = 0; i < std::size(rows); ++i) {
    const Sensor& sensor = builtinSensors()[i];
    INFO(sensor.name);
    CHECK(sensor.name == rows[i].name);
    CHECK(sensor.columns == rows[i].columns);
    REQUIRE(sensor.channels.size() == rows[i].channels);
    CHECK(sensor.rangeMin == 0);
    CHECK(sensor.rangeMax == rows[i].range);
    CHECK(sensor.channels.front().elevationDeg == rows[i].low);
    CHECK(sensor.channels.back().elevationDeg == rows[i].high);
    const double step = (rows[i].high - rows[i].low) / static_cast<double>(rows[i].channels - 1);
    for (size_t j = 0; j < sensor.channels.size(); ++j) {
      CHECK(std::abs(sensor.channels[j].elevationDeg - (rows[i].low + step * static_cast<double>(j))) < 1e-12);
      CHECK(sensor.channels[j].azimuthOffsetDeg == 0);
    }
    CHECK_NOTHROW(validate(sensor));
  }
}

TEST_CASE("a sensor that is symmetric about the horizon has exactly opposite channels") {
  for (const char* name : {"VLP-16", "Hypothetical-256", "Hypothetical-350"}) {
    const Sensor sensor = builtinSensor(name);
    const size_t count = sensor.channels.size();
    for (size_t j = 0; j < count; ++j) {
      CHECK(sensor.channels[j].elevationDeg == -sensor.channels[count - 1 - j].elevationDeg);
    }
  }
}

TEST_CASE("directions follow the convention: column 0 points back, columns turn counter-clockwise") {
  Sensor sensor = small();
  sensor.channels = {{0, 0}};
  const Vec3 expected[] = {{-1, 0, 0}, {0, -1, 0}, {1, 0, 0}, {0, 1, 0}};
  for (size_t i = 0; i < 4; ++i) {
    const Vec3 d = sensor.direction(i);
    CHECK(d.x == expected[i].x);  // equal without any rounding error
    CHECK(d.y == expected[i].y);
    CHECK(d.z == 0);
  }
}

TEST_CASE("directions agree with the textbook formula and have unit length") {
  Sensor sensor = builtinSensor("HDL-64E");
  for (size_t j = 0; j < sensor.channels.size(); ++j) {
    sensor.channels[j].azimuthOffsetDeg = 7.5 - static_cast<double>(j) * 4.25;  // exceeds one turn at the seam
  }
  // Column and offset are rounded once each at up to 360 degrees (5e-16 rad), sine and cosine by 1e-16.
  const double bound = 1e-15;
  for (size_t beam = 0; beam < sensor.beamCount(); beam += 37) {
    const long double toRadians = std::numbers::pi_v<long double> / 180;
    const Channel& channel = sensor.channels[beam / sensor.columns];
    const long double e = channel.elevationDeg * toRadians;
    const long double a =
        (-180 + 360.0L * static_cast<long double>(beam % sensor.columns) / sensor.columns + channel.azimuthOffsetDeg) *
        toRadians;
    const Vec3 d = sensor.direction(beam);
    CHECK(std::abs(d.x - static_cast<double>(std::cos(e) * std::cos(a))) < bound);
    CHECK(std::abs(d.y - static_cast<double>(std::cos(e) * std::sin(a))) < bound);
    CHECK(std::abs(d.z - static_cast<double>(std::sin(e))) < bound);
    CHECK(std::abs(d.x * d.x + d.y * d.y + d.z * d.z - 1) < 1e-15);
  }
}

TEST_CASE("opposite columns, and straight up and down, have exactly opposite directions") {
  Sensor sensor = small();
  sensor.columns = 3600;  // a tenth of a degree is not exact in a double
  sensor.channels = {{-90, 0}, {33, 0}, {90, 0}};
  for (size_t i = 1; i < 1800; ++i) {
    const Vec3 left = sensor.direction(3600 + 1800 + i), right = sensor.direction(3600 + 1800 - i);
    CHECK(left.x == right.x);
    CHECK(left.y == -right.y);
  }
  CHECK(sensor.direction(17).z == -1);
  CHECK(sensor.direction(17).x == 0);
  CHECK(sensor.direction(7200 + 17).z == 1);
}

TEST_CASE("JSON keeps the bits of every field of a sensor") {
  Sensor sensor = small();
  sensor.name = "odd \"name\" \\ with Ünïcode\n";
  sensor.rangeMin = 0.1;
  sensor.rangeMax = std::nextafter(100.0, 200.0);
  sensor.channels = {{-0.0, -0.0},
                     {1.0 / 3, 5e-324},
                     {-24.999999999999996, std::numeric_limits<double>::min()},
                     {90, -360},
                     {1e-7, 0}};
  const Sensor back = sensorFromJson(toJson(sensor), "test");
  CHECK(back.name == sensor.name);
  CHECK(back.columns == sensor.columns);
  CHECK(bits(back.rangeMin) == bits(sensor.rangeMin));
  CHECK(bits(back.rangeMax) == bits(sensor.rangeMax));
  REQUIRE(back.channels.size() == sensor.channels.size());
  for (size_t j = 0; j < sensor.channels.size(); ++j) {
    CHECK(bits(back.channels[j].elevationDeg) == bits(sensor.channels[j].elevationDeg));
    CHECK(bits(back.channels[j].azimuthOffsetDeg) == bits(sensor.channels[j].azimuthOffsetDeg));
  }
}

TEST_CASE("JSON keeps the bits of the optional properties of a sensor") {
  Sensor sensor = small();
  sensor.divergenceHorizontal = 3e-3;
  sensor.maxReturns = 3;
  sensor.rotationPeriod = 0.4;
  sensor.scanPeriod = 2.0 / 3;
  sensor.channels[0].origin = {1.0 / 3, -0.0, 5e-324};
  sensor.channels[1].timeOffset = -1.0 / 3;
  for (double mrad : {0.0, 1.5, 1.0 / 3, 100.0 / 3, 1e-6, 100.0}) {
    sensor.divergenceVertical = mrad / 1000;
    const std::string json = toJson(sensor);
    const Sensor back = sensorFromJson(json, "test");
    CHECK(bits(back.divergenceHorizontal) == bits(3e-3));
    CHECK(bits(back.divergenceVertical) == bits(mrad / 1000));
    CHECK(back.maxReturns == 3);
    CHECK(bits(back.rotationPeriod) == bits(0.4));
    CHECK(bits(back.scanPeriod) == bits(2.0 / 3));
    CHECK(bits(back.channels[0].origin.x) == bits(1.0 / 3));
    CHECK(bits(back.channels[0].origin.y) == bits(-0.0));
    CHECK(bits(back.channels[0].origin.z) == bits(5e-324));
    CHECK(bits(back.channels[1].origin.x) == 0);
    CHECK(bits(back.channels[1].timeOffset) == bits(-1.0 / 3));
    CHECK(toJson(back) == json);
  }
  CHECK_THAT(toJson(sensor), ContainsSubstring("\"divergence_mrad\": [3, 100]"));
  CHECK_THAT(toJson(sensor), ContainsSubstring("\"elevation_deg\": [-10, 10]"));
  for (const Sensor& builtin : builtinSensors()) {
    const std::string json = toJson(builtin);
    // Long lists are broken into full lines, which fit a window.
    const auto lines = static_cast<size_t>(std::ranges::count(json, '\n'));
    CHECK(lines < 12 + json.size() / 70);
    for (size_t at = 0; at < json.size(); at = json.find('\n', at) + 1) CHECK(json.find('\n', at) - at < 110);
    for (const char* key : {"divergence", "max_returns", "rotation_period", "scan_period", "origin", "time_offset"})
      CHECK(json.find(key) == json.npos);
  }
}

TEST_CASE("JSON keeps sectors, range windows, masked beams and lists") {
  Sensor grid = small();
  grid.azimuthStartDeg = 60;
  grid.azimuthSpanDeg = -120.1;
  grid.nearHits = NearHits::hide;
  grid.maskedBeams = {1, 7};
  grid.channels[1].rangeMin = 0.1;
  grid.channels[0].rangeMax = 7;
  const Sensor back = sensorFromJson(toJson(grid), "test");
  CHECK(back.azimuthStartDeg == 60);
  CHECK(bits(back.azimuthSpanDeg) == bits(-120.1));
  CHECK(back.nearHits == NearHits::hide);
  CHECK(back.maskedBeams == grid.maskedBeams);
  CHECK(back.channels[1].rangeMin == 0.1);
  CHECK(back.channels[0].rangeMax == 7);
  CHECK(toJson(back) == toJson(grid));
  grid.name = "caf\xe9";
  CHECK_THAT(test::problemOf([&] { toJson(grid); }, ErrorCode::invalidArgument),
             ContainsSubstring("the sensor's name is not UTF-8, JSON cannot hold it"));

  Sensor list;
  list.name = "list";
  list.rangeMax = 50;
  list.maskedBeams = {0};
  const double d = std::sqrt(1.0 / 3);
  list.patterns = {
      {{{1, 0, 0}, {d, d, d}}, {{0.1, 0, 5e-324}, {0, 0, 0}}, {0, 0.1}, {0.1f, 0}, {1e30f, 2}, {65535, 3}, 1, 2},
      {{{0, 0, 1}, {0, -1, 0}}, {}, {}, {}, {}, {}, 1, 2}};
  const Sensor same = sensorFromJson(toJson(list), "test");
  REQUIRE(same.patterns.size() == 2);
  CHECK(bits(same.patterns[0].directions[1].y) == bits(d));
  CHECK(bits(same.patterns[0].origins[0].z) == bits(5e-324));
  CHECK(same.patterns[0].times == list.patterns[0].times);
  CHECK(same.patterns[0].rangeMin == list.patterns[0].rangeMin);
  CHECK(same.patterns[0].rangeMax == list.patterns[0].rangeMax);
  CHECK(same.patterns[0].rings == list.patterns[0].rings);
  CHECK(same.patterns[0].height == 2);
  CHECK(same.patterns[1].origins.empty());
  CHECK(same.maskedBeams == list.maskedBeams);
  CHECK(toJson(same) == toJson(list));
}

TEST_CASE("invalid lists are refused with the cause") {
  const auto pattern = [](const std::string& rest) {
    return problemOf(R"({"name": "a", "range": {"max": 5}, "patterns": [{"directions": [[1, 0, 0], [0, 1, 0]])" + rest);
  };
  CHECK_THAT(pattern(R"(}], "columns": 8})"), ContainsSubstring("'patterns' and 'columns' are alternatives"));
  CHECK_THAT(pattern(R"(, "rings": [0, 65536]}]})"), ContainsSubstring("patterns[0].rings[1]"));
  CHECK_THAT(pattern(R"(, "rings": [0]}]})"), ContainsSubstring("a: rings has 1 entries, directions has 2"));
  CHECK_THAT(pattern(R"(}, {"directions": [[1, 0, 0], [0, 1, 0]], "rings": [0]}]})"),
             ContainsSubstring("a: pattern 1: rings has 1 entries, directions has 2"));
  CHECK_THAT(pattern(R"(, "times": [0, "1"]}]})"), ContainsSubstring("patterns[0].times[1]"));
  CHECK_THAT(pattern(R"(, "range_max": [0, 1e300]}]})"), ContainsSubstring("which is no range"));
  CHECK_THAT(pattern(R"(, "width": 3, "height": 1}]})"), ContainsSubstring("does not suit 2 beams"));
  CHECK_THAT(pattern(R"(, "ring": []}]})"), ContainsSubstring("unknown key 'ring' in patterns[0]"));
  CHECK_THAT(pattern(R"(}, 7]})"), ContainsSubstring("'patterns[1]' must be an object"));
  CHECK_THAT(pattern(R"(, "origins": 7}]})"), ContainsSubstring("'patterns[0].origins' must be a list of [x, y, z]"));
  CHECK_THAT(pattern(R"(}], "masked_beams": [2]})"), ContainsSubstring("masked beam 2 does not exist"));
  CHECK_THAT(pattern(R"(}], "near_hits": "block"})"), ContainsSubstring("'near_hits' must be"));
  CHECK_THAT(problemOf(R"({"name": "a", "range": {"max": 5}, "patterns": []})"),
             ContainsSubstring("with one at least"));
  CHECK_THAT(problemOf(R"({"name": "a", "range": {"max": 5}, "patterns": [{"directions": []}]})"),
             ContainsSubstring("directions are empty"));
}

TEST_CASE("a pattern may state azimuths and elevations in place of directions") {
  const auto file = [](const std::string& pattern) {
    return R"({"name": "a", "range": {"max": 5}, "patterns": [{)" + pattern + "}]}";
  };
  const Sensor sensor = sensorFromJson(
      file(
          R"("azimuth_deg": [0, 90, -90, 180, 30, 0], "elevation_deg": [0, 0, 0, 0, 60, -90], "width": 3, "height": 2)"),
      "test");
  const BeamList& list = sensor.patterns.at(0);
  CHECK(list.width == 3);
  const double along = 0.5 * std::sqrt(3.0) / 2;
  const Vec3 expected[] = {{1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {-1, 0, 0}, {along, 0.25, std::sqrt(3.0) / 2}, {0, 0, -1}};
  REQUIRE(list.size() == std::size(expected));
  for (size_t i = 0; i < list.size(); ++i) {
    INFO(i);
    CHECK(std::abs(list.directions[i].x - expected[i].x) < (i == 4 ? 1e-15 : 1e-300));
    CHECK(std::abs(list.directions[i].y - expected[i].y) < (i == 4 ? 1e-15 : 1e-300));
    CHECK(std::abs(list.directions[i].z - expected[i].z) < (i == 4 ? 1e-15 : 1e-300));
  }
  const auto refusal = [&](const std::string& pattern) { return problemOf(file(pattern)); };
  CHECK_THAT(
      refusal(R"("directions": [[1, 0, 0]], "azimuth_deg": [0], "elevation_deg": [0])"),
      EndsWith("'directions' of patterns[0] and its 'azimuth_deg' and 'elevation_deg' are alternatives; keep one"));
  CHECK_THAT(refusal(R"("azimuth_deg": [0])"), EndsWith("'elevation_deg' is missing in patterns[0]"));
  CHECK_THAT(refusal(R"("elevation_deg": [0])"), EndsWith("'azimuth_deg' is missing in patterns[0]"));
  CHECK_THAT(refusal(R"("rings": [0])"),
             EndsWith("'directions', or 'azimuth_deg' and 'elevation_deg', is missing in patterns[0]"));
  CHECK_THAT(
      refusal(R"("azimuth_deg": [0, 1], "elevation_deg": [0])"),
      EndsWith("'azimuth_deg' of patterns[0] has 2 entries, its 'elevation_deg' has 1; there must be one per beam "
               "in both"));
  CHECK_THAT(refusal(R"("azimuth_deg": [0], "elevation_deg": [91])"),
             EndsWith("'patterns[0].elevation_deg[0]' must be within -90..90 degrees, is 91"));
  CHECK_THAT(refusal(R"("azimuth_deg": [0, -721], "elevation_deg": [0, 0])"),
             EndsWith("'patterns[0].azimuth_deg[1]' must be within -720..720 degrees, is -721"));
  CHECK_THAT(refusal(R"("azimuth_deg": [], "elevation_deg": [])"), ContainsSubstring("directions are empty"));
}

TEST_CASE("channel objects may state origins and time offsets") {
  const Sensor sensor = sensorFromJson(
      R"({"name": "a", "columns": 8, "range": {"max": 5}, "max_returns": 2, "divergence_mrad": [3, 1.5],
          "channels": [{"elevation_deg": -1, "origin": [0.25, 0, -0.5], "time_offset": 1e-6}, {"elevation_deg": 3}]})",
      "test");
  CHECK(sensor.maxReturns == 2);
  CHECK(sensor.divergenceVertical == 1.5e-3);
  CHECK(sensor.channels[0].origin.x == 0.25);
  CHECK(sensor.channels[0].origin.z == -0.5);
  CHECK(sensor.channels[0].timeOffset == 1e-6);
  CHECK(sensor.channels[1].origin.x == 0);
}

TEST_CASE("JSON keeps the bits of every built-in sensor") {
  for (const Sensor& sensor : builtinSensors()) {
    const Sensor back = sensorFromJson(toJson(sensor), sensor.name);
    REQUIRE(back.channels.size() == sensor.channels.size());
    for (size_t j = 0; j < sensor.channels.size(); ++j) {
      CHECK(bits(back.channels[j].elevationDeg) == bits(sensor.channels[j].elevationDeg));
    }
    CHECK(toJson(back) == toJson(sensor));
  }
}

TEST_CASE("channels may be written as objects instead of lists") {
  const Sensor sensor = sensorFromJson(
      R"({"name": "a", "columns": 8, "range": {"max": 5},
          "channels": [{"elevation_deg": -1, "azimuth_offset_deg": 2.5}, {"elevation_deg": 3}]})",
      "test");
  REQUIRE(sensor.channels.size() == 2);
  CHECK(sensor.channels[0].azimuthOffsetDeg == 2.5);
  CHECK(sensor.channels[1].elevationDeg == 3);
  CHECK(sensor.channels[1].azimuthOffsetDeg == 0);
  CHECK(sensor.rangeMin == 0);
}

TEST_CASE("a sensor without channels has no beams, and a file of one is refused") {
  Sensor sensor = small();
  sensor.channels.clear();
  CHECK_NOTHROW(validate(sensor));
  CHECK(sensor.beamCount() == 0);
  CHECK_THAT(problemOf(toJson(sensor)), ContainsSubstring("'elevation_deg' is empty; a sensor has one channel"));
  CHECK_THAT(problemOf(R"({"name": "none", "columns": 8, "range": {"max": 5}, "channels": []})"),
             ContainsSubstring("'channels' is empty"));
}

TEST_CASE("a whole number of a sensor file may be written with a point") {
  const Sensor sensor = sensorFromJson(
      R"({"name": "a", "columns": 100.0, "range": {"max": 5}, "elevation_deg": [1], "max_returns": 2.0,
          "masked_beams": [3.0]})",
      "test");
  CHECK(sensor.columns == 100);
  CHECK(sensor.maxReturns == 2);
  CHECK(sensor.maskedBeams == std::vector<uint32_t>{3});
  for (const char* bad : {"4294967296", "1e300", "-1.0", "0.5", "\"8\"", "true"})
    CHECK_THAT(
        problemOf(R"({"name": "a", "range": {"max": 5}, "elevation_deg": [1], "columns": )" + std::string(bad) + "}"),
        ContainsSubstring("'columns' must be a whole number from 0 to 4294967295"));
}

TEST_CASE("an invalid sensor file is refused with the cause") {
  const auto file = [](const std::string& rest) { return R"({"name": "a", "range": {"min": 0, "max": 5}, )" + rest; };
  CHECK_THAT(problemOf(file(R"("columns": 8, "elevation_deg": [1, 2, 3], "azimuth_offset_deg": [1, 2]})")),
             ContainsSubstring("has 3 entries") && ContainsSubstring("has 2;"));
  CHECK_THAT(problemOf(file(R"("columns": 0, "elevation_deg": [1]})")),
             ContainsSubstring("columns must be at least 1"));
  CHECK_THAT(problemOf(file(R"("columns": -8, "elevation_deg": [1]})")), ContainsSubstring("'columns'"));
  CHECK_THAT(problemOf(file(R"("columns": 8.5, "elevation_deg": [1]})")), ContainsSubstring("'columns'"));
  CHECK_THAT(problemOf(file(R"("columns": 8, "elevation_deg": [1e999]})")), ContainsSubstring("1e999"));
  CHECK_THAT(problemOf(file(R"("columns": 8, "elevation_deg": [NaN]})")), ContainsSubstring("not JSON"));
  CHECK_THAT(problemOf(file(R"("columns": 8, "elevation_deg": [1, 90.5]})")), ContainsSubstring("channel 1"));
  CHECK_THAT(problemOf(file(R"("columns": 8, "elevation_deg": [1, "2"]})")), ContainsSubstring("elevation_deg[1]"));
  CHECK_THAT(problemOf(file(R"("columns": 8, "elevation": [1]})")),
             ContainsSubstring("unknown key 'elevation'") && ContainsSubstring("known are name, columns, range"));
  CHECK_THAT(problemOf(file(R"("columns": 8})")), ContainsSubstring("'elevation_deg' is missing"));
  CHECK_THAT(problemOf(file(R"("columns": 8, "channels": [], "elevation_deg": []})")), ContainsSubstring("keep one"));
  CHECK_THAT(problemOf(file(R"("columns": 8, "elevation_deg": [1])")), ContainsSubstring("not JSON"));
  CHECK_THAT(problemOf(""), ContainsSubstring("test.json") && ContainsSubstring("not JSON"));
  CHECK_THAT(problemOf("[]"), ContainsSubstring("a JSON object"));
  CHECK_THAT(problemOf(R"({"name": "a", "columns": 8, "columns": 4, "range": {"max": 5}, "elevation_deg": [1]})"),
             ContainsSubstring("'columns' is there twice; keep one"));
  CHECK_THAT(problemOf(R"({"name": "a", "columns": 8, "range": {"min": 6, "max": 5}, "elevation_deg": [1]})"),
             ContainsSubstring("beyond range max"));
  CHECK_THAT(problemOf(R"({"name": "a", "columns": 8, "range": {"max": 1e39}, "elevation_deg": [1]})"),
             ContainsSubstring("range max must be finite in single precision, is 1e+39"));
  CHECK_THAT(problemOf(R"({"name": "a", "columns": 8, "range": {"min": -1, "max": 5}, "elevation_deg": [1]})"),
             ContainsSubstring("range min"));
  CHECK_THAT(problemOf(R"({"name": "a", "columns": 4294967295, "range": {"max": 5}, "elevation_deg": [1, 2]})"),
             ContainsSubstring("8589934590 beams"));
  CHECK_THAT(problemOf(std::string(100000, '[')), ContainsSubstring("not JSON"));
  const auto more = [&](const std::string& rest) { return problemOf(file(R"("columns": 8, )" + rest + "}")); };
  CHECK_THAT(more(R"("elevation_deg": [1], "divergence_mrad": 3)"), ContainsSubstring("list of numbers"));
  CHECK_THAT(more(R"("elevation_deg": [1], "divergence_mrad": [3])"), ContainsSubstring("must be 2 numbers, has 1"));
  CHECK_THAT(
      more(R"("elevation_deg": [1], "divergence_mrad": [3, 101])"),
      EndsWith(
          "0..100 mrad, is 101; a footprint is taken as flat, so a wider beam is a list of several: docs/limits.md"));
  CHECK_THAT(more(R"("elevation_deg": [1], "divergence_mrad": [-1, 0])"), EndsWith("0..100 mrad, is -1"));
  for (const char* returns : {"0", "16", "1.5", "-1", "\"2\""})
    CHECK_THAT(more(R"("elevation_deg": [1], "max_returns": )" + std::string(returns)), ContainsSubstring("returns"));
  CHECK_THAT(more(R"("elevation_deg": [1], "rotation_period": 10.5)"), ContainsSubstring("1e-9..10 s, is 10.5"));
  CHECK_THAT(more(R"("elevation_deg": [1], "origin": [0, 0, 0])"), ContainsSubstring("'origin' has 3"));
  CHECK_THAT(more(R"("elevation_deg": [1], "origin": [[0, 1]])"), ContainsSubstring("'origin[0]' must be 3 numbers"));
  CHECK_THAT(more(R"("elevation_deg": [1], "origin": [[0.8, 0.8, 0]])"), ContainsSubstring("within 1 m"));
  CHECK_THAT(more(R"("elevation_deg": [1], "time_offset": [-2])"), ContainsSubstring("-1..1 s, is -2"));
  CHECK_THAT(more(R"("elevation_deg": [1], "time_offset": ["0"])"), ContainsSubstring("'time_offset[0]'"));
  CHECK_THAT(more(R"("channels": [], "origin": [])"), ContainsSubstring("keep one"));
  CHECK_THAT(more(R"("channels": 7)"), ContainsSubstring("'channels' must be a list"));
  CHECK_THAT(more(R"("channels": [7])"), ContainsSubstring("'channels[0]' must be an object"));
  CHECK_THAT(more(R"("elevation_deg": [1], "time_offset": 7)"),
             ContainsSubstring("'time_offset' must be a list, one entry per channel"));
  CHECK_THAT(more(R"("elevation_deg": [1], "masked_beams": 7)"),
             ContainsSubstring("'masked_beams' must be a list of whole numbers"));
  CHECK_THAT(problemOf(R"({"name": 7, "range": {"max": 5}})"), ContainsSubstring("'name' must be a text"));
  CHECK_THAT(problemOf(R"({"name": "a", "range": [0, 5]})"), ContainsSubstring("'range' must be an object with 'min'"));
}

TEST_CASE("validate names what is wrong with a grid or a list") {
  Sensor list{.name = "list", .rangeMax = 10};
  list.patterns.resize(2);
  for (BeamList& pattern : list.patterns) pattern.directions = {{1, 0, 0}, {0, 1, 0}};
  CHECK_NOTHROW(validate(list));
  struct Mistake {
    std::function<void(Sensor&)> make;
    const char* told;
  };
  const auto check = [](const Sensor& good, const std::vector<Mistake>& mistakes) {
    for (const Mistake& mistake : mistakes) {
      Sensor sensor = good;
      mistake.make(sensor);
      CHECK_THAT(test::problemOf([&] { validate(sensor); }, ErrorCode::invalidArgument),
                 ContainsSubstring(mistake.told));
    }
  };
  check(small(),
        {
            {[](Sensor& s) { s.channels[1].rangeMin = -1; },
             "small: range of channel 1 must be finite and at least 0, is -1"},
            {[](Sensor& s) { s.channels[0].rangeMax = 1e39; },
             "range of channel 0 must be finite and at least 0, is 1e+39"},
            {[](Sensor& s) { s.azimuthStartDeg = -361; }, "azimuth start must be within -360..360 degrees, is -361"},
            {[](Sensor& s) { s.azimuthStartDeg = NAN; }, "azimuth start must be within -360..360 degrees, is nan"},
            {[](Sensor& s) { s.azimuthSpanDeg = 361; },
             "azimuth span must be within -360..360 degrees and not 0, is 361"},
            {[](Sensor& s) { s.azimuthSpanDeg = 0; }, "azimuth span must be within -360..360 degrees and not 0, is 0"},
            {[](Sensor& s) { s.azimuthSpanDeg = NAN; },
             "azimuth span must be within -360..360 degrees and not 0, is nan"},
            {[](Sensor& s) { s.rangeAt10Percent = -1; }, "range at 10 % must be finite and at least 0"},
            {[](Sensor& s) { s.rangeAt10Percent = INFINITY; }, "range at 10 % must be finite and at least 0"},
            {[](Sensor& s) { s.maxReturns = 0; }, "max returns must be within 1..15, is 0"},
            {[](Sensor& s) { s.maxReturns = 16; }, "max returns must be within 1..15, is 16"},
        });
  check(list, {
                  {[](Sensor& s) { s.patterns[1].directions.pop_back(); },
                   "pattern 1: has 1 beams, pattern 0 has 2; all patterns"},
                  {[](Sensor& s) { s.columns = 2; },
                   "columns and channels belong to a grid, patterns to a list of beams; keep one"},
                  {[](Sensor& s) { s.channels.resize(1); }, "columns and channels belong to a grid"},
                  {[](Sensor& s) { s.patterns[1].width = 2, s.patterns[1].height = 1; },
                   "pattern 1: its organised cloud has another"},
                  {[](Sensor& s) { s.patterns[0].width = 2, s.patterns[0].height = 1; },
                   "pattern 1: its organised cloud has another"},
              });
}

TEST_CASE("validate refuses invalid sensors") {
  const double bad = GENERATE(std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity());
  Sensor sensor = small();
  CHECK_NOTHROW(validate(sensor));
  sensor.channels[1].elevationDeg = bad;
  CHECK(codeOf([&] { validate(sensor); }) == ErrorCode::invalidArgument);
  sensor = small();
  sensor.channels[1].azimuthOffsetDeg = bad;
  CHECK(codeOf([&] { validate(sensor); }) == ErrorCode::invalidArgument);
  sensor = small();
  sensor.rangeMax = bad;
  CHECK(codeOf([&] { validate(sensor); }) == ErrorCode::invalidArgument);
  sensor = small();
  sensor.rangeMin = bad;
  CHECK(codeOf([&] { validate(sensor); }) == ErrorCode::invalidArgument);
  for (double Sensor::*member :
       {&Sensor::divergenceHorizontal, &Sensor::divergenceVertical, &Sensor::rotationPeriod, &Sensor::scanPeriod}) {
    sensor = small();
    sensor.*member = bad;
    CHECK(codeOf([&] { validate(sensor); }) == ErrorCode::invalidArgument);
  }
  sensor = small();
  sensor.channels[1].origin.y = bad;
  CHECK(codeOf([&] { validate(sensor); }) == ErrorCode::invalidArgument);
  sensor = small();
  sensor.channels[1].timeOffset = bad;
  CHECK(codeOf([&] { validate(sensor); }) == ErrorCode::invalidArgument);
}

TEST_CASE("validate refuses scans so short that the speed of what moves meanwhile has no number") {
  Sensor sensor = small();
  for (const double period : {5e-324, 1e-300, 9e-10}) {
    sensor.rotationPeriod = period;
    CHECK_THAT(test::problemOf([&] { validate(sensor); }, ErrorCode::invalidArgument),
               ContainsSubstring("rotation period must be 0 or within 1e-9..10 s, is "));
  }
  sensor.rotationPeriod = 1e-9;
  CHECK_NOTHROW(validate(sensor));
  // Without a turn what moves meanwhile is at its end when the last beam fires.
  Sensor offsets = small(), list = small();
  offsets.rotationPeriod = 0;
  list.columns = 0;
  list.channels.clear();
  list.patterns.assign(2, {{{1, 0, 0}, {0, 1, 0}}, {}, {0, 0}});
  for (const double last : {5e-324, 9e-10, 1e-9, 0.0}) {
    offsets.channels[1].timeOffset = list.patterns[1].times[0] = last;
    for (const Sensor& late : {offsets, list}) {
      if (last == 0 || last == 1e-9)
        CHECK_NOTHROW(validate(late));
      else
        CHECK_THAT(test::problemOf([&] { validate(late); }, ErrorCode::invalidArgument),
                   ContainsSubstring("the last beam must fire at 0 s, or at 1e-9 s or later, and fires at "));
    }
  }
}

TEST_CASE("validate refuses channels that measure nothing or fire in another turn") {
  const auto mistake = [](double least, double most, double time) {
    Sensor sensor = small();  // of 10 m
    sensor.rangeMin = 2;
    sensor.rotationPeriod = 0.1;
    sensor.channels[1].rangeMin = least;
    sensor.channels[1].rangeMax = most;
    sensor.channels[1].timeOffset = time;
    return test::problemOf([&] { validate(sensor); }, ErrorCode::invalidArgument);
  };
  for (const double least : {10.0, 12.0})
    CHECK_THAT(mistake(least, 0, 0), ContainsSubstring("range min of channel 1 must be less than its range max, 10,"));
  CHECK_THAT(mistake(5, 5, 0), ContainsSubstring("must be less than its range max, 5, is 5"));
  CHECK_THAT(mistake(0, 1, 0), ContainsSubstring("must be less than its range max, 1, is 2"));
  CHECK_THAT(mistake(0, 0, -0.11),
             ContainsSubstring("time offset of channel 1 must be within the rotation period, 0.1 s, is -0.11"));
  Sensor sensor = small();
  sensor.channels[1].rangeMin = 12;
  sensor.channels[1].rangeMax = 20;
  sensor.rotationPeriod = 0.1;
  sensor.channels[1].timeOffset = -0.1;
  CHECK_NOTHROW(validate(sensor));
  sensor.rotationPeriod = 0;
  sensor.channels[1].timeOffset = 0.5;
  CHECK_NOTHROW(validate(sensor));
}

TEST_CASE("validate refuses a scan that begins before the one in front of it has ended") {
  Sensor sensor = small();
  sensor.rotationPeriod = 0.1;
  sensor.scanPeriod = 0.1 * (1 - 1e-12);  // as periods are rounded
  CHECK_NOTHROW(validate(sensor));
  const auto mistake = [&](double period) {
    sensor.scanPeriod = period;
    return test::problemOf([&] { validate(sensor); }, ErrorCode::invalidArgument);
  };
  CHECK_THAT(mistake(0.09), ContainsSubstring("scan period must be at least that of a scan, 0.1 s, is 0.09"));
  CHECK_THAT(mistake(-0.1), ContainsSubstring("scan period must be finite and at least 0"));
  sensor = {.name = "list", .rangeMax = 10};
  sensor.patterns.resize(2);
  for (BeamList& list : sensor.patterns) list.directions = {{1, 0, 0}, {0, 1, 0}};
  sensor.patterns[1].times = {0, 0.5};
  CHECK_THAT(mistake(0.4), ContainsSubstring("that of a scan, 0.5 s, is 0.4"));
  sensor.scanPeriod = 0.5;
  CHECK_NOTHROW(validate(sensor));
}

TEST_CASE("the beams of a grid as a list have the origins, times and windows of their channels") {
  Sensor grid = small();  // 4 columns, 2 channels, 10 m
  grid.rotationPeriod = 0.1;
  grid.channels[1].origin = {0.5, 0, 0.25};
  grid.channels[1].timeOffset = 0.01;
  grid.channels[0].rangeMin = 2;
  const BeamList list = beamsOf(grid);
  CHECK((list.size() == 8 && list.width == 4 && list.height == 2));
  CHECK(list.rings == std::vector<uint16_t>{0, 0, 0, 0, 1, 1, 1, 1});
  CHECK(list.rangeMin == std::vector<float>{2, 2, 2, 2, 0, 0, 0, 0});
  CHECK(list.rangeMax.empty());
  REQUIRE((list.times.size() == 8 && list.origins.size() == 8));
  for (size_t beam = 0; beam < 8; ++beam)
    CHECK(std::abs(list.times[beam] - (0.025 * static_cast<double>(beam % 4) + (beam < 4 ? 0 : 0.01))) < 1e-15);
  CHECK((list.origins[0].x == 0 && list.origins[0].z == 0));
  CHECK(std::abs(list.origins[5].y + 0.5) < 1e-15);  // column 1 points to -y
  CHECK(list.origins[5].z == 0.25);
  grid = small();
  grid.channels[1].rangeMax = 7;
  const BeamList plain = beamsOf(grid);
  CHECK((plain.times.empty() && plain.origins.empty() && plain.rangeMin.empty()));
  CHECK(plain.rangeMax == std::vector<float>{10, 10, 10, 10, 7, 7, 7, 7});
}

TEST_CASE("the widest window of a sensor holds those of all its beams, in every pattern") {
  const auto isWindow = [](const Sensor& sensor, double least, double most) {
    const RangeWindow widest = widestWindow(sensor);
    return std::abs(widest.least - least) < 1e-6 && std::abs(widest.most - most) < 1e-6;
  };
  Sensor grid = small();
  grid.rangeMin = 0.5;
  CHECK(isWindow(grid, 0.5, 10));
  grid.channels[0].rangeMin = 0.1;
  grid.channels[1].rangeMax = 70;
  CHECK(isWindow(grid, 0.1, 70));
  for (Channel& channel : grid.channels) channel.rangeMin = 2, channel.rangeMax = 3;
  CHECK(isWindow(grid, 2, 3));
  Sensor list{.name = "list", .rangeMin = 0.5, .rangeMax = 10};
  list.patterns.resize(2);
  for (BeamList& pattern : list.patterns) pattern.directions = {{1, 0, 0}, {0, 1, 0}};
  CHECK(isWindow(list, 0.5, 10));
  list.patterns[1].rangeMax = {4, 30};
  list.patterns[1].rangeMin = {0.25f, 1};
  CHECK(isWindow(list, 0.25, 30));
  list.patterns[0].rangeMax = {3, 5};
  list.patterns[0].rangeMin = {2, 2};
  list.patterns[1].rangeMin = {1, 1};
  CHECK(isWindow(list, 1, 30));
  grid.channels.clear();
  CHECK(isWindow(grid, 0.5, 10));
}

TEST_CASE("bounds of lasers hold their places along the azimuth of their beams, across it, upwards and in all") {
  const auto areBounds = [](const OriginBounds& bounds, double forward, double left, double up, double distance) {
    return std::abs(bounds.forward - forward) < 1e-12 && std::abs(bounds.left - left) < 1e-12 &&
           std::abs(bounds.up - up) < 1e-12 && std::abs(bounds.distance - distance) < 1e-12;
  };
  Sensor list{.name = "list", .rangeMax = 10};
  list.patterns.resize(2);
  list.patterns[0].directions = list.patterns[1].directions = {{0, 1, 0}, {1, 0, 0}, {0.8, 0, 0.6}};
  list.patterns[1].origins = {{0, 0.2, 0.5}, {0, 0.3, 0.4}, {-9, -9, -9}};
  const std::vector<uint32_t> beams = {0, 1};
  CHECK(areBounds(originBoundsOf(list, 0, {}, beams), 0, 0, 0, 0));
  CHECK(areBounds(originBoundsOf(list, 1, {0, 0, 0.5}, beams), 0.2, 0.3, 0.1, std::sqrt(0.1)));
  Sensor grid = small();
  grid.channels[0].origin = {0.1, -0.2, 0.3};
  grid.channels[1].origin = {-0.4, 0, 0.1};
  CHECK(areBounds(originBoundsOf(grid, 0, {0, 0, 0.1}, {}), 0.4, 0.2, 0.2, 0.4));
}

TEST_CASE("a scan needs the poses of its whole turn, and of beams that fire outside of it a column more") {
  const auto isSpan = [](const Sensor& sensor, double from, double to, uint64_t frame = 0) {
    const TimeSpan span = poseTimesOf(sensor, frame);
    return std::abs(span.from - from) < 1e-12 && std::abs(span.to - to) < 1e-12;
  };
  Sensor grid = small();  // 4 columns
  grid.rotationPeriod = 0.1;
  CHECK(isSpan(grid, 0, 0.1));
  grid.channels[0].timeOffset = 0.01;
  grid.channels[1].timeOffset = -0.02;
  CHECK(isSpan(grid, -0.02 - 0.025, 0.1 + 0.01 + 0.025));
  Sensor list{.name = "list", .rangeMax = 10};
  list.patterns.resize(2);
  for (BeamList& pattern : list.patterns) pattern.directions = {{1, 0, 0}, {0, 1, 0}};
  list.patterns[1].times = {0, 0.5};
  CHECK(isSpan(list, 0, 0));
  CHECK(isSpan(list, 0, 0.5, 1));
}

TEST_CASE("a sensor whose range is not set is refused, unless each laser has its own") {
  Sensor sensor = small();
  sensor.rangeMin = sensor.rangeMax = 0;
  CHECK_THROWS_WITH(validate(sensor), ContainsSubstring("range max is 0 m"));
  for (Channel& channel : sensor.channels) channel.rangeMax = 20;
  CHECK_NOTHROW(validate(sensor));
  Sensor list;
  list.name = "list";
  list.patterns.emplace_back();
  list.patterns[0].directions = {{1, 0, 0}};
  CHECK_THROWS_WITH(validate(list), ContainsSubstring("range max is 0 m"));
  list.patterns[0].rangeMax = {5};
  CHECK_NOTHROW(validate(list));
}

TEST_CASE("a sensor is found by its name in any case, and an unknown name lists the nearest ones") {
  CHECK(builtinSensor("hdl-64e").name == "HDL-64E");
  CHECK(codeOf([] { builtinSensor("HDL-65"); }) == ErrorCode::invalidArgument);
  CHECK_THROWS_WITH(builtinSensor("HDL-65"), ContainsSubstring("'HDL-65'; the nearest are HDL-64E, "));
  CHECK(codeOf([] { readSensorFile("/"); }) == ErrorCode::file);
  CHECK(codeOf([] { builtinSensor(""); }) == ErrorCode::invalidArgument);
}
