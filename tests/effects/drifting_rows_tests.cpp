// SPDX-License-Identifier: Apache-2.0
// Heads whose rows fire at different times, from a sensor that moves. With slabs, stage project tries the beams that a
// row sees within the silhouette of a triangle, which drifts from row to row. The other way of binning tries all beams
// of a triangle's box, so both must find the same hits.
#include <catch2/catch_approx.hpp>
#include <glm/glm.hpp>

#include "effects/motion_tables.hpp"
#include "effects/scan_support.hpp"
#include "effects/sensor_plan.hpp"
#include "lists/list_sensors.hpp"
#include "sensor/beams.hpp"
#include "town/town.hpp"

namespace gnosphere::test {
namespace {

/// A motion from (1.3, 0.4, 1.8) on in `pieces` straight pieces, whose velocities differ by up to `jitter` m/s.
SensorMotion driving(double speed, double turn, int pieces, double jitter = 0) {
  Random random(7);
  SensorMotion motion;
  Vec3 place = {1.3, 0.4, 1.8};
  const double step = kPeriod / pieces;
  for (int i = 0; i <= pieces; ++i) {
    const double angle = turn * step * i;
    motion.stamps.push_back({step * i, {place, yaw(angle)}});
    place.x += step * (speed * std::cos(angle) + jitter * random());
    place.y += step * (speed * std::sin(angle) + jitter * random());
    place.z += step * jitter * random();
  }
  return motion;
}

/// A motion that climbs by 10 m/s while the sensor pitches and rolls by 2 rad/s.
SensorMotion climbing() {
  SensorMotion motion;
  for (int i = 0; i <= 4; ++i) {
    const double time = kPeriod * i / 4, s = std::sin(time);
    motion.stamps.push_back({time, {{1.3, 0.4, 1.8 + 10 * time}, {0.6 * s, 0.8 * s, 0, std::cos(time)}}});
  }
  return motion;
}

/// Many lasers that look up to 20 degrees beside each other, and up to 50 degrees up or down.
Sensor spread() {
  Sensor sensor = gridSensor(900, 24, -50, 50, 100);
  sensor.name = "spread";
  sensor.rotationPeriod = kPeriod;
  for (size_t j = 0; j < sensor.channels.size(); ++j) {
    sensor.channels[j].azimuthOffsetDeg = 7.3 * static_cast<double>(j % 6) - 18;
    sensor.channels[j].timeOffset = 3e-6 * static_cast<double>(j);
    sensor.channels[j].origin = {0.03, 0.01, 0.002 * static_cast<double>(j)};
  }
  return sensor;
}

/// Returns small triangles in every direction, the nearest ones a metre away.
Scene confetti() {
  Random random(3);
  MeshBuilder builder;
  for (int i = 0; i < 6'000; ++i) {
    const Vec3 d = anyDirection(random);
    const double range = 5 + 4 * random(), size = 0.05 * range;
    const auto corner = [&] {
      return Vec3{1.3 + range * d.x + size * random(), 0.4 + range * d.y + size * random(),
                  1.8 + range * d.z + size * random()};
    };
    builder.triangle(corner(), corner(), corner());
  }
  return sceneOf(builder.take());
}

}  // namespace

TEST_CASE("rows that fire at different times find the same hits, whether silhouettes drift or all beams are tried",
          "[combinations]") {
  needVulkan();
  std::vector<Sensor> heads = {builtinSensor("Pandar64"), spread()};
  if (!everyCombination()) heads[0].columns /= 3;
  const std::vector<SensorMotion> motions = {driving(15, 0.5, 1), driving(30, -3, 8), driving(20, 1, 40, 2),
                                             driving(3, 0.1, 400, 5), climbing()};
  TestOptions slabs = vulkanOptions();
  slabs.effects.sensorMotion.use = slabs.effects.objectMotion.use = EffectUse::on;
  slabs.tuning.binning = Binning::slabs;
  TestOptions nearest = slabs, reference = slabs;
  nearest.tuning.binning = Binning::nearest;
  reference.device = DeviceChoice::Kind::reference;
  for (const Scene& scene : {makeTown({.triangles = 20'000}), confetti()}) {
    Simulator drifting = makeSimulator(scene, heads, slabs), all = makeSimulator(scene, heads, nearest),
              truth = makeSimulator(scene, heads, reference);
    for (size_t sensor = 0; sensor < heads.size(); ++sensor)
      for (size_t i = 0; i < motions.size(); ++i) {
        if (sensor == 0 && i % 2 != 0 && !everyCombination()) continue;  // the larger head has three of the motions
        INFO(scene.instances.size() << " instances, " << heads[sensor].name << ", motion " << i);
        Shot shot;
        shot.sensor = sensor;
        shot.motion = motions[i];
        for (size_t k = 0; k < scene.instances.size(); k += 3)
          shot.instanceMotions.push_back(
              {k, translation(k % 2 == 0 ? 0.5 : 2.9, -0.3, 0.05) * scene.instances[k].transform});
        Scan scan, same;
        drifting.scanInto(shot, scan);
        all.scanInto(shot, same);
        CHECK(scan.counters.hits > scan.beamCount() / 20);
        CHECK(firstBytes(same, scan) == "none");
        if (sensor == 0 || i % 2 != 0) continue;
        Scan expected;
        truth.scanInto(shot, expected);
        const Differences found = differences(expected, scan, {1e-3});
        INFO(found.text());
        CHECK(found.all() == 0);
      }
  }
}

TEST_CASE("a moving head of few columns has rows, and differs from the reference in ties alone") {
  needVulkan();
  Sensor head = builtinSensor("Puck");
  head.columns = 340;  // the moments of the table are 294 us apart
  TestOptions options = vulkanOptions();
  options.effects.sensorMotion.use = EffectUse::on;
  const Scene scene = makeTown({.triangles = 20'000});
  CHECK(SensorPlanner(options).plan(scene, {head, options.effects}, 0, false)->rows);
  Simulator device = makeSimulator(scene, head, options);
  options.device = DeviceChoice::Kind::reference;
  Simulator truth = makeSimulator(scene, head, options);
  for (const SensorMotion& motion : {driving(15, 2, 1), climbing()}) {
    Shot shot;
    shot.motion = motion;
    checkBesideReference(device, truth, shot, {1e-5}, 20);
  }
}

TEST_CASE("the bend of a motion is the largest second difference of its frames between the stamps") {
  const double step = 1e-4, speed = 12, turn = 3;
  const auto boundsOf = [&](const SensorMotion& motion) {
    ScanTimes times = {-10 * step, step, 50 * step, 100 * step, 121};
    times.used = 121;
    times.halfway = 60;
    Shot shot;
    shot.motion = motion;
    return makeMotionTables(times, {}, shot, true, false).bounds;
  };
  SensorMotion straight = {{{0, {}}, {100 * step, {{speed * 100 * step, 0, 0}, {}}}}};
  gpu::MotionBounds bounds = boundsOf(straight);
  CHECK(bounds.bendFirst == 10);
  CHECK((bounds.bendEnd == 110 || bounds.bendEnd == 111));  // rounding of times decides about the last stamp
  CHECK(bounds.bendShift < 1e-9);
  CHECK(bounds.bendTurn < 1e-9);
  straight.stamps.insert(straight.stamps.begin() + 1, {30 * step, {{speed * 30 * step, 0, 0}, {}}});
  straight.stamps.back().pose.position.x += 0.5 * 70 * step;  // faster by 0.5 m/s
  CHECK(boundsOf(straight).bendShift == Catch::Approx(0.5 * step).epsilon(1e-3));
  const SensorMotion turning = {{{0, {}}, {100 * step, {{}, yaw(turn * 100 * step)}}}};
  CHECK(boundsOf(turning).bendTurn == Catch::Approx(std::sqrt(2.0) * turn * step * turn * step).epsilon(1e-3));
  CHECK(boundsOf({}).bendEnd == 0);
}

TEST_CASE("the middle of a scan of one column is half a column away") {
  Sensor sensor = gridSensor(1, 4, -10, 10);
  sensor.rotationPeriod = kPeriod;
  const MotionTables tables = makeMotionTables(scanTimesOf(sensor, false), {}, {}, true, false);
  CHECK(tables.bounds.columnsToMiddle == 0.5f);
}

TEST_CASE("views of a sensor that stands share their tables of motion, wherever it stands") {
  ScanTimes times = {0, 1e-4, 5e-3, 1e-2, 101};
  times.used = 101;
  OriginBounds lasers;
  lasers.centre = {0.05, 0.02, 0.013};
  const auto columnsAt = [&](const Pose& pose) {
    Shot shot;
    shot.pose = pose;
    return makeMotionTables(times, lasers, shot, true, true).columns;
  };
  const auto expected = columnsAt({});
  REQUIRE(expected.size() == 101);
  const auto found = columnsAt({{0.41, -0.27, 8.12}, {0.02, -0.03, 0.3, 0.95}});
  CHECK(std::memcmp(found.data(), expected.data(), expected.size() * sizeof expected[0]) == 0);
}

}  // namespace gnosphere::test
