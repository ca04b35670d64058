// SPDX-License-Identifier: Apache-2.0
// Scans while the sensor and instances move.
#include <catch2/matchers/catch_matchers_exception.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>

#include "deformable.hpp"
#include "effects/moving_room.hpp"
#include "lists/list_sensors.hpp"
#include "town/town.hpp"

namespace gnosphere::test {
namespace {

/// Metres of a line inside a box, up to a range.
double lengthWithin(const Effects::Volume& box, const Vec3& from, const Vec3& d, double range) {
  double first = 0, last = range;
  const auto clip = [&](double at, double speed, double low, double high) {
    first = std::max(first, std::min((low - at) / speed, (high - at) / speed));
    last = std::min(last, std::max((low - at) / speed, (high - at) / speed));
  };
  clip(from.x, d.x, box.min.x, box.max.x);
  clip(from.y, d.y, box.min.y, box.max.y);
  clip(from.z, d.z, box.min.z, box.max.z);
  return std::max(last - first, 0.0);
}

/// Scans through dust, or without it if `dust` is false, and returns relative powers.
Scan dusty(const std::string& device, const Sensor& sensor, const Shot& shot, const Effects::Volume& box, bool dust) {
  TestOptions options = optionsOn(device);
  options.effects = Effects::none();
  options.effects.intensity.use = options.effects.sensorMotion.use = EffectUse::automatic;
  options.effects.intensity.scale = Effects::Intensity::Scale::raw;
  options.effects.volumes = {dust ? EffectUse::on : EffectUse::off, {box}};
  options.fields = {Field::intensity, Field::label};
  return scanOn(room(), sensor, shot, options);
}

const Effects::Volume kDust = {{3, -6, -1}, {9, 8, 4}, 0.01};

}  // namespace

TEST_CASE("every column is seen from the sensor's position when it fires") {
  const std::string device = ON_EVERY_DEVICE;
  const bool deskew = GENERATE(false, true);
  const Sensor sensor = spinning();
  const Scan scan = scanned(device, room(), sensor, driving(), deskew);
  for (size_t i = 0; i < scan.beamCount(); ++i) {
    const double time = timeOfColumn(sensor, i);
    const Vec3 own = sensor.direction(i), d = turned(kTurn * time, own), from = {kSpeed * time, 0, 0};
    const double range = toWalls(from, d);
    REQUIRE(scan.ranges[i] == Approx(range).epsilon(1e-5));
    const Vec3 point = deskew ? Vec3{from.x + range * d.x, from.y + range * d.y, from.z + range * d.z}
                              : Vec3{range * own.x, range * own.y, range * own.z};
    CHECK(scan.points[3 * i] == Approx(point.x).margin(1e-3));
    CHECK(scan.points[3 * i + 1] == Approx(point.y).margin(1e-3));
    CHECK(scan.points[3 * i + 2] == Approx(point.z).margin(1e-3));
    // Normals are in the frame of the points, too. At an edge of the room that of either wall will do.
    const Vec3 place = {from.x + range * d.x, from.y + range * d.y, from.z + range * d.z};
    const double gaps[] = {20 - std::abs(place.x), 30 - std::abs(place.y), 15 - std::abs(place.z)};
    if (std::ranges::count_if(gaps, [](double gap) { return gap < 1e-3; }) == 1) {
      const auto part = [&](size_t axis, double at) { return gaps[axis] < 1e-3 ? -std::copysign(1.0, at) : 0; };
      const Vec3 inward = {part(0, place.x), part(1, place.y), part(2, place.z)};
      const Vec3 normal = deskew ? inward : turned(-kTurn * time, inward);
      CHECK(scan.column<float>(Field::normal, 0)[i] == Approx(normal.x).margin(1e-5));
      CHECK(scan.column<float>(Field::normal, 1)[i] == Approx(normal.y).margin(1e-5));
      CHECK(scan.column<float>(Field::normal, 2)[i] == Approx(normal.z).margin(1e-5));
    }
    // The walls are still, so radial speeds come from the sensor's velocity, and not from its rotation.
    CHECK(scan.column<float>(Field::radialSpeed)[i] == Approx(-kSpeed * d.x).margin(1e-3));
  }
}

TEST_CASE("a scan of a moving sensor is skewed, unless it is deskewed") {
  const std::string device = ON_EVERY_DEVICE;
  const auto isSkewed = [&](const Shot& shot, bool deskew) {
    return scanned(device, room(), spinning(), shot, deskew).skewed;
  };
  CHECK(isSkewed(driving(), false));
  CHECK(!isSkewed(driving(), true));
  Shot standing = driving();
  for (SensorMotion::Stamp& stamp : standing.motion.stamps) stamp.pose = standing.pose;
  CHECK(!isSkewed(standing, false));
}

TEST_CASE("a simulator tells once of each motion that a sensor leaves out") {
  std::vector<std::string> warnings;
  TestOptions options = optionsOn("reference");
  options.warn = [&](const std::string& warning) { warnings.push_back(warning); };
  Sensor atOnce = spinning();
  atOnce.rotationPeriod = 0;
  std::vector<Field> fields;
  const auto scan = [&](const Effects& effects) {
    warnings.clear();
    Simulator simulator(room(), {atOnce, effects, fields}, options);
    Shot passing;
    passing.instanceMotions = {{0, translation(1, 0, 0)}};
    for (const Shot& shot : {driving(), driving(), passing, passing}) {
      Scan result;
      simulator.scanInto(shot, result);
    }
    return warnings;
  };
  const auto leftOut = [&](const char* motion) {
    return "sensor '" + atOnce.name + "': " + motion +
           " is left out, although a shot brings it: the sensor fires all beams at once";
  };
  CHECK(scan(Effects()) == std::vector<std::string>{leftOut("sensor-motion"), leftOut("object-motion")});
  CHECK(scan(Effects::none()).empty());
  for (const Field field : {Field::radialSpeed, Field::velocity}) {
    fields = {field};
    CHECK(scan(Effects()) ==
          std::vector<std::string>{leftOut("object-motion") +
                                   ", so radial_speed and velocity have no speeds of what moves in the scene"});
  }
}

TEST_CASE("a shot with two motions of one instance or mesh is refused") {
  Scene scene = room();
  scene.instances.push_back({"", 0, translation(3, 0, 0)});
  scene.instances.push_back({"", 0, translation(6, 0, 0)});
  Simulator simulator(scene, {spinning(), Effects()}, optionsOn("reference"));
  const auto scan = [&](std::vector<size_t> moved) {
    Shot shot;
    for (const size_t instance : moved) shot.instanceMotions.push_back({instance, translation(1, 0, 0)});
    Scan result;
    simulator.scanInto(shot, result);
  };
  CHECK_NOTHROW(scan({0, 1, 2}));
  CHECK_NOTHROW(scan({2, 0, 1}));
  CHECK_THROWS_WITH(scan({1, 1}), Catch::Matchers::ContainsSubstring("instance 1 has two motions"));
  CHECK_THROWS_WITH(scan({2, 0, 2}), Catch::Matchers::ContainsSubstring("instance 2 has two motions"));
}

TEST_CASE("a simulator tells of a sensor without beams") {
  std::vector<std::string> warnings;
  TestOptions options = optionsOn("reference");
  options.warn = [&](const std::string& warning) { warnings.push_back(warning); };
  Sensor blind = spinning();
  blind.name = "blind";
  blind.channels.clear();
  Simulator simulator(room(), {spinning(), Effects()}, options);
  CHECK(warnings.empty());
  simulator.addSensor({blind, Effects()});
  CHECK(warnings == std::vector<std::string>{"sensor 'blind' has no channels, so its scans have no beams"});
}

TEST_CASE("a new simulator names the instances that are sheared beyond the error bounds") {
  std::vector<std::string> warnings;
  TestOptions options = optionsOn("reference");
  options.warn = [&](const std::string& warning) { warnings.push_back(warning); };
  Scene scene = room();
  const auto add = [&](const char* name, const Transform& transform) {
    scene.instances.push_back({name, 0, transform});
    warnings.clear();
    makeSimulator(scene, spinning(), options);
  };
  const auto sheared = [](double height) { return Transform{{1, 1, 0, 0, 0, height, 0, 0, 0, 0, 1, 0}}; };
  add("", scaling(1e-5, 1, -1e5));
  CHECK(warnings.empty());
  add("slight", sheared(1e-2));
  CHECK(warnings.empty());
  add("", sheared(1e-4));
  REQUIRE(warnings.size() == 1);
  CHECK(warnings[0] ==
        "instance 3 is sheared so strongly that the error bounds of the accuracies do not hold; see docs/limits.md");
  scene.instances[3].name = "steep";
  add("", sheared(1e-6));
  REQUIRE(warnings.size() == 1);
  CHECK(warnings[0].find("instance 3 'steep' and 1 more are sheared") == 0);
}

TEST_CASE("dust stays in place while the sensor moves and turns") {
  const std::string device = ON_EVERY_DEVICE;
  const bool lasersAside = GENERATE(false, true);
  Sensor sensor = spinning();
  if (lasersAside)
    for (Channel& channel : sensor.channels) channel.origin = {0.4, -0.3, 0.5};
  const Shot shot = driving();
  const Scan through = dusty(device, sensor, shot, kDust, true), clear = dusty(device, sensor, shot, kDust, false);
  size_t solid = 0, within = 0;
  for (size_t i = 0; i < through.beamCount(); ++i) {
    if (through.column<uint8_t>(Field::label)[i] != uint8_t(Label::solid)) continue;
    ++solid;
    const double time = timeOfColumn(sensor, i),
                 azimuth = 2 * M_PI * double(i % sensor.columns) / sensor.columns - M_PI;
    const Vec3 laser = turned(kTurn * time + azimuth, sensor.channels[i / sensor.columns].origin);
    const Vec3 from = {kSpeed * time + laser.x, laser.y, laser.z}, d = turned(kTurn * time, sensor.direction(i));
    const double length = lengthWithin(kDust, from, d, through.ranges[i]);
    within += length > 0;
    INFO("beam " << i);
    REQUIRE(through.column<float>(Field::intensity)[i] / clear.column<float>(Field::intensity)[i] ==
            Approx(std::exp(-2 * kDust.extinction * length)).epsilon(2e-5));
  }
  CHECK(solid > through.beamCount() / 2);
  CHECK(within > 100);
}

TEST_CASE("the length of a pose's quaternion has no influence, also on dust") {
  const std::string device = ON_EVERY_DEVICE;
  Shot shot, longer;
  shot.pose.orientation = {0.1, -0.2, 0.3, std::sqrt(0.86)};
  const Quaternion& q = shot.pose.orientation;
  const Scan first = dusty(device, spinning(), shot, kDust, true);
  for (const double s : {std::sqrt(2.0), 1e-7, 1e160, 1e308, 1e-300}) {
    INFO("times " << s);
    longer.pose.orientation = {s * q.x, s * q.y, s * q.z, s * q.w};
    const Scan second = dusty(device, spinning(), longer, kDust, true);
    CHECK(valuesOf<uint8_t>(first, Field::label) == valuesOf<uint8_t>(second, Field::label));
    for (size_t i = 0; i < first.beamCount(); ++i)
      REQUIRE(first.column<float>(Field::intensity)[i] ==
              Approx(second.column<float>(Field::intensity)[i]).epsilon(1e-5));
  }
}

TEST_CASE("channels that fire later see the world later, from the origin of their laser") {
  const std::string device = ON_EVERY_DEVICE;
  Sensor sensor = gridSensor(360, 2, 0, 0, 100);
  sensor.rotationPeriod = kPeriod;
  const double offset = 1e-3;
  sensor.channels[1].timeOffset = offset;
  sensor.channels[1].origin = {0.1, 0, 0.05};
  const Scan scan = scanned(device, room(), sensor, driving());
  const size_t late = 360 + 180;
  const double time = kPeriod / 2 + offset, angle = kTurn * time;
  const Vec3 d = turned(angle, {1, 0, 0});
  const double range = toWalls({kSpeed * time + 0.1 * d.x, 0.1 * d.y, 0.05}, d);
  CHECK(scan.ranges[late] == Approx(range).epsilon(1e-5));
  CHECK(scan.points[3 * late] == Approx(range + 0.1).epsilon(1e-5));
  CHECK(scan.points[3 * late + 2] == Approx(0.05).epsilon(1e-4));
}

TEST_CASE("channels that fire in turn see the world at their own times, although all columns fire at once") {
  const std::string device = ON_EVERY_DEVICE;
  Sensor sensor = gridSensor(360, 5, -20, 20, 100);
  for (size_t i = 0; i < 5; ++i) sensor.channels[i].timeOffset = 0.02 * static_cast<double>(i);
  const Scan scan = scanned(device, room(), sensor, driving());
  for (size_t i = 0; i < scan.beamCount(); ++i) {
    const double time = 0.02 * static_cast<double>(i / 360);
    const Vec3 d = turned(kTurn * time, sensor.direction(i));
    REQUIRE(scan.ranges[i] == Approx(toWalls({kSpeed * time, 0, 0}, d)).epsilon(1e-5));
    CHECK(scan.column<float>(Field::radialSpeed)[i] == Approx(-kSpeed * d.x).margin(1e-3));
  }
  Shot later = driving();  // a motion that begins after the first channels have fired
  for (SensorMotion::Stamp& stamp : later.motion.stamps) stamp.time += 0.05;
  CHECK_NOTHROW(scanned(device, room(), sensor, later));
}

TEST_CASE("things stand still in a scan of a list whose beams all fire at its start") {
  const std::string device = ON_EVERY_DEVICE;
  BeamList ahead;
  ahead.directions = {{1, 0, 0}};
  Sensor sensor = listSensor("two", ahead);
  sensor.patterns.push_back(sensor.patterns[0]);
  sensor.patterns[1].times = {0.1};
  Shot shot;
  shot.instanceMotions = {{0, translation(4, 0, 0)}};
  for (const double range : {12, 16}) {
    const Scan scan = scanned(device, sceneOf(plate(12, 1)), sensor, shot);
    REQUIRE(scan.hit(0));
    CHECK(scan.ranges[0] == Approx(range).epsilon(1e-5));
    const double speed = shot.frame == 0 ? 0 : 40;
    CHECK(scan.column<float>(Field::velocity)[0] == Approx(speed).epsilon(1e-4));
    CHECK(scan.column<float>(Field::radialSpeed)[0] == Approx(speed).epsilon(1e-4));
    ++shot.frame;
  }
}

TEST_CASE("a drive through a town with traffic equals the reference") {
  needVulkan();
  const bool deskew = GENERATE(false, true);
  const Scene scene = makeTown({.triangles = 20'000});
  Sensor sensor = builtinSensor("VLP-16");
  sensor.columns = 180;
  sensor.rotationPeriod = kPeriod;
  for (Channel& channel : sensor.channels) channel.origin = {0.04, 0.01, 0.02};
  const Vec3 low = {1.3, 0.4, 1.8}, high = {2.9, 0.6, 1.85};
  Shot shot;
  shot.pose = {low, yaw(0.6)};
  shot.motion.stamps = {{0, shot.pose}, {kPeriod, {high, yaw(0.9)}}};
  for (size_t i = 0; i < scene.instances.size(); i += 3)
    shot.instanceMotions.push_back({i, translation(0.8, -0.3, 0.02) * scene.instances[i].transform});
  const Scan reference = scanned("reference", scene, sensor, shot, deskew);
  const Scan other = scanned("vulkan", scene, sensor, shot, deskew);
  const Differences found = differences(reference, other, {1e-4, 5e-4, 2e-3});
  INFO(found.text());
  CHECK(reference.counters.hits > 1000);
  CHECK(found.ties < found.beams / 50);
  CHECK(found.all() <= found.beams / 500);
}

// A pane behind a fence is visible over it only from the sensor's position when it fires; from the position in the
// middle of the scan, the fence hides it. So the pane is seen in other rows than it has from there.
TEST_CASE("culling hidden geometry hides nothing from a moving sensor") {
  needVulkan();
  Sensor sensor = gridSensor(1440, 256, -14, 40, 60);
  sensor.rotationPeriod = kPeriod;
  TestOptions options = vulkanOptions();
  options.effects = Effects::none();
  options.effects.sensorMotion.use = EffectUse::on;
  Shot shot;
  shot.pose = {{0, 0, -0.8}, {}};
  shot.motion.stamps = {{0, shot.pose}, {kPeriod, {{0, 0, 0.8}, {}}}};
  const auto boxOf = [](const Vec3& low, const Vec3& high) {
    MeshBuilder builder;
    builder.box(low, high, 8);
    return builder.take();
  };
  const auto heightAt = [](double distance, double degrees) {
    return distance * std::tan(degrees * std::numbers::pi / 180);
  };
  constexpr uint32_t kLifts = 6;
  Scene scene;
  scene.materials.push_back(material(true));
  for (uint32_t i = 0; i < kLifts; ++i) {
    const double lift = 0.15 * i - 0.4;  // relative to the tiles of the table of farthest ranges
    scene.meshes.push_back(boxOf({-15.1, -8, -3}, {-15, 8, heightAt(15, 3.9 + lift) - 0.8}));
    scene.meshes.push_back(boxOf({-0.05, -1, heightAt(25, 2.2 + lift)}, {0.05, 1, heightAt(25, 2.9 + lift)}));
  }
  options.tuning.culling.occlusion = Culling::Occlusion::never;
  Simulator without = makeSimulator(scene, sensor, options);
  options.tuning.culling.occlusion = Culling::Occlusion::always;
  Simulator with = makeSimulator(scene, sensor, options);
  uint64_t seen = 0;
  for (uint32_t i = 0; i < kLifts; ++i) {
    INFO("lifted " << i);
    Scan expected, scan;
    for (Simulator* simulator : {&without, &with}) {
      REQUIRE(simulator->addInstance(2 * i, {}) == 0);
      // At the azimuth where the sensor's columns begin, 8 degrees from straight behind it.
      const Transform behind = rotationZ((180 + 8) * std::numbers::pi / 180) * translation(25, 0, 0);
      REQUIRE(simulator->addInstance(2 * i + 1, behind) == 1);
      simulator->scanInto(shot, simulator == &with ? scan : expected);
      for (size_t instance : {1, 0}) simulator->removeInstance(instance);
    }
    CHECK(sameBytes(expected, scan));
    for (uint32_t instance : expected.instances) seen += instance == 1;
  }
  CHECK(seen > 50);
}

TEST_CASE("an instance that is flat or a line at the start of a scan turns and grows within it") {
  const std::string device = ON_EVERY_DEVICE;
  const bool deforms = GENERATE(false, true);
  INFO(device << ", beside a mesh that deforms: " << deforms);
  Scene scene;
  scene.materials.emplace_back();
  scene.meshes.emplace_back();
  scene.meshes[0].indices = {0, 1, 2, 0, 2, 3};
  scene.meshes[0].parts = {{0, 2, 0}};
  scene.instances = {{"", 0, {}}};
  if (deforms) {
    Random random(1);
    scene.meshes.push_back(limb(random, 2, 1, 0));
    scene.instances.push_back({"", 1, translation(0, 500, 0)});
  }
  BeamList beams;
  Shot shot;
  std::vector<double> expected;  // NaN for no hit
  const double none = std::nan("");
  SECTION("a decal without thickness turns by 90 degrees") {
    scene.meshes[0].positions = {0, -5, -5, 0, 5, -5, 0, 5, 5, 0, -5, 5};
    scene.instances[0].transform.rows = {0, 0, 0, 10, 0, 1, 0, 2, 0, 0, 1, 0};
    shot.instanceMotions = {{0, {{0, -1, 0, 10, 0, 0, 0, 2, 0, 0, 1, 0}}}};
    for (int i = 0; i < 9; ++i) {
      const double part = 0.1 * i, v = -2 / (1 - part);  // where y = 2 + (1 - part) v is 0
      beams.directions.push_back({1, 0, 0});
      expected.push_back(v < -5 ? none : 10 - part * v);
    }
    expected[6] = none;  // v is -5: the beam passes the edge
  }
  SECTION("a wall pops up") {
    scene.meshes[0].positions = {0, -5, 0, 0, 5, 0, 0, 5, 4, 0, -5, 4};
    scene.instances[0].transform.rows = {1, 0, 0, 10, 0, 1, 0, 0, 0, 0, 0, 0};
    shot.instanceMotions = {{0, translation(10, 0, 0)}};
    for (int i = 0; i < 9; ++i) {
      beams.directions.push_back({10 / std::hypot(10.0, 1.0), 0, 1 / std::hypot(10.0, 1.0)});
      expected.push_back(4 * 0.1 * i < 1 ? none : std::hypot(10.0, 1.0));
    }
  }
  for (size_t i = 0; i < expected.size(); ++i) beams.times.push_back(0.01 * double(i));
  Sensor sensor = listSensor("beams", beams, 50);
  sensor.rotationPeriod = kPeriod;
  const Scan scan = scanned(device, scene, sensor, shot);
  for (size_t i = 0; i < expected.size(); ++i) {
    INFO("beam " << i);
    if (std::isnan(expected[i])) {
      if (i != 6) CHECK_FALSE(scan.hit(i));
      continue;
    }
    REQUIRE(scan.hit(i));
    CHECK(scan.ranges[i] == Approx(expected[i]).epsilon(1e-5));
  }
}

// In the middle of the scan, or at its start, the sensor is behind each of these one-sided walls, whose back it does
// not see.
TEST_CASE("the front of a wall is seen if motion brings it to the sensor") {
  needVulkan();
  const Sensor sensor = spinning();
  const auto wall = [](const Vec3& from, const Vec3& along, const Vec3& up) {
    MeshBuilder builder;
    builder.quad(from, along, up, 24);
    return sceneOf(builder.take(), false);
  };
  Scene scene;
  Shot shot;
  SECTION("the sensor passes it") {
    scene = wall({0.3, -6, -3}, {0, 12, 0}, {0, 0, 6});
    shot.pose = {{-1, 0, 0}, {}};
    shot.motion.stamps = {{0, shot.pose}, {kPeriod, {{1, 0, 0}, {}}}};
  }
  SECTION("it passes the sensor") {
    scene = wall({1, -6, -3}, {0, 12, 0}, {0, 0, 6});
    shot.instanceMotions = {{0, translation(-2, 0, 0)}};
  }
  SECTION("it turns around") {
    scene = wall({-1, 6, -3}, {2, 0, 0}, {0, 0, 6});
    const auto turnedBy = [](double angle) { return translation(0, 6, 0) * rotationZ(angle) * translation(0, -6, 0); };
    scene.instances[0].transform = turnedBy(1.9);
    shot.instanceMotions = {{0, turnedBy(0.2)}};
  }
  const Scan expected = scanned("reference", scene, sensor, shot), scan = scanned("vulkan", scene, sensor, shot);
  size_t differ = 0;
  for (size_t i = 0; i < scan.beamCount(); ++i) differ += expected.hit(i) != scan.hit(i);
  CHECK(expected.counters.hits > 30);
  CHECK(differ <= 2);
}

// The motion of an instance is known for the turn of the head. Lasers that fire outside of it see the instance farther
// on the same way, and here in range, where it is not during the turn.
TEST_CASE("instances move on for lasers that fire long before and after the turn") {
  struct Case {
    double timeOffset, end;  // of the laser, and where the plate is at the end of the turn
  };
  for (const auto& [timeOffset, end] : {Case{0.1, 8}, {-0.1, 24}}) {
    INFO("fired " << timeOffset << " s later");
    Scene scene = sceneOf(plate(12, 1));
    Sensor sensor = gridSensor(360, 1, 0, 0, 6.5);
    sensor.rotationPeriod = 0.1;
    sensor.channels[0].timeOffset = timeOffset;
    TestOptions options = optionsOn("vulkan");
    options.effects = Effects::none();
    options.effects.objectMotion.use = EffectUse::on;
    Shot shot;
    shot.instanceMotions = {{0, translation(end - 12, 0, 0)}};
    const Scan scan = scanOn(scene, sensor, shot, options);
    REQUIRE(scan.hit(180));
    CHECK(std::abs(scan.ranges[180] - 6) < 1e-3);
    shot.instanceMotions.clear();
    CHECK(scanOn(scene, sensor, shot, options).counters.hits == 0);
  }
}

TEST_CASE("a motion that ends when the scan starts is a sensor that stands, and one of another clock is refused") {
  const Scene scene = room();
  const auto after = [&](double first, double last) {
    Shot shot;
    shot.motion.stamps = {{first, {{-1, 0, 0}, {}}}, {last, {}}};
    return shot;
  };
  const Scan standing = scanned("reference", scene, spinning(), {});
  CHECK(sameBytes(scanned("reference", scene, spinning(), after(-1, 0)), standing));
  for (const auto& [first, last] : {std::pair(-1.0, -0.5), std::pair(1000.0, 1001.0)})
    CHECK_THROWS_WITH(scanned("reference", scene, spinning(), after(first, last)),
                      Catch::Matchers::ContainsSubstring("stamps count from the start of the scan"));
}

}  // namespace gnosphere::test
