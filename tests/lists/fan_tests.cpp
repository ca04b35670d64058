// SPDX-License-Identifier: Apache-2.0
// Lists whose beams lie in a plane: the mirror of a scanner in an aircraft sweeps lines, that of a profiler turns.
#include <numbers>

#include "base/vector.hpp"
#include "effects/scan_support.hpp"
#include "list_sensors.hpp"

namespace gnosphere::test {
namespace {

/// The beams of a line at an azimuth, which fire one after the other.
Sensor fanAt(double azimuthDeg) {
  constexpr double kDegree = std::numbers::pi / 180;
  BeamList line;
  for (uint32_t i = 0; i < 200; ++i) {
    line.directions.push_back(directionAt(azimuthDeg * kDegree, (0.2 * i - 35) * kDegree));
    line.times.push_back(5e-5 * i);
  }
  return listSensor("fan", std::move(line));
}

/// Small plates 20 m around the sensor, one for each degree of azimuth and of elevation.
Scene leaves() {
  MeshBuilder builder;
  for (int az = 0; az < 360; ++az)
    for (int el = -36; el < 6; ++el) {
      const double a = (az + 0.37 * (el & 3)) * std::numbers::pi / 180;
      const Vec3 middle = 20.0 * directionAt(a, el * std::numbers::pi / 180);
      const Vec3 left = 0.1 * Vec3{-std::sin(a), std::cos(a), 0};
      builder.quad(middle + -0.5 * left, left, {0, 0, 0.3});
    }
  Scene scene;
  scene.materials = {lambertian(0.5f, "leaf")};
  scene.materials[0].doubleSided = true;
  scene.meshes = {builder.take()};
  scene.instances = {{"leaves", 0, {}}};
  return scene;
}

/// The beams of a turn of a profiler, from `least` degrees below its plane to as far above it.
Sensor profiler(double leastDeg) {
  constexpr double kDegree = std::numbers::pi / 180;
  BeamList turn;
  for (uint32_t i = 0; i < 720; ++i) {
    turn.directions.push_back(directionAt((0.5 * i - 180) * kDegree, leastDeg * (i % 3 - 1.0) * kDegree));
    turn.times.push_back(0.05 / 720 * i);
  }
  return listSensor("profiler", std::move(turn));
}

/// A tunnel of 64 walls along z, each of two triangles 1 km long.
Scene tunnel() {
  constexpr int kWalls = 64;
  MeshBuilder builder;
  const auto cornerAt = [](int k) { return 3.0 * directionAt(2 * std::numbers::pi * k / kWalls, 0); };
  for (int k = 0; k < kWalls; ++k)
    builder.quad(cornerAt(k) + Vec3{0, 0, -500}, cornerAt(k + 1) + -1.0 * cornerAt(k), {0, 0, 1000});
  Scene scene;
  scene.materials = {lambertian(0.5f, "concrete")};
  scene.materials[0].doubleSided = true;
  scene.meshes = {builder.take()};
  scene.instances = {{"tunnel", 0, {}}};
  return scene;
}

}  // namespace

TEST_CASE("walls along the way of a profiler are bounded at the elevations of its beams") {
  needVulkan();
  const Scene scene = tunnel();
  TestOptions options = optionsOn("vulkan"), truth = optionsOn("reference");
  options.effects = Effects::none();
  options.effects.sensorMotion.use = EffectUse::on;
  truth.effects = options.effects;
  Shot shot;
  Pose end;
  end.position.z = 1.5;
  shot.motion.stamps = {{0, Pose()}, {0.05, end}};
  for (const double leastDeg : {0.0, 20.0}) {
    INFO(leastDeg << " degrees");
    const Sensor sensor = profiler(leastDeg);
    const Scan scan = scanOn(scene, sensor, shot, options);
    requireSame(scanOn(scene, sensor, shot, truth), scan);
    CHECK(scan.counters.hits == 720);
    CHECK(scan.counters.projected < 500);  // of 128 triangles, each of which may have several boxes
  }
}

TEST_CASE("leaves beside a fan of beams that fire in turn are not projected, standing and moving") {
  needVulkan();
  const Scene scene = leaves();
  for (const double azimuthDeg : {0.0, 90.0, 123.456, -179.9999}) {
    INFO(azimuthDeg << " degrees");
    const Sensor fan = fanAt(azimuthDeg);
    TestOptions options = optionsOn("vulkan");
    options.effects = Effects::none();
    const uint64_t ofGrid = scanOf(scene, fan, Pose(), options).counters.projected;
    options.effects.sensorMotion.use = EffectUse::on;
    Shot shot;
    Pose end;
    for (const double metres : {0.0, 0.02}) {
      end.position.x = metres;
      shot.motion.stamps = {{0, Pose()}, {0.01, end}};
      TestOptions truth = options;
      truth.device = DeviceChoice::Kind::reference;
      const Scan scan = scanOn(scene, fan, shot, options);
      requireSame(scanOn(scene, fan, shot, truth), scan);
      CHECK(scan.counters.hits > 5);
      CHECK(scan.counters.projected < 3 * ofGrid);  // places of a grid are exact
    }
  }
}

}  // namespace gnosphere::test
