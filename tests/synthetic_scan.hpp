// SPDX-License-Identifier: Apache-2.0
// A scan computed from formulas without triangles: a street with a ground, two walls, poles and a box.
#pragma once

#include <cmath>
#include <limits>

#include "gnosphere/gnosphere.hpp"

namespace gnosphere {

struct Candidate {
  double t = std::numeric_limits<double>::infinity();
  uint32_t triangle = kNoTriangle;
  void offer(double distance, uint32_t id) {
    if (distance > 0 && distance < t) t = distance, triangle = id;
  }
};

inline Candidate hitStreet(const Vec3& d) {
  Candidate best;
  if (d.z < 0) best.offer(-1.8 / d.z, 0);
  for (uint32_t side = 0; side < 2; ++side) {  // walls at y = -9 and 12, of varying height
    const double y = side == 0 ? -9 : 12;
    const double t = y / d.y;
    if (t > 0 && t * d.z < 4 + 3 * std::sin(std::floor(t * d.x / 11) * 2.3 + side)) best.offer(t, 1 + side);
  }
  for (uint32_t k = 0; k < 24; ++k) {  // poles of 15 cm, 8 m apart
    const double px = -92 + 8.0 * k + 3, py = k % 2 ? -6.5 : 8;
    const double a = d.x * d.x + d.y * d.y, b = d.x * px + d.y * py, c = px * px + py * py - 0.15 * 0.15;
    const double root = b * b - a * c;
    if (root >= 0 && b > 0 && d.z * (b - std::sqrt(root)) / a < 4) best.offer((b - std::sqrt(root)) / a, 3 + k);
  }
  return best;
}

inline Scan syntheticScan(const Sensor& sensor) {
  Scan scan;
  scan.sensor = sensor.name;
  scan.columns = sensor.columns;
  scan.channels = static_cast<uint32_t>(sensor.channels.size());
  scan.firstRowOnTop =
      !sensor.channels.empty() && sensor.channels[0].elevationDeg > sensor.channels.back().elevationDeg;
  scan.firstColumnOnLeft = sensor.azimuthSpanDeg < 0;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (size_t beam = 0; beam < sensor.beamCount(); ++beam) {
    const Vec3 d = sensor.direction(beam);
    const Candidate best = hitStreet(d);
    const bool hit = best.t >= sensor.rangeMin && best.t <= sensor.rangeMax;
    for (double c : {d.x, d.y, d.z}) scan.points.push_back(hit ? static_cast<float>(c * best.t) : nan);
    scan.ranges.push_back(hit ? static_cast<float>(best.t) : nan);
    scan.triangles.push_back(hit ? best.triangle : kNoTriangle);
    scan.instances.push_back(hit ? best.triangle % 3 : kNoTriangle);
    scan.counters.hits += hit;
  }
  scan.counters.beams = sensor.beamCount();
  scan.counters.misses = scan.counters.beams - scan.counters.hits;
  return scan;
}

}  // namespace gnosphere
