// SPDX-License-Identifier: Apache-2.0
// Scenes with moving objects: the time to update a structure before every scan.
#include "cases.hpp"

namespace gnosphere::bench {

Report dynamic(Session& session) {
  Report report;
  report.xLabel = "moving instances";
  const Scene scene = session.scene();
  const size_t all = scene.instances.size();
  for (const Sensor& sensor : session.sensors({"HDL-64E"})) {
    for (size_t moving = 10; moving < all && moving <= 1000; moving *= 10) {
      const std::string label = sensor.name + ", " + cli::grouped(moving) + " instances move";
      session.hold({label, static_cast<double>(moving), scene, sensor, Motion::transforms, moving}, report.outcomes);
    }
    const double x = static_cast<double>(all);
    const std::string label = sensor.name + ", all " + cli::grouped(all) + " instances move";
    session.hold({label, x, scene, sensor, Motion::transforms, all}, report.outcomes);
    const std::string any = sensor.name + ", all vertices may move";
    session.hold({any, x, scene, sensor, Motion::everything, all}, report.outcomes);
  }
  report.tables = {timesTable(report.outcomes), floorTable(report.outcomes)};
  return report;
}

}  // namespace gnosphere::bench
