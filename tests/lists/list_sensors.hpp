// SPDX-License-Identifier: Apache-2.0
// Sensors that are lists of beams: what people buy, and what is hard.
#pragma once

#include <algorithm>

#include "support.hpp"

namespace gnosphere::test {

inline Vec3 unit(const Vec3& v) {
  const double length = std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
  return {v.x / length, v.y / length, v.z / length};
}

inline Sensor listSensor(std::string name, BeamList beams, double rangeMax = 200) {
  Sensor sensor;
  sensor.name = std::move(name);
  sensor.rangeMax = rangeMax;
  sensor.patterns.push_back(std::move(beams));
  return sensor;
}

/// A grid's beams as a list.
inline Sensor asList(const Sensor& grid, uint64_t frame = 0) {
  Sensor sensor = grid;
  sensor.patterns = {beamsOf(grid, frame)};
  sensor.columns = 0;
  sensor.channels.clear();
  sensor.azimuthStartDeg = -180;
  sensor.azimuthSpanDeg = 360;
  return sensor;
}

/// The rosette of two turning prisms, as in a Livox Mid-40.
inline BeamList rosette(uint32_t count, double halfAngle, double phase = 0) {
  BeamList list;
  for (uint32_t i = 0; i < count; ++i) {
    const double t = (i + phase) / 1000.0, radius = halfAngle * std::abs(std::sin(7.31 * t));
    list.directions.push_back(directionAt(radius * std::cos(3.77 * t), radius * std::sin(3.77 * t)));
    list.times.push_back(0.1 * i / count);
  }
  return list;
}

/// Heads at several places in one list: beam by beam, and of each beam head by head.
inline BeamList headsAt(const std::vector<Vec3>& places, const BeamList& head) {
  BeamList list;
  for (size_t i = 0; i < places.size() * head.size(); ++i) {
    list.directions.push_back(head.directions[i / places.size()]);
    list.origins.push_back(places[i % places.size()]);
  }
  return list;
}

inline Vec3 anyDirection(Random& random) {
  while (true) {
    const Vec3 v = {random(), random(), random()};
    const double square = v.x * v.x + v.y * v.y + v.z * v.z;
    if (square > 0.01 && square <= 1) return unit(v);
  }
}

/// Ten lists of some thousand beams each.
inline std::vector<Sensor> listSensors() {
  std::vector<Sensor> sensors;
  const double pi = std::numbers::pi;
  Random random(5);
  sensors.push_back(listSensor("rosette", rosette(8000, 0.35)));
  {
    BeamList sector;
    for (int row = 0; row < 60; ++row)
      for (int column = 0; column < 120; ++column)
        sector.directions.push_back(directionAt((column - 60) * pi / 180, (row - 30) * 0.4 * pi / 180));
    sector.width = 120;
    sector.height = 60;
    sensors.push_back(listSensor("solid state", sector));
  }
  BeamList sphere;
  for (int i = 0; i < 9000; ++i) sphere.directions.push_back(anyDirection(random));
  sensors.push_back(listSensor("sphere", sphere));
  BeamList one;
  one.directions.assign(500, directionAt(0.3, -0.2));
  sensors.push_back(listSensor("one direction", one));
  BeamList circle;
  for (int i = 0; i < 6000; ++i) {
    const double angle = 2 * pi * i / 6000, tilt = 1.1;
    circle.directions.push_back({std::cos(angle), std::sin(angle) * std::cos(tilt), std::sin(angle) * std::sin(tilt)});
  }
  sensors.push_back(listSensor("great circle", circle));
  BeamList poles;
  for (int i = 0; i < 4000; ++i) {
    const double angle = 0.02 * random(), turn = pi * random(), up = i % 2 == 0 ? 1 : -1;
    poles.directions.push_back(
        {std::sin(angle) * std::cos(turn), std::sin(angle) * std::sin(turn), up * std::cos(angle)});
  }
  poles.directions.push_back({0, 0, 1});
  poles.directions.push_back({0, 0, -1});
  sensors.push_back(listSensor("poles", poles));
  BeamList clusters;
  for (int i = 0; i < 40; ++i) {
    const Vec3 centre = anyDirection(random);
    for (int k = 0; k < 200; ++k)
      clusters.directions.push_back(
          unit({centre.x + 0.003 * random(), centre.y + 0.003 * random(), centre.z + 0.003 * random()}));
  }
  sensors.push_back(listSensor("clusters", clusters));
  for (const double reach : {1.0, 100.0}) {
    BeamList spread;
    // Each of those far apart is projected by itself.
    for (int i = 0; i < (reach > 1 ? 250 : 2000); ++i) {
      spread.directions.push_back(anyDirection(random));
      const Vec3 from = anyDirection(random);
      const double far = reach * std::abs(random());
      spread.origins.push_back({far * from.x, far * from.y, far * from.z});
    }
    sensors.push_back(listSensor(reach > 1 ? "origins 100 m apart" : "origins within 1 m", spread));
  }
  {
    BeamList windows = sphere;
    for (size_t i = 0; i < windows.size(); ++i) {
      windows.rangeMin.push_back(static_cast<float>(i % 5));
      windows.rangeMax.push_back(static_cast<float>(8 + i % 60));
    }
    Sensor sensor = listSensor("windows and masks", windows, 500);
    for (uint32_t i = 0; i < windows.size(); i += 7) sensor.maskedBeams.push_back(i);
    sensors.push_back(sensor);
  }
  return sensors;
}

}  // namespace gnosphere::test
