// SPDX-License-Identifier: Apache-2.0
// The tables and figures of the paper.
#include "cases.hpp"

namespace gnosphere::bench {
namespace {

const std::vector<std::string> kPhysical = {"HDL-64E"};
const std::vector<std::string> kHypothetical = {"Hypothetical-256", "Hypothetical-350"};

/// Runs one contest per sensor over one scene.
std::vector<Outcome> overSensors(Session& session, const std::vector<std::string>& names, Motion motion) {
  const Scene scene = session.scene();
  std::vector<Outcome> outcomes;
  for (const Sensor& sensor : session.sensors(names)) {
    const size_t moving = motion == Motion::none ? 0 : scene.instances.size();
    const double beams = static_cast<double>(sensor.beamCount());
    session.hold({sensor.name, beams, scene, sensor, motion, moving}, outcomes);
  }
  return outcomes;
}

std::string perSquareKilometre(const Scene& scene) {
  const Bounds b = worldBounds(scene);
  const double area = (b.max.x - b.min.x) * (b.max.y - b.min.y);
  return cli::formatted("%.3g", area > 0 ? 1e6 * static_cast<double>(scene.placedTriangleCount()) / area : 0);
}

}  // namespace

Report table3(Session& session) {
  Report report = {overSensors(session, kPhysical, Motion::none), {}, "beams"};
  report.tables = {varianceTable(report.outcomes), timesTable(report.outcomes), floorTable(report.outcomes)};
  return report;
}

Report table4(Session& session) {
  Report report = {overSensors(session, kHypothetical, Motion::none), {}, "beams"};
  report.tables = {varianceTable(report.outcomes), timesTable(report.outcomes), floorTable(report.outcomes)};
  return report;
}

Report figure5(Session& session) {
  session.timeStages();
  Report report = {overSensors(session, {"HDL-64E", "Hypothetical-256"}, Motion::transforms), {}, "beams"};
  report.tables = {stagesTable(report.outcomes)};
  return report;
}

Report figure6Range(Session& session) {
  Report report;
  report.xLabel = "range, m";
  const Scene scene = session.scene();
  for (Sensor sensor : session.sensors(kPhysical)) {
    for (double range : {20.0, 40.0, 60.0, 80.0, 100.0, 120.0}) {
      sensor.rangeMax = range;
      session.hold({cli::formatted("%.0f m", range), range, scene, sensor}, report.outcomes);
    }
  }
  report.tables = {timesTable(report.outcomes)};
  return report;
}

Report figure6Towns(Session& session) {
  Report report;
  report.xLabel = "triangles of the town";
  Table densities = {"Triangles per area of the town's bounding box, seen from above",
                     {{"town", "triangles", "triangles per km2"}}};
  const auto measure = [&](const std::string& name, const Scene& scene) {
    densities.rows.push_back({name, cli::grouped(scene.placedTriangleCount()), perSquareKilometre(scene)});
    const double triangles = static_cast<double>(scene.placedTriangleCount());
    session.hold({name, triangles, scene, session.sensors(kPhysical)[0]}, report.outcomes);
  };
  for (const std::string& file : session.options().scenes) measure(file, loadScene(file));
  if (session.options().scenes.empty()) {
    for (uint64_t part : {10, 3, 1}) {
      const uint64_t triangles = session.options().triangles / part;
      measure(cli::grouped(triangles) + " triangles", session.scene(triangles));
    }
  }
  report.tables = {densities, timesTable(report.outcomes)};
  return report;
}

Report figure7(Session& session) {
  std::vector<std::string> names;
  for (const Sensor& sensor : builtinSensors()) names.push_back(sensor.name);
  Report report = {overSensors(session, names, Motion::none), {}, "beams"};
  report.tables = {timesTable(report.outcomes), stagesTable(report.outcomes), floorTable(report.outcomes)};
  return report;
}

}  // namespace gnosphere::bench
