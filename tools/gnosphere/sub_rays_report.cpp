// SPDX-License-Identifier: Apache-2.0
#include "sub_rays_report.hpp"

#include <cstdio>

#include "console.hpp"
#include "json.hpp"
#include "plot.hpp"

namespace gnosphere::cli {
namespace {

std::string nameOf(const SubRayRow& row) {
  return row.subRays == 0 ? "clean" : grouped(row.subRays);
}

TableRow cellsOf(const SubRayRow& row) {
  TableRow cells = {nameOf(row), milliseconds(row.time().median), ratioText(row.ratio)};
  if (row.subRays == 0) {
    cells.resize(cells.size() + 8, "-");
    return cells;
  }
  cells.insert(cells.end(), {percent(row.wrong), percent(row.wrongRange), percent(row.wrongReturns),
                             metres(row.rangeErrorMax), metres(row.rangeError999), metres(row.rangeErrorRms),
                             percent(row.intensityErrorMedian), percent(row.intensityError99)});
  return cells;
}

Json rowJson(const SubRayRow& row, uint32_t runs) {
  Json json;
  json["sub_rays"] = row.subRays;
  json["frame"] = {{"runs", runs},
                   {"wall_ms", cli::toJson(row.wallMs)},
                   {"gpu_ms", stamped(row) ? cli::toJson(row.gpuMs) : Json()},
                   {"ratio_to_clean", row.ratio.median},
                   {"ratio_p10", row.ratio.p10},
                   {"ratio_p90", row.ratio.p90}};
  if (row.subRays == 0) return json;
  json["error"] = {
      {"beams", row.beams},
      {"wrong_share", row.wrong},
      {"wrong_range_share", row.wrongRange},
      {"wrong_returns_share", row.wrongReturns},
      {"range_error_m", {{"max", row.rangeErrorMax}, {"p99_9", row.rangeError999}, {"rms", row.rangeErrorRms}}},
      {"intensity_error", {{"median", row.intensityErrorMedian}, {"p99", row.intensityError99}}}};
  return json;
}

PlotPanel panelOf(const SubRaysStory& story, const char* title, const char* yLabel, double (*error)(const SubRayRow&)) {
  const SubRayReport& report = story.report;
  PlotPanel panel = {title, stamped(report.rows[0]) ? "device time of a scan, ms" : "time of a scan, ms", yLabel, {}};
  PlotSeries series = {"sub-rays", Marker::circle, "#009e73", "4 2", 5, {}};
  for (const SubRayRow& row : report.rows) {
    if (row.subRays == 0) continue;
    const Spread& time = row.time();
    series.points.push_back({time.median, error(row), time.p10, time.p90, nameOf(row)});
  }
  panel.series = {series};
  return panel;
}

}  // namespace

void printTables(const SubRaysStory& story) {
  const SubRayReport& report = story.report;
  sayHead(story);
  say("footprint", report.footprint);
  say("compared", grouped(report.beams) + " beams" + (report.sampled ? ", a sample," : "") +
                      formatted(" with %u sub-rays of the double-precision reference", report.truth));
  say("timed", std::string(stamped(report.rows[0]) ? "device time" : "wall time") + ", median of " +
                   grouped(report.runs) + " runs of each, in turn; ratio to clean, run by run (10-90 %)");
  std::printf("\n");
  std::vector<TableRow> rows = {
      {"sub-rays", "time", "ratio", "wrong", "range", "returns", "max m", "99.9 % m", "RMS m", "intensity", "99 %"}};
  for (const SubRayRow& row : report.rows) rows.push_back(cellsOf(row));
  printTable(rows);
  std::printf(
      "\nclean: geometry alone; range: share of the beams with a return that is off by more than %g m%s;\n"
      "returns: share of the beams with another number of returns; wrong: share of the beams with either;\n"
      "max, 99.9 %%, RMS: errors of the range, from the nearest return of the reference; intensity, 99 %%: relative\n"
      "error of the intensity, what half and what 99 %% of the returns do not exceed. Few beams make max and RMS, so "
      "these\n"
      "differ from sample to sample\n",
      report.tolerance, ", or than the standard deviation of the noise if that is more");
}

std::string jsonOf(const SubRaysStory& story) {
  const SubRayReport& report = story.report;
  Json json = headJson(story);
  json["footprint"] = report.footprint;
  json["beams"] = report.beams;
  json["sampled"] = report.sampled;
  json["reference_sub_rays"] = report.truth;
  json["tolerance_m"] = report.tolerance;
  for (const SubRayRow& row : report.rows) json["rows"].push_back(rowJson(row, report.runs));
  return dump(json);
}

std::string svgOf(const SubRaysStory& story) {
  const SubRayReport& report = story.report;
  Plot plot;
  plot.title = "What footprints cost: error over time";
  plot.notes = {story.sensor.name + ", " + report.footprint + ", " + grouped(story.scene.placedTriangleCount()) +
                    " triangles, " + story.posesText() + ", " + grouped(report.beams) +
                    formatted(" beams compared with %u sub-rays of the reference", report.truth),
                report.device.name +
                    formatted("; medians of %u runs, bars from the 10th to the 90th percentile; numbers of sub-rays at "
                              "the points; clean takes ",
                              report.runs) +
                    milliseconds(report.rows[0].time().median)};
  plot.panelHeight = 240;
  plot.panels = {panelOf(story, "Beams with a wrong range or another number of returns", "% of beams",
                         [](const SubRayRow& row) { return 100 * row.wrong; }),
                 panelOf(story, "Range error, RMS", "m", [](const SubRayRow& row) { return row.rangeErrorRms; }),
                 panelOf(story, "Relative error of the intensity, median", "%",
                         [](const SubRayRow& row) { return 100 * row.intensityErrorMedian; })};
  return toSvg(plot);
}

}  // namespace gnosphere::cli
