// SPDX-License-Identifier: Apache-2.0
#include "accuracy_report.hpp"

#include <cmath>
#include <cstdio>

#include "console.hpp"
#include "gnosphere/options.hpp"
#include "json.hpp"
#include "plot.hpp"

namespace gnosphere::cli {
namespace {

/// Names the part of `standard` that this row replaces.
const char* insteadOf(const AccuracyRow& row) {
  const AccuracyParts standard = accuracyPartsOf(Accuracy::standard);
  if (row.accuracyParts.bounds != standard.bounds) return "edge bulge, poles";
  if (row.accuracyParts.cull != standard.cull) return "nearest point";
  if (row.accuracyParts.inside != standard.inside) return "watertight edges";
  if (row.accuracyParts.range != standard.range) return "edge weights";
  return "";
}

const TableRow kErrorColumns = {"time",  "ratio", "missed", "false",     "owner",
                                "range", "wrong", "max m",  "99.99 % m", "RMS m"};

TableRow errorRow(const AccuracyRow& row) {
  const Comparison& e = row.error;
  return {row.name,
          milliseconds(row.time().median),
          ratioText(row.ratio),
          grouped(e.missed),
          grouped(e.falseHits),
          grouped(e.wrongOwner),
          grouped(e.wrongRange),
          percent(row.wrongShare()),
          metres(e.hitErrorMax),
          metres(e.rangeError9999),
          metres(e.rangeErrorRms)};
}

TableRow headed(const char* name, const TableRow& columns) {
  TableRow row = {name};
  row.insert(row.end(), columns.begin(), columns.end());
  return row;
}

void printErrors(const AccuracyReport& report) {
  std::vector<TableRow> rows = {headed("setting", kErrorColumns)};
  for (const AccuracyRow& row : report.settings) rows.push_back(errorRow(row));
  printTable(rows);
  if (report.parts.empty()) return;
  std::printf("\nwhat each part of standard buys: standard, with that part replaced by a cheaper one\n");
  rows = {headed("with only", kErrorColumns)};
  rows[0].insert(rows[0].begin() + 1, "instead of");
  for (const AccuracyRow& row : report.parts) {
    rows.push_back(errorRow(row));
    rows.back().insert(rows.back().begin() + 1, insteadOf(row));
  }
  printTable(rows, 2);
}

void printTimes(const AccuracyReport& report) {
  std::printf("\ntimes in detail, in ms: %s%u runs\n", stamped(report.settings[0]) ? "device time, " : "wall time, ",
              report.runs);
  std::vector<TableRow> rows = {{"setting", "median", "min", "10 %", "90 %"}};
  for (const StageTime& stage : report.settings[0].stages) rows[0].push_back(stage.name);
  rows[0].push_back("wall");
  const auto add = [&](const AccuracyRow& row) {
    const Spread& time = row.time();
    TableRow cells = {row.name};
    for (double ms : {time.median, time.min, time.p10, time.p90}) cells.push_back(bareMs(ms));
    for (const StageTime& stage : row.stages) cells.push_back(bareMs(stage.ms));
    cells.push_back(bareMs(row.wallMs.median));
    rows.push_back(cells);
  };
  for (const AccuracyRow& row : report.settings) add(row);
  for (const AccuracyRow& row : report.parts) add(row);
  printTable(rows);
}

void printTies(const AccuracyReport& report) {
  const uint64_t ties = report.settings[0].error.ties;
  std::printf("\ninside ties: %s beams where rounding may change the answer, not counted above\n",
              grouped(ties).c_str());
  if (ties == 0) return;
  std::vector<TableRow> rows = {{"setting", "missed", "false", "owner", "max error"}};
  for (const AccuracyRow& row : report.settings) {
    const Comparison& e = row.error;
    rows.push_back(
        {row.name, grouped(e.tieMissed), grouped(e.tieFalseHits), grouped(e.tieWrongOwner), metres(e.tieErrorMax)});
  }
  printTable(rows);
}

void printNearest(const AccuracyReport& report) {
  if (report.sampled) return;
  std::printf("\ndistance to the nearest point of the reference's cloud, as in the paper's Table 5: points\n");
  std::vector<TableRow> rows = {{"m"}};
  for (const AccuracyRow& row : report.settings) rows[0].push_back(row.name);
  for (size_t bin = 0; bin <= kNearestBins.size(); ++bin) {
    const double from = bin ? kNearestBins[bin - 1] : 0;
    rows.push_back({bin < kNearestBins.size() ? formatted("%.1f-%.1f", from, kNearestBins[bin])
                                              : formatted("%.1f or more", from)});
    for (const AccuracyRow& row : report.settings) rows.back().push_back(grouped(row.nearest[bin]));
  }
  printTable(rows);
}

/// Marker and colour of a setting (colours of Okabe and Ito, distinct for colour-blind readers, too).
PlotSeries look(size_t setting) {
  static const PlotSeries kLooks[] = {
      {"", Marker::cross, "#d55e00", "none", 6.5, {}},
      {"", Marker::triangle, "#0072b2", "none", 6.5, {}},
      {"", Marker::circle, "#009e73", "none", 6.5, {}},
      {"", Marker::square, "#222222", "none", 6.5, {}},
  };
  PlotSeries series = kLooks[setting % std::size(kLooks)];
  series.name = accuracySettings()[setting].name;
  return series;
}

PlotPanel panelOf(const AccuracyStory& story, const char* title, const char* yLabel,
                  double (*error)(const AccuracyRow&)) {
  const AccuracyReport& report = story.report;
  PlotPanel panel = {
      title, stamped(report.settings[0]) ? "device time of a scan, ms" : "time of a scan, ms", yLabel, {}};
  const auto point = [&](const AccuracyRow& row, const std::string& label) {
    const Spread& time = row.time();
    return PlotPoint{time.median, error(row), time.p10, time.p90, label};
  };
  for (size_t i = 0; i < report.settings.size(); ++i) {
    panel.series.push_back(look(i));
    panel.series.back().points = {point(report.settings[i], report.settings[i].name)};
  }
  PlotSeries parts = {"parts", Marker::diamond, "#777777", "none", 3.5, {}};
  for (const AccuracyRow& row : report.parts) parts.points.push_back(point(row, row.name));
  panel.series.push_back(parts);
  return panel;
}

}  // namespace

void printTables(const AccuracyStory& story) {
  const AccuracyReport& report = story.report;
  sayHead(story);
  say("compared", grouped(report.beams) + " beams" + (report.sampled ? ", a sample," : "") +
                      " with the double-precision reference; " + grouped(report.settings[0].error.hits) +
                      " of them hit, " + grouped(report.settings[0].error.ties) +
                      " are ties, which are counted separately");
  if (const Comparison& first = report.settings[0].error; first.ties * 10 > first.hits)
    say("ties",
        "so many that the tables leave much out; triangles of many kilometres make a tie of every beam, and the "
        "largest errors stand below, inside ties");
  if (!report.withoutPaper.empty()) say("paper", "left out: " + report.withoutPaper);
  say("timed", std::string(stamped(report.settings[0]) ? "device time" : "wall time") + ", median of " +
                   grouped(report.runs) + " runs of each, in turn; ratio to standard, run by run (10-90 %)");
  std::printf("\n");
  printErrors(report);
  std::printf(
      "\nmissed, false: only the reference hits, only the setting hits; owner: both hit, but different triangles;\n"
      "range: both hit, but at ranges that differ by more than single precision explains;\n"
      "wrong: share of beams that are missed, false or at a wrong range; max: largest range error of any beam;\n"
      "99.99 %%, RMS: range errors of beams with the right triangle; ties are excluded\n");
  printTimes(report);
  printTies(report);
  printNearest(report);
}

std::string jsonOf(const AccuracyStory& story) {
  const AccuracyReport& report = story.report;
  Json json = headJson(story);
  json["beams"] = report.beams;
  json["sampled"] = report.sampled;
  if (!report.withoutPaper.empty()) json["without_paper"] = report.withoutPaper;
  for (const AccuracyRow& row : report.settings) json["settings"].push_back(toJson(row, report.runs, !report.sampled));
  json["parts"] = Json::array();
  for (const AccuracyRow& row : report.parts) {
    json["parts"].push_back(toJson(row, report.runs, !report.sampled));
    json["parts"].back()["instead_of"] = insteadOf(row);
  }
  return dump(json);
}

std::string svgOf(const AccuracyStory& story) {
  const AccuracyReport& report = story.report;
  Plot plot;
  plot.title = "What accuracy costs: error over time";
  plot.notes = {
      story.sensor.name + ", " + grouped(story.scene.placedTriangleCount()) + " triangles, " + story.posesText() +
          ", " + grouped(report.beams) + " beams compared with the double-precision reference, ties left out",
      report.device.name + formatted("; medians of %u runs, bars from the 10th to the 90th percentile", report.runs)};
  if (!report.parts.empty()) plot.notes.push_back("small diamonds: standard with one of its parts taken away");
  plot.panelHeight = 290;
  plot.panels = {panelOf(story, "Beams with a wrong answer: missed, false or at another range", "% of beams",
                         [](const AccuracyRow& row) { return 100 * row.wrongShare(); }),
                 panelOf(story, "Largest range error of a beam that hits", "m",
                         [](const AccuracyRow& row) { return row.error.hitErrorMax; })};
  return toSvg(plot);
}

}  // namespace gnosphere::cli
