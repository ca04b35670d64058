// SPDX-License-Identifier: Apache-2.0
// Sensors as JSON: every property comes back, and files with mistakes are refused.
#include <algorithm>
#include <bit>
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

#include "gnosphere/error.hpp"
#include "gnosphere/sensor.hpp"
#include "problem.hpp"
#include "sensor/small_sensor.hpp"

using namespace gnosphere;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::EndsWith;
using gnosphere::test::small;

namespace {

uint64_t bits(double value) {
  return std::bit_cast<uint64_t>(value);
}

std::string problemOf(const std::string& json) {
  return test::problemOf([&] { sensorFromJson(json, "test.json"); }, ErrorCode::format);
}

}  // namespace

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
