// SPDX-License-Identifier: Apache-2.0
// Measures how the time grows with the number of triangles and of beams.
#include "cases.hpp"

namespace gnosphere::bench {
namespace {

/// A sensor with this grid over the field of view of the hypothetical sensors.
Sensor grid(uint32_t channels, uint32_t columns) {
  Sensor sensor = builtinSensor("Hypothetical-256");
  sensor.name = std::to_string(channels) + " x " + std::to_string(columns);
  sensor.columns = columns;
  sensor.channels.clear();
  for (uint32_t i = 0; i < channels; ++i) sensor.channels.push_back({-45 + 90.0 * i / (channels - 1), 0});
  return sensor;
}

}  // namespace

Report scalingTriangles(Session& session) {
  Report report;
  report.xLabel = "triangles of the town";
  const uint64_t most = session.options().triangles;
  std::vector<uint64_t> sizes;
  for (uint64_t size : {1'000'000, 3'000'000, 10'000'000, 30'000'000, 100'000'000})
    if (size < most) sizes.push_back(size);
  sizes.push_back(most);
  for (uint64_t size : sizes) {
    const Scene scene = session.scene(size);
    const std::string label = cli::grouped(scene.placedTriangleCount()) + " triangles";
    const double triangles = static_cast<double>(scene.placedTriangleCount());
    session.hold({label, triangles, scene, session.sensors({"HDL-64E"})[0]}, report.outcomes);
  }
  Table growth = {"Median time over that of the smallest town", {{"triangles", "ours ms", "growth"}}};
  for (const Outcome& outcome : report.outcomes) {
    const double ms = outcome.standings[0].totalMs.median;
    growth.rows.push_back({cli::grouped(outcome.placedTriangles), cli::bareMs(ms),
                           cli::formatted("%.2f", ms / report.outcomes[0].standings[0].totalMs.median)});
  }
  report.tables = {growth, timesTable(report.outcomes), floorTable(report.outcomes)};
  return report;
}

Report scalingRays(Session& session) {
  Report report;
  report.xLabel = "beams";
  const Scene scene = session.scene();
  constexpr std::pair<uint32_t, uint32_t> kGrids[] = {{16, 1800},   {64, 4500},    {128, 9000},
                                                      {256, 18000}, {512, 24'000}, {700, 36'000}};
  for (const auto& [channels, columns] : kGrids) {
    const Sensor sensor = grid(channels, columns);
    const double beams = static_cast<double>(sensor.beamCount());
    session.hold({cli::grouped(sensor.beamCount()) + " beams", beams, scene, sensor}, report.outcomes);
  }
  Table costs = {"Median time per beam", {{"beams", "who", "ms", "ns per beam"}}};
  for (const Outcome& outcome : report.outcomes)
    for (const Standing& s : outcome.standings)
      costs.rows.push_back({cli::grouped(outcome.sensor.beamCount()), s.name, cli::bareMs(s.totalMs.median),
                            cli::formatted("%.1f", 1e6 * s.totalMs.median / outcome.x)});
  report.tables = {costs, timesTable(report.outcomes), floorTable(report.outcomes)};
  return report;
}

}  // namespace gnosphere::bench
