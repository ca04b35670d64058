// SPDX-License-Identifier: Apache-2.0
// gnosphere-bench stability: measures how the error of each accuracy grows with the difficulty of a case.
#include "cases/stability.hpp"

#include <algorithm>
#include <memory>

#include "cases/hardness.hpp"
#include "cases/results.hpp"
#include "gnosphere/options.hpp"
#include "plot.hpp"
#include "report.hpp"

namespace gnosphere::bench {
namespace {

using cli::formatted;
using cli::Json;

struct HardnessOptions {
  std::string device = "auto", plot, json, family;
  bool ends = false;
};

/// One accuracy on one case. Ties count like any other beam: see hardness.hpp.
struct Verdict {
  Comparison comparison;
  uint64_t lost() const { return comparison.missed + comparison.tieMissed; }
  double lostShare() const { return static_cast<double>(lost()) / static_cast<double>(comparison.hits); }
  double error() const { return std::max(comparison.hitErrorMax, comparison.tieErrorMax); }
  /// False if every beam is lost, so that there is no error to measure.
  bool anyHit() const { return lost() < comparison.hits; }
};

struct HardnessRow {
  double hardness;
  std::vector<Verdict> outcomes;  ///< in the order of accuracySettings()
};

struct FamilyResult {
  const Family& family;
  std::vector<HardnessRow> rows;
};

HardnessRow measure(const HardCase& test, const std::string& device, DeviceInfo& info) {
  SimulatorOptions options;
  const SensorRequest request = {test.sensor, Effects::none()};
  options.device = DeviceChoice::Kind::reference;
  const Scan truth = Simulator(test.scene, request, options).scan(test.pose);
  if (truth.counters.misses > 0) throw std::logic_error("a hard case must be hit by every beam");
  HardnessRow row = {test.hardness, {}};
  options.device = deviceByName(device);
  for (const AccuracySetting& setting : accuracySettings()) {
    options.accuracy = setting.accuracy;
    Simulator simulator(test.scene, request, options);
    info = simulator.device();
    row.outcomes.push_back({compare(truth, simulator.scan(test.pose))});
  }
  return row;
}

std::vector<FamilyResult> measureAll(const HardnessOptions& options, DeviceInfo& info) {
  uint64_t total = 0, done = 0;
  for (const Family& family : families()) total += family.hardness.size();  // an upper bound, as some may be left out
  const auto progress = cli::stepProgress();
  std::vector<FamilyResult> results;
  for (const Family& family : families()) {
    if (!options.family.empty() && options.family != family.name) continue;
    results.push_back({family, {}});
    for (double hardness : family.hardness) {
      if (options.ends && hardness != family.hardness.front() && hardness != family.hardness.back()) continue;
      progress("case", ++done, total);
      results.back().rows.push_back(measure(family.make(hardness), options.device, info));
    }
  }
  return results;
}

void print(const FamilyResult& result) {
  std::printf("\n%s: largest range error in m, and share of beams lost\n\n", result.family.title);
  std::vector<cli::TableRow> rows = {{result.family.unit}};
  for (const AccuracySetting& setting : accuracySettings()) {
    rows[0].push_back(setting.name);
    rows[0].push_back("lost");
  }
  for (const HardnessRow& row : result.rows) {
    rows.push_back({formatted("%g", row.hardness)});
    for (const Verdict& outcome : row.outcomes) {
      rows.back().push_back(outcome.anyHit() ? formatted("%.2g", outcome.error()) : "-");
      rows.back().push_back(outcome.lost() ? formatted("%.3g %%", 100 * outcome.lostShare()) : "0");
    }
  }
  cli::printMarkdown(rows);
}

cli::Json familiesJson(const std::vector<FamilyResult>& results) {
  Json families = Json::array();
  for (const FamilyResult& result : results) {
    Json family = {{"name", result.family.name}, {"unit", result.family.unit}};
    for (const HardnessRow& row : result.rows) family["hardness"].push_back(row.hardness);
    for (size_t i = 0; i < accuracySettings().size(); ++i) {
      Json setting = {{"name", accuracySettings()[i].name}};
      for (const HardnessRow& row : result.rows) {
        const Verdict& outcome = row.outcomes[i];
        setting["error_max_m"].push_back(outcome.anyHit() ? Json(rounded(outcome.error())) : Json());
        setting["lost_share"].push_back(rounded(outcome.lostShare()));
      }
      family["settings"].push_back(setting);
    }
    families.push_back(family);
  }
  return {{"families", families}};
}

/// Markers of the four lines. The markers are nested, because the lines often coincide.
cli::PlotSeries look(size_t setting) {
  static const cli::PlotSeries kLooks[] = {
      {"", cli::Marker::cross, "#d55e00", "2 3", 4, {}},
      {"", cli::Marker::triangle, "#0072b2", "7 4", 5, {}},
      {"", cli::Marker::circle, "#009e73", "", 2.5, {}},
      {"", cli::Marker::square, "#222222", "12 3 2 3", 6, {}},
  };
  cli::PlotSeries series = kLooks[setting % std::size(kLooks)];
  series.name = accuracySettings()[setting].name;
  return series;
}

cli::PlotPanel panelOf(const FamilyResult& result, bool lost) {
  cli::PlotPanel panel = {lost ? "" : result.family.title,
                          std::string(result.family.title) + ", " + result.family.unit,
                          lost ? "% of beams lost" : "largest range error, m",
                          {}};
  const bool harderLeft = result.family.hardness.front() > result.family.hardness.back();
  if (harderLeft) panel.xLabel += " (harder to the left)";
  for (size_t i = 0; i < accuracySettings().size(); ++i) {
    cli::PlotSeries series = look(i);
    for (const HardnessRow& row : result.rows) {
      const Verdict& outcome = row.outcomes[i];
      if (lost || outcome.anyHit())
        series.points.push_back({row.hardness, lost ? 100 * outcome.lostShare() : outcome.error(), 0, 0, ""});
    }
    panel.series.push_back(series);
  }
  return panel;
}

std::string toSvg(const std::vector<FamilyResult>& results, const DeviceInfo& info) {
  cli::Plot plot;
  plot.title = "How stable each accuracy is";
  plot.notes = {
      "Every beam hits one continuous surface; errors are relative to the double-precision reference, and ties "
      "count like any beam. " +
      info.name};
  plot.legend = true;
  plot.columns = results.size();
  plot.panelWidth = 330;
  plot.panelHeight = 270;
  for (bool lost : {false, true})
    for (const FamilyResult& result : results) plot.panels.push_back(panelOf(result, lost));
  return cli::toSvg(plot);
}

int run(const HardnessOptions& options) {
  checkPlot(options.plot);
  checkResult(options.json);
  DeviceInfo info;
  const std::vector<FamilyResult> results = measureAll(options, info);
  if (options.json != "-") {
    printHead(info);
    for (const FamilyResult& result : results) print(result);
  }
  Json json = resultsHead(info);
  json.update(familiesJson(results));
  writeResult(options.json, compact(json));
  writeResult(options.plot, toSvg(results, info));
  return 0;
}

}  // namespace

cli::Json stabilityOf(const std::string& device) {
  HardnessOptions options;
  options.device = device;
  DeviceInfo info;
  return familiesJson(measureAll(options, info));
}

std::function<int()> addStability(CLI::App& app) {
  const auto options = std::make_shared<HardnessOptions>();
  std::vector<std::string> names;
  for (const Family& family : families()) names.push_back(family.name);
  app.add_option("--device", options->device, "A device, as in gnosphere scan --device")->capture_default_str();
  app.add_option("--family", options->family, "Run only this family of cases")->check(CLI::IsMember(names));
  app.add_flag("--ends", options->ends, "Run only the easiest and the hardest case of each family");
  app.add_option("--plot", options->plot, "Write an .svg plot with two panels per family");
  app.add_option("--json", options->json, "Write all measurements to a JSON file, or - for stdout");
  app.footer("Example: gnosphere-bench stability --ends --plot stability.svg");
  return [options] { return run(*options); };
}

}  // namespace gnosphere::bench
