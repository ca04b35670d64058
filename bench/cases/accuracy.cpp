// SPDX-License-Identifier: Apache-2.0
// Runs the measurement of `gnosphere accuracy`, so that one file holds all results.
#include "gnosphere/eval/accuracy.hpp"

#include "cases.hpp"

namespace gnosphere::bench {
namespace {

cli::Json rowJson(const AccuracyRow& row) {
  cli::Json error = errorJson(row.error);
  error["range_error_rms_m"] = rounded(row.error.rangeErrorRms);
  error["any_owner_error_max_m"] = rounded(row.error.hitErrorMax);
  return {{"name", row.name},
          {"time_ms", medianJson(row.time())},
          {"ratio_to_standard", rounded(row.ratio.median)},
          {"error", error}};
}

}  // namespace

Report accuracy(Session& session) {
  const Scene scene = session.scene();
  const Sensor sensor = session.sensors({"HDL-64E"})[0];
  AccuracyOptions options;
  options.simulator = session.simulatorOptions();
  options.simulator.faces = ReflectingFaces::material;
  options.runs = session.options().runs;
  options.nearest = false;
  options.progress = cli::stepProgress();
  const std::vector<Pose> poses = session.poses(scene);
  const AccuracyReport found = measureAccuracy(scene, sensor, poses, options);
  session.setDevice(found.device);
  Report report;
  report.more = {{"scene", cli::sceneJson(scene)},
                 {"sensor", cli::sensorJson(sensor)},
                 {"poses", poses.size()},
                 {"beams", found.beams},
                 {"runs", found.runs}};
  Table table = {"Below the settings: `standard` without one of its parts", {}};
  table.rows = {{"setting", "ms", "ratio", "missed", "false", "wrong range", "largest range error, m"}};
  for (const auto& [name, rows] : {std::pair("settings", &found.settings), std::pair("parts", &found.parts)}) {
    for (const AccuracyRow& row : *rows) {
      report.more[name].push_back(rowJson(row));
      table.rows.push_back({row.name, cli::bareMs(row.time().median), cli::formatted("%.2f", row.ratio.median),
                            cli::grouped(row.error.missed), cli::grouped(row.error.falseHits),
                            cli::grouped(row.error.wrongRange), cli::formatted("%.2g", row.error.hitErrorMax)});
    }
  }
  report.tables = {table};
  return report;
}

}  // namespace gnosphere::bench
