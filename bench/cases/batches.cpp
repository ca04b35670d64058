// SPDX-License-Identifier: Apache-2.0
// Many views of a small sensor: scanned one after another, and as a batch.
#include "cases.hpp"

namespace gnosphere::bench {

Report batches(Session& session) {
  const Scene scene = session.scene();
  Sensor sensor = session.sensors({"VLP-16"})[0];
  if (session.options().sensor.empty()) {
    sensor.name = "16 x 360";
    sensor.columns = 360;
  }
  Simulator simulator(scene, {sensor, Effects::none()}, session.simulatorOptions());
  session.setDevice(simulator.device());
  const std::vector<Shot> shots = shotsFrom(session.poses(scene));
  Report report;
  Table table = {"Median times of all runs, per view, until the results are on the host",
                 {{"views", "one by one, ms", "as a batch, ms", "ratio"}}};
  for (const size_t share : {16, 4, 1}) {
    const std::span<const Shot> views(shots.data(), std::max<size_t>(shots.size() / share, 1));
    Scan scan;
    Batch batch;
    simulator.scanBatchInto(views, batch);
    for (size_t view = 0; view < views.size(); ++view) {
      simulator.scanInto(views[view], scan);
      for (size_t i = 0; i < scan.ranges.size(); ++i)
        report.wrong |= scan.triangles[i] != batch.triangles()[view * scan.ranges.size() + i];
    }
    if (report.wrong) throw Error(ErrorCode::device, "wrong: a batch has other owners than the scans of its views");
    std::vector<double> alone, together;
    for (uint32_t run = 0; run < session.options().runs; ++run) {
      const double start = cli::nowMs();
      for (const Shot& view : views) simulator.scanInto(view, scan);
      const double between = cli::nowMs();
      simulator.scanBatchInto(views, batch);
      alone.push_back((between - start) / static_cast<double>(views.size()));
      together.push_back((cli::nowMs() - between) / static_cast<double>(views.size()));
    }
    const double one = spreadOf(alone).median, all = spreadOf(together).median;
    table.rows.push_back(
        {cli::grouped(views.size()), cli::bareMs(one), cli::bareMs(all), cli::formatted("%.2f", one / all)});
    report.more["rows"].push_back({{"views", views.size()}, {"alone_ms", rounded(one)}, {"batch_ms", rounded(all)}});
    report.bars.bars.push_back({cli::grouped(views.size()) + " views", one / all, 0, 0});
  }
  report.bars.xLabel = "times as fast as one by one";
  report.more["sensor"] = cli::sensorJson(sensor);
  report.more["scene"] = cli::sceneJson(scene);
  report.tables = {table};
  return report;
}

}  // namespace gnosphere::bench
