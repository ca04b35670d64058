// SPDX-License-Identifier: Apache-2.0
// Sensors: their beams, and which of them are refused.
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
#include "sensor/small_sensor.hpp"

using namespace gnosphere;
using Catch::Matchers::ContainsSubstring;
using gnosphere::test::small;

namespace {

ErrorCode codeOf(const auto& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.code();
  }
  FAIL("no Error was thrown");
  return {};
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
