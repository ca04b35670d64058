// SPDX-License-Identifier: Apache-2.0
// Lists whose beams are a vertical fan: a scanner in an aircraft, whose mirror sweeps lines.
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

}  // namespace

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
