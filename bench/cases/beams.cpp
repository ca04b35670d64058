// SPDX-License-Identifier: Apache-2.0
// Measures sensors that are not a full turn of a grid, beside the grid that they come from.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "cases.hpp"

namespace gnosphere::bench {
namespace {

Sensor named(const char* name, Sensor sensor) {
  sensor.name = name;
  return sensor;
}

Sensor listOf(const char* name, BeamList beams, double rangeMax) {
  Sensor sensor;
  sensor.name = name;
  sensor.rangeMax = rangeMax;
  sensor.patterns.push_back(std::move(beams));
  return sensor;
}

/// The beams of a grid as a list. If `apart`, each beam is turned by up to a tenth of a column, so that the list does
/// not lie on a grid.
Sensor asList(const char* name, const Sensor& grid, bool apart) {
  BeamList beams = beamsOf(grid);
  std::mt19937 random(1);
  for (Vec3& d : beams.directions) {
    const double angle = apart ? 0.2 * std::numbers::pi / grid.columns * (double(random()) / 0xffffffffu) : 0;
    const double c = std::cos(angle), s = std::sin(angle);
    d = {c * d.x - s * d.y, s * d.x + c * d.y, d.z};
  }
  return listOf(name, std::move(beams), grid.rangeMax);
}

/// Four heads with the beams of one, to all sides, each 2.2 m from the sensor's origin.
Sensor fourOf(const char* name, const Sensor& head) {
  const BeamList one = head.patterns[0];
  BeamList beams;
  for (int k = 0; k < 4; ++k)
    for (size_t i = 0; i < one.size(); ++i) {
      const Vec3& d = one.directions[i];
      const double c = std::array{1, 0, -1, 0}[k], s = std::array{0, 1, 0, -1}[k];
      beams.directions.push_back({c * d.x - s * d.y, s * d.x + c * d.y, d.z});
      beams.origins.push_back({2.2 * c, 2.2 * s, 0});
    }
  return listOf(name, std::move(beams), head.rangeMax);
}

/// Evenly distributed over the sphere, and sorted by blocks of about 16 beams, which suits ray tracers.
Sensor anywhere(size_t count) {
  BeamList beams;
  std::mt19937 random(2);
  const auto uniform = [&] { return double(random()) / 0xffffffffu; };
  for (size_t i = 0; i < count; ++i) {
    const double z = 2 * uniform() - 1, azimuth = 2 * std::numbers::pi * uniform(), h = std::sqrt(1 - z * z);
    beams.directions.push_back({h * std::cos(azimuth), h * std::sin(azimuth), z});
  }
  const double rows = std::sqrt(static_cast<double>(count) / 16);
  const auto block = [&](const Vec3& d) { return std::pair(std::floor((d.z + 1) / 2 * rows), std::atan2(d.y, d.x)); };
  std::sort(beams.directions.begin(), beams.directions.end(),
            [&](const Vec3& a, const Vec3& b) { return block(a) < block(b); });
  return listOf("1,000,000 beams anywhere", std::move(beams), 120);
}

}  // namespace

Report beams(Session& session) {
  Report report;
  report.xLabel = "beams";
  const Scene scene = session.scene();
  const Sensor grid = session.sensors({"HDL-64E"})[0];
  Sensor sector = named("sector of 120 degrees", grid), radial = named("lasers 27.7 mm off the axis", grid),
         upright = named("lasers up to 32 mm above each other", grid);
  sector.columns /= 3;
  sector.azimuthStartDeg = -60;
  sector.azimuthSpanDeg = 120;
  for (Channel& channel : radial.channels) channel.origin = {0.02767, 0, 0};
  for (size_t i = 0; i < upright.channels.size(); ++i)
    upright.channels[i].origin.z = 0.032 * static_cast<double>(i) / static_cast<double>(upright.channels.size());
  for (const Sensor& sensor :
       {grid, asList("its beams as a list", grid, false), asList("its beams, a little apart", grid, true), sector,
        radial, upright, named("Livox Avia", builtinSensor("Avia")),
        fourOf("four Livox Avia, 2.2 m from the origin", builtinSensor("Avia")), anywhere(1'000'000)})
    session.hold({sensor.name, static_cast<double>(sensor.beamCount()), scene, sensor}, report.outcomes);
  Table costs = {"Median time", {{"sensor", "beams", "ours ms", "over the grid's", "ns per beam"}}};
  const double first = report.outcomes.empty() ? 0 : report.outcomes[0].standings[0].totalMs.median;
  for (const Outcome& outcome : report.outcomes) {
    const double ms = outcome.standings[0].totalMs.median;
    costs.rows.push_back({outcome.label, cli::grouped(outcome.sensor.beamCount()), cli::bareMs(ms),
                          cli::formatted("%.2f", ms / first), cli::formatted("%.1f", 1e6 * ms / outcome.x)});
  }
  report.tables = {costs, timesTable(report.outcomes), floorTable(report.outcomes)};
  return report;
}

}  // namespace gnosphere::bench
