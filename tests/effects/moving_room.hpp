// SPDX-License-Identifier: Apache-2.0
// A room, and a spinning sensor that drives and turns in it, for tests of scans in motion.
#pragma once

#include <catch2/catch_approx.hpp>

#include "effects/scan_support.hpp"

namespace gnosphere::test {

using Catch::Approx;

inline Sensor spinning(uint32_t columns = 360) {
  Sensor sensor = gridSensor(columns, 5, -20, 20, 100);
  sensor.rotationPeriod = kPeriod;
  return sensor;
}

inline double timeOfColumn(const Sensor& sensor, size_t beam) {
  return kPeriod * double(beam % sensor.columns) / sensor.columns;
}

inline Scene room() {
  MeshBuilder builder;
  builder.box({-20, -30, -15}, {20, 30, 15}, 4);
  Scene scene = sceneOf(builder.take());
  return scene;
}

/// Distance at which a line from a point in the room hits its walls.
inline double toWalls(const Vec3& from, const Vec3& d) {
  const auto wall = [](double at, double speed, double half) {
    return speed > 0 ? (half - at) / speed : speed < 0 ? (-half - at) / speed : 1e9;
  };
  return std::min({wall(from.x, d.x, 20), wall(from.y, d.y, 30), wall(from.z, d.z, 15)});
}

inline Vec3 turned(double angle, const Vec3& v) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * v.x - s * v.y, s * v.x + c * v.y, v.z};
}

/// A shot in which the sensor moves ahead at 20 m/s and turns left at 2 rad/s.
constexpr double kSpeed = 20, kTurn = 2;  // m/s and rad/s
inline Shot driving() {
  Shot shot;
  shot.motion.stamps = {{0, {}}, {kPeriod, {{kSpeed * kPeriod, 0, 0}, yaw(kTurn * kPeriod)}}};
  return shot;
}

inline Scan scanned(const std::string& device, const Scene& scene, const Sensor& sensor, const Shot& shot,
                    bool deskew = false) {
  TestOptions options = optionsOn(device);
  options.effects.radialSpeed.use = options.effects.sensorMotion.use = options.effects.objectMotion.use =
      EffectUse::automatic;
  options.effects.sensorMotion.deskew = deskew;
  options.fields = {Field::radialSpeed, Field::velocity, Field::normal};
  return scanOn(scene, sensor, shot, options);
}

}  // namespace gnosphere::test
