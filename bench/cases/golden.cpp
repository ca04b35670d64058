// SPDX-License-Identifier: Apache-2.0
// Compares clouds of `exact` with the committed hashes; no time is measured.
#include "golden.hpp"

#include "cases.hpp"
#include "cases/results.hpp"

namespace gnosphere::bench {

Report golden(Session& session) {
  SimulatorOptions options = session.simulatorOptions();
  session.setDevice(Simulator(Scene(), std::vector<SensorRequest>(), options).device());
  const std::vector<GoldenCloud> clouds = scanGolden(options, goldenGroups());
  Report report;
  Table table = {"Each cloud must have the hash of bench/golden_hashes.inc, on every device.", {{"cloud", "hash"}}};
  std::string lines;
  for (const GoldenCloud& cloud : clouds) {
    if (!session.options().renew.empty() && !cloud.problem.empty()) throw Error(ErrorCode::device, cloud.problem);
    table.rows.push_back({cloud.name, cloud.problem.empty() ? cloud.hash : "-"});
    report.more["rows"].push_back({{"name", cloud.name}, {"hash", cloud.hash}});
    lines += "{\"" + cloud.name + "\", \"" + cloud.hash + "\"},\n";
  }
  writeResult(session.options().renew, lines);
  const std::vector<std::string> differences = differencesOf(clouds, goldenTable());
  report.wrong = session.options().renew.empty() && !differences.empty();
  if (report.wrong) table.note = "WRONG:";
  for (const std::string& difference : differences)
    if (report.wrong) table.note += "\n" + difference;
  report.more["wrong"] = differences;
  report.tables = {table};
  return report;
}

}  // namespace gnosphere::bench
