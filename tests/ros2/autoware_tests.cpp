// SPDX-License-Identifier: Apache-2.0
// Tests of what nodes of Autoware compute with the fields that its drivers state of a return.
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <cstring>
#include <map>

#include "columns.hpp"
#include "gnosphere/gnosphere.hpp"
#include "gnosphere/ros2.hpp"
#include "scan/image_order.hpp"

using namespace gnosphere;
using namespace gnosphere::ros2;
using namespace gnosphere::test;
using Catch::Approx;

namespace {

/// Returns a scan in which every beam of a sensor has a return at 10 m.
Scan scanInside(const Sensor& sensor) {
  const BeamList beams = beamsOf(sensor);
  Scan scan;
  scan.columns = sensor.width();
  scan.channels = sensor.height();
  std::vector<uint16_t> rings;
  for (size_t i = 0; i < beams.size(); ++i) {
    const Vec3& d = beams.directions[i];
    for (const double value : {d.x, d.y, d.z}) scan.points.push_back(static_cast<float>(10 * value));
    rings.push_back(beams.rings.empty() ? static_cast<uint16_t>(i / scan.columns) : beams.rings[i]);
  }
  scan.firstColumnOnLeft = imageOrderOf(sensor).firstColumnOnLeft;
  scan.ranges.assign(beams.size(), 10);
  scan.triangles.assign(beams.size(), 0);
  scan.instances.assign(beams.size(), 0);
  setColumn<float>(scan, Field::time, {beams.times.begin(), beams.times.end()});
  setColumn<uint16_t>(scan, Field::ring, rings);
  return scan;
}

/// A return of a cloud in Autoware's layout.
struct Autoware {
  float x, y, z;
  uint8_t intensity, returnType;
  uint16_t channel;
  float azimuth, elevation, distance;
  uint32_t time;
};
static_assert(sizeof(Autoware) == 32);

std::vector<Autoware> autowareOf(const Scan& scan, const Effects& effects = {}) {
  const PointCloud2 cloud = driverCloudOf(scan, Driver::autoware, "top", 0, effects);
  std::vector<Autoware> points(cloud.width);
  REQUIRE(cloud.data.size() == points.size() * sizeof(Autoware));
  std::memcpy(points.data(), cloud.data.data(), cloud.data.size());
  return points;
}

/// Returns how many steps from a return to the next one of its ring Autoware's filter of outliers takes for less than
/// a degree: the difference of azimuths, with 2 pi more if that is negative.
size_t stepsThatAutowareTakes(const std::vector<Autoware>& points) {
  std::map<uint16_t, float> before;
  size_t steps = 0;
  for (const Autoware& point : points) {
    const auto [last, isFirst] = before.try_emplace(point.channel, point.azimuth);
    float step = point.azimuth - last->second;
    if (step < 0) step += static_cast<float>(2 * M_PI);
    steps += !isFirst && step < M_PI / 180;
    last->second = point.azimuth;
  }
  return steps;
}

/// A head of two channels and 720 columns, which sweeps so many degrees.
Sensor headThatSweeps(double degrees) {
  Sensor sensor;
  sensor.columns = 720;
  sensor.channels = {{-10, 0}, {10, 2.5}};
  sensor.rangeMax = 100;
  sensor.rotationPeriod = 0.1;
  sensor.azimuthStartDeg = 30;
  sensor.azimuthSpanDeg = degrees;
  return sensor;
}

}  // namespace

TEST_CASE("ROS 2: Autoware's azimuths grow as the head turns") {
  for (const double degrees : {-360, 360, -90, 90}) {
    CAPTURE(degrees);
    const Sensor sensor = headThatSweeps(degrees);
    const std::vector<Autoware> points = autowareOf(scanInside(sensor));
    REQUIRE(points.size() == 1440);
    CHECK(stepsThatAutowareTakes(points) == 2 * 719);
    for (const Autoware& point : points) {
      const double azimuth =
          degrees < 0 ? -point.azimuth : point.azimuth;  // from +x, towards +y if it is greater than 0
      CHECK(point.azimuth >= 0);
      CHECK(point.azimuth < 2 * M_PI);
      REQUIRE(std::abs(10 * std::cos(point.elevation) * std::cos(azimuth) - point.x) < 1e-4);
      REQUIRE(std::abs(10 * std::cos(point.elevation) * std::sin(azimuth) - point.y) < 1e-4);
    }
  }
}

TEST_CASE("ROS 2: Autoware's azimuths of heads of the catalogue") {
  for (const char* name : {"Puck", "OS1-32", "PandarXT-32", "RS-Helios-32"}) {
    CAPTURE(name);
    const std::vector<Autoware> points = autowareOf(scanInside(builtinSensor(name)));
    CHECK(static_cast<double>(stepsThatAutowareTakes(points)) > 0.98 * static_cast<double>(points.size()));
  }
  // A head that does not turn: counter-clockwise from +x.
  for (const Autoware& point : autowareOf(scanInside(builtinSensor("Avia")))) {
    const double azimuth = std::atan2(point.y, point.x);
    REQUIRE(point.azimuth == Approx(azimuth < 0 ? azimuth + 2 * M_PI : azimuth));
  }
}

TEST_CASE("ROS 2: Autoware's azimuths have one sense, however few beams have a return") {
  const Sensor sensor = headThatSweeps(-360);
  Scan scan = scanInside(sensor);
  for (size_t beam = 1; beam < scan.beamCount(); ++beam) scan.ranges[beam] = std::nanf("");
  const std::vector<Autoware> points = autowareOf(scan);
  REQUIRE(points.size() == 1);
  CHECK(points[0].azimuth == Approx((360 - 30) * M_PI / 180));
}

TEST_CASE("ROS 2: Autoware's azimuth is less than a turn, and its distance is that from the origin of the head") {
  Scan scan = scanInside(headThatSweeps(360));
  scan.points[0] = 5;
  scan.points[1] = -6.6e-16f;
  scan.points[2] = 12;
  scan.ranges[0] = 12.5;  // from where the beam begins
  const std::vector<Autoware> points = autowareOf(scan);
  CHECK(points[0].azimuth == 0);
  CHECK(points[0].distance == Approx(13));
}

TEST_CASE("ROS 2: Autoware's types of the returns of a pair") {
  using Mode = Effects::Returns::Mode;
  using Scale = Effects::Intensity::Scale;
  Scan scan = scanInside(headThatSweeps(360));
  scan.columns = 1;
  scan.channels = 2;
  scan.returns = 2;
  // Beam 0 has a pair; the power of a return is its intensity by the square of its range. Beam 1 has one return.
  const auto typesOf = [&](Mode mode, Scale scale, float nearIntensity, float farIntensity) {
    scan.ranges = {10, 20, 10, std::nanf("")};
    scan.points = {10, 0, 0, 20, 0, 0, 10, 0, 0, 0, 0, 0};
    for (auto* indices : {&scan.triangles, &scan.instances}) indices->assign(4, 0);
    setColumn<float>(scan, Field::time, {0, 0, 0, 0});
    setColumn<uint16_t>(scan, Field::ring, {0, 0, 1, 1});
    setColumn<uint8_t>(scan, Field::returnNumber, {1, 2, 1, 0});
    setColumn<uint8_t>(scan, Field::returnCount, {2, 2, 1, 1});
    setColumn<float>(scan, Field::intensity, {nearIntensity, farIntensity, 0.5f, 0});
    Effects effects;
    effects.returns.mode = mode;
    effects.intensity.scale = scale;
    std::vector<int> types;
    for (const Autoware& point : autowareOf(scan, effects)) types.push_back(point.returnType);
    return types;
  };
  const std::vector<int> nearer = {3, 6, 7}, farther = {5, 4, 7};  // strongest first and weak last, or the reverse
  for (const Mode mode : {Mode::dual, Mode::strongestSecondStrongest}) {
    CHECK(typesOf(mode, Scale::unit, 0.2f, 0.7f) == nearer);
    CHECK(typesOf(mode, Scale::unit, 0.2f, 0.9f) == farther);
    CHECK(typesOf(mode, Scale::byte, 60, 110) == nearer);  // 110 is a gain of 1.56
    CHECK(typesOf(mode, Scale::byte, 30, 110) == farther);
    CHECK(typesOf(mode, Scale::raw, 0.2f, 0.3f) == farther);
  }
  CHECK(typesOf(Mode::lastStrongest, Scale::unit, 0.1f, 0.9f) == nearer);  // the mode tells, not the powers
  CHECK(typesOf(Mode::firstStrongest, Scale::unit, 0.9f, 0.1f) == farther);
}

TEST_CASE("ROS 2: Autoware's type of a return") {
  const Scan scan = scanInside(headThatSweeps(360));
  const auto typeWith = [&](EffectUse use, Effects::Returns::Mode mode, uint32_t count = 0) {
    Effects effects;
    effects.returns.use = use;
    effects.returns.mode = mode;
    effects.returns.count = count;
    return autowareOf(scan, effects)[0].returnType;
  };
  using Mode = Effects::Returns::Mode;
  CHECK(typeWith(EffectUse::automatic, Mode::all) == 1);  // a beam without the effect returns its strongest echo
  CHECK(typeWith(EffectUse::off, Mode::last, 3) == 1);
  CHECK(typeWith(EffectUse::automatic, Mode::all, 1) == 0);  // the nearest one
  CHECK(typeWith(EffectUse::on, Mode::all) == 0);
  CHECK(typeWith(EffectUse::automatic, Mode::first) == 0);
  CHECK(typeWith(EffectUse::automatic, Mode::strongest) == 1);
  CHECK(typeWith(EffectUse::automatic, Mode::last) == 2);
  Scan two = scan;
  two.returns = 2;
  for (auto* indices : {&two.triangles, &two.instances}) indices->insert(indices->end(), scan.ranges.size(), 0);
  two.ranges.insert(two.ranges.end(), scan.ranges.begin(), scan.ranges.end());
  two.points.insert(two.points.end(), scan.points.begin(), scan.points.end());
  setColumn<float>(two, Field::time, std::vector<float>(two.ranges.size()));
  setColumn<uint16_t>(two, Field::ring, std::vector<uint16_t>(two.ranges.size()));
  setColumn<uint8_t>(two, Field::returnNumber, std::vector<uint8_t>(two.ranges.size(), 1));
  CHECK(autowareOf(two)[0].returnType == 0);
}
