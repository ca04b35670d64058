// SPDX-License-Identifier: Apache-2.0
// Lists of beams from a sensor whose way bends. Between two times a triangle is bounded by its corners at both, and by
// how far the way bends meanwhile. A bound that is too narrow loses hits.
#include <numbers>

#include "effects/scan_support.hpp"
#include "lists/list_sensors.hpp"

namespace gnosphere::test {
namespace {

constexpr Vec3 kStart = {1.3, 0.4, 1.8};

/// Beams within 35 degrees of forward, of which neighbours fire at any times.
Sensor scattered() {
  Random random(21);
  BeamList beams;
  for (int i = 0; i < 6'000; ++i) {
    beams.directions.push_back(directionAt(0.6 * random(), 0.6 * random()));
    beams.times.push_back(kPeriod * std::abs(random()));
  }
  Sensor sensor = listSensor("scattered", beams, 30);
  sensor.rotationPeriod = kPeriod;
  return sensor;
}

/// Triangles as large as the angle between two beams, and up to ten times that, 2 to 10 m ahead.
Scene ahead() {
  Random random(22);
  MeshBuilder builder;
  for (int i = 0; i < 6'000; ++i) {
    const Vec3 d = directionAt(0.8 * random(), 0.8 * random());
    const double range = 6 + 4 * random(), size = range * 0.004 * std::pow(10, std::abs(random()));
    const auto corner = [&] {
      return Vec3{kStart.x + range * d.x + size * random(), kStart.y + range * d.y + size * random(),
                  kStart.z + range * d.z + size * random()};
    };
    builder.triangle(corner(), corner(), corner());
  }
  return sceneOf(builder.take());
}

/// Returns a motion during the period. `poseAt` takes a share of the period, 0..1, and returns the place relative to
/// kStart in metres, and the turn as a rotation vector in radians.
template <typename PoseAt>
SensorMotion through(const PoseAt& poseAt) {
  SensorMotion motion;
  constexpr int kPieces = 400;  // so many that the way between two hardly bends: the device joins times 49 us apart
  for (int i = 0; i <= kPieces; ++i) {
    const double share = static_cast<double>(i) / kPieces;
    const auto [place, turn] = poseAt(share);
    const double angle = std::hypot(turn.x, turn.y, turn.z), half = 0.5 * angle;
    const double scale = angle > 0 ? std::sin(half) / angle : 0;
    motion.stamps.push_back({kPeriod * share,
                             {{kStart.x + place.x, kStart.y + place.y, kStart.z + place.z},
                              {scale * turn.x, scale * turn.y, scale * turn.z, std::cos(half)}}});
  }
  return motion;
}

}  // namespace

TEST_CASE("a list loses no hit while its sensor moves, however the way bends") {
  needVulkan();
  const std::pair<const char*, SensorMotion> motions[] = {
      {"straight on", through([](double s) {
         return std::pair(Vec3{3 * s, 0, 0}, Vec3{0, 0, 0.3 * s});
       })},
      {"rolling", through([](double s) {
         return std::pair(Vec3{0, 0, 0}, Vec3{2.5 * s, 0, 0});
       })},
      {"pitching", through([](double s) {
         return std::pair(Vec3{0, 0, 0}, Vec3{0, 0.5 * std::sin(3 * s), 0});
       })},
      {"in a circle", through([](double s) {
         const double angle = 2 * std::numbers::pi * s;
         return std::pair(Vec3{0, 0.4 * std::cos(angle), 0.4 * std::sin(angle)}, Vec3{0, 0, 0});
       })}};
  TestOptions options = vulkanOptions();
  options.effects.sensorMotion.use = EffectUse::on;
  options.effects.objectMotion.use = EffectUse::on;
  Scene scene = ahead();
  scene.instances.push_back({"", 0, translation(0.1, 0.2, -0.1)});
  Simulator device = makeSimulator(scene, scattered(), options);
  options.device = DeviceChoice::Kind::reference;
  Simulator truth = makeSimulator(scene, scattered(), options);
  for (const auto& [name, motion] : motions) {
    INFO(name);
    Shot shot;
    shot.pose = motion.stamps[0].pose;
    shot.motion = motion;
    shot.instanceMotions.push_back({1, translation(0.5, -0.4, 0.3) * scene.instances[1].transform * rotationZ(0.1)});
    checkBesideReference(device, truth, shot, {1e-3}, 4);
  }
}

// Were the step to widen the bounds of the whole scan, each triangle would have a box in each of the 32 slices of time,
// and each box would hold all beams.
TEST_CASE("a sudden step in the path of a list's sensor widens the bounds of its own moment alone") {
  needVulkan();
  Sensor sensor = scattered();
  for (double& time : sensor.patterns[0].times)  // no beam fires while the device cuts the step short
    if (std::abs(time - kPeriod / 2) < 1e-4) time += 2e-4;
  TestOptions options = vulkanOptions();
  options.effects.sensorMotion.use = EffectUse::on;
  const Scene scene = ahead();
  Simulator device = makeSimulator(scene, sensor, options);
  options.device = DeviceChoice::Kind::reference;
  Simulator truth = makeSimulator(scene, sensor, options);
  const Pose before = {kStart, {}}, after = {{kStart.x, kStart.y + 0.5, kStart.z}, yaw(0.1)};
  Shot shot;
  shot.pose = before;
  shot.motion.stamps = {{0, before}, {kPeriod / 2, before}, {kPeriod / 2 + 1e-6, after}, {kPeriod, after}};
  checkBesideReference(device, truth, shot, {1e-3}, 5);
  Scan scan;
  device.scanInto(shot, scan);
  CHECK(scan.counters.projected < 8 * scan.counters.triangles);
}

TEST_CASE("no counter of a list that moves wraps when its scans are submitted together") {
  needVulkan();
  SensorRequest request(scattered());
  request.effects = Effects::none();
  request.effects.sensorMotion.use = EffectUse::on;
  Simulator simulator(ahead(), request, vulkanOptions());
  Shot shot;
  shot.pose.position = kStart;
  shot.motion.stamps = {{0, shot.pose}, {kPeriod, {{kStart.x + 2, kStart.y, kStart.z}, {}}}};
  const std::vector<Shot> shots(3, shot);
  size_t seen = 0;
  simulator.scanAll(shots, [&](size_t, const Scan& scan) {
    ++seen;
    CHECK(scan.counters.culledByCluster <= scan.counters.triangles);
    CHECK(scan.counters.projected > 0);
  });
  CHECK(seen == 3);
}

}  // namespace gnosphere::test
