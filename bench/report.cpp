// SPDX-License-Identifier: Apache-2.0
#include "report.hpp"

#include <algorithm>
#include <cstdlib>
#include <functional>

namespace gnosphere::bench {

double rounded(double value) {
  return std::strtod(cli::formatted("%.5g", value).c_str(), nullptr);
}

cli::Json medianJson(const Spread& spread) {
  return {{"median", rounded(spread.median)}, {"min", rounded(spread.min)}};
}

cli::Json errorJson(const Comparison& c) {
  return {{"missed", c.missed},
          {"false_hits", c.falseHits},
          {"wrong_owner", c.wrongOwner},
          {"wrong_range", c.wrongRange},
          {"ties", c.ties},
          {"range_error_max_m", rounded(c.rangeErrorMax)}};
}

namespace {

using cli::bareMs;
using cli::formatted;
using cli::Json;

std::string orDash(double ms) {
  return ms > 0 ? bareMs(ms) : "-";
}

std::string times(double ratio) {
  return ratio > 0 ? formatted("%.2f", ratio) : "-";
}

/// Formats a median; a star marks a large spread.
std::string medianCell(const Spread& spread) {
  const bool unsteady = spread.p90 - spread.p10 > 0.1 * spread.median;
  return bareMs(spread.median) + (unsteady ? " *" : "");
}

void addNew(const std::string& name, std::vector<std::string>& names) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

/// Names of the columns after the steps.
constexpr const char* kDevice = "device";
constexpr const char* kTotal = "total";

/// Returns the median; 0 if there is none.
double stageMs(const Standing& standing, const std::string& name) {
  if (name == kDevice) return standing.deviceMs.median;
  if (name == kTotal) return standing.totalMs.median;
  for (const StageTime& stage : standing.stages)
    if (stage.name == name) return stage.ms;
  return 0;
}

double stageRatio(const Standing& ours, const Standing& other, const std::string& name) {
  if (name == kDevice) return other.deviceRatio;
  if (name == kTotal) return other.ratio;
  const double ms = stageMs(ours, name);
  return ms > 0 ? stageMs(other, name) / ms : 0;
}

double perBeam(const Outcome& outcome) {
  return static_cast<double>(outcome.memory.sensor + outcome.memory.work) /
         static_cast<double>(std::max<size_t>(1, outcome.sensor.beamCount()));
}

double perTriangle(const Outcome& outcome) {
  return static_cast<double>(outcome.memory.scene) / static_cast<double>(std::max<size_t>(1, outcome.uniqueTriangles));
}

Json orNull(double value) {
  return value > 0 ? Json(rounded(value)) : Json();
}

/// Medians, except for the total, which has its whole spread.
Json standingJson(const Standing& s) {
  Json stages = Json::object();
  for (const StageTime& stage : s.stages) stages[stage.name] = rounded(stage.ms);
  Json json = {{"name", s.name},
               {"samples", s.samples},
               {"build_ms", orNull(s.buildMs)},
               {"renew_ms", orNull(s.renewMs.median)},
               {"scan_ms", orNull(s.scanMs.median)},
               {"device_ms", s.deviceMs.median > 0 ? medianJson(s.deviceMs) : Json()},
               {"stages_ms", stages},
               {"total_ms",
                {{"median", rounded(s.totalMs.median)},
                 {"min", rounded(s.totalMs.min)},
                 {"p10", rounded(s.totalMs.p10)},
                 {"p90", rounded(s.totalMs.p90)},
                 {"mean", rounded(s.meanMs)},
                 {"variance_across_frames", rounded(s.frameVariance)},
                 {"variance_across_runs", rounded(s.runVariance)}}},
               {"ratio_to_ours", orNull(s.ratio)},
               {"frame_ratios_to_ours", {{"least", rounded(s.leastFrameRatio)}, {"most", rounded(s.mostFrameRatio)}}},
               {"device_ratio_to_ours", orNull(s.deviceRatio)},
               {"memory_bytes", s.memoryBytes},
               {"beams_unlike_ours", s.agreement.differ()}};
  if (s.error) json["error"] = errorJson(*s.error);
  return json;
}

Json outcomeJson(const Outcome& outcome) {
  Json contenders = Json::array();
  for (const Standing& standing : outcome.standings) contenders.push_back(standingJson(standing));
  const Json floor = {{"bytes", rounded(outcome.floor.bytes)},
                      {"operations", rounded(outcome.floor.operations)},
                      {"ms", orNull(outcome.floor.ms)},
                      {"share", orNull(outcome.floorShare())}};
  return {{"label", outcome.label},
          {"x", outcome.x},
          {"scene",
           {{"triangles", outcome.placedTriangles},
            {"unique_triangles", outcome.uniqueTriangles},
            {"instances", outcome.instances},
            {"meshes", outcome.meshes}}},
          {"sensor", cli::sensorJson(outcome.sensor)},
          {"frames", outcome.frames},
          {"runs", outcome.runs},
          {"moving_instances", outcome.moving},
          {"hits", outcome.hits},
          {"floor", floor},
          {"memory",
           {{"scene_bytes", outcome.memory.scene},
            {"sensor_bytes", outcome.memory.sensor},
            {"work_bytes", outcome.memory.work},
            {"scene_bytes_per_unique_triangle", rounded(perTriangle(outcome))},
            {"bytes_per_beam", rounded(perBeam(outcome))}}},
          {"contenders", contenders}};
}

}  // namespace

Table timesTable(const std::vector<Outcome>& outcomes) {
  Table table;
  table.rows = {{"case", "who", "build ms", "renew ms", "scan ms", "device ms", "total ms", "mean ms",
                 "ours is times as fast", "by device", "differ"}};
  for (const Outcome& outcome : outcomes) {
    for (const Standing& s : outcome.standings) {
      const bool ours = &s == &outcome.standings[0];
      table.rows.push_back({outcome.label, s.name, orDash(s.buildMs), orDash(s.renewMs.median), bareMs(s.scanMs.median),
                            orDash(s.deviceMs.median), medianCell(s.totalMs), bareMs(s.meanMs),
                            ours ? "1" : times(s.ratio), ours && s.deviceMs.median > 0 ? "1" : times(s.deviceRatio),
                            ours ? "" : cli::grouped(s.agreement.differ())});
    }
  }
  table.note =
      "Medians of all frames and runs; contenders are timed in turn; total: renew + scan, with results on the host; "
      "differ: beams with another result than ours; *: 10th and 90th percentile differ by more than 10 %";
  return table;
}

Table varianceTable(const std::vector<Outcome>& outcomes) {
  Table table;
  table.rows = {
      {"case", "renderer", "mean ms", "variance across frames ms2", "across runs ms2", "ours is times as fast"}};
  for (const Outcome& outcome : outcomes)
    for (const Standing& s : outcome.standings)
      table.rows.push_back({outcome.label, s.name, formatted("%.4g", s.meanMs), formatted("%.3g", s.frameVariance),
                            formatted("%.3g", s.runVariance), times(s.ratio)});
  if (!outcomes.empty())
    table.note = formatted("%zu frames, %u runs after a warm-up", outcomes[0].frames, outcomes[0].runs);
  return table;
}

Table stagesTable(const std::vector<Outcome>& outcomes) {
  Table table;
  table.rows = {{"case", "who", "stage", "ms", "share of total"}};
  for (const Outcome& outcome : outcomes)
    for (const Standing& s : outcome.standings)
      for (const StageTime& stage : s.stages)
        table.rows.push_back({outcome.label, s.name, stage.name, bareMs(stage.ms),
                              formatted("%.0f %%", 100 * stage.ms / s.totalMs.median)});
  if (table.rows.size() == 1) table.rows.clear();
  return table;
}

Table cudaTable(const std::vector<Outcome>& outcomes) {
  Table table;
  std::vector<std::string> names;
  for (const Outcome& outcome : outcomes)
    for (const Standing& s : outcome.standings)
      if (s.name.starts_with("cuda")) addNew(s.name, names);
  if (names.empty()) return table;
  table.rows = {{"case", "stage", "Vulkan ms"}};
  for (const std::string& name : names)
    table.rows[0].insert(table.rows[0].end(), {name + " ms", "Vulkan is times as fast"});
  for (const Outcome& outcome : outcomes) {
    const Standing& vulkan = outcome.standings[0];
    std::vector<std::string> stages;
    for (const Standing& s : outcome.standings)
      if (&s == &vulkan || s.name.starts_with("cuda"))
        for (const StageTime& stage : s.stages) addNew(stage.name, stages);
    stages.insert(stages.end(), {kDevice, kTotal});
    for (const std::string& stage : stages) {
      cli::TableRow row = {outcome.label, stage, orDash(stageMs(vulkan, stage))};
      for (const std::string& name : names) {
        const auto s = std::find_if(outcome.standings.begin(), outcome.standings.end(),
                                    [&](const Standing& standing) { return standing.name == name; });
        const bool there = s != outcome.standings.end();
        row.insert(row.end(),
                   {orDash(there ? stageMs(*s, stage) : 0), times(there ? stageRatio(vulkan, *s, stage) : 0)});
      }
      table.rows.push_back(row);
    }
  }
  table.note =
      "GnoSphere by Vulkan and by CUDA on the same card, timed in turn; cuda: without fused products, so that exact "
      "has "
      "the same bytes; cuda-fast: with the defaults of nvcc";
  return table;
}

Table floorTable(const std::vector<Outcome>& outcomes) {
  Table table;
  table.rows = {{"case", "floor MB", "floor Mop", "floor ms", "mean ms", "share", "scene MB", "B per unique triangle",
                 "of 32 B a triangle + 64 B an instance", "B per beam"}};
  for (const Outcome& outcome : outcomes) {
    const double limit =
        32 * static_cast<double>(outcome.uniqueTriangles) + 64 * static_cast<double>(outcome.instances);
    const double scene = static_cast<double>(outcome.memory.scene);
    table.rows.push_back(
        {outcome.label, formatted("%.2f", outcome.floor.bytes / 1e6), formatted("%.1f", outcome.floor.operations / 1e6),
         orDash(outcome.floor.ms), bareMs(outcome.standings[0].totalMs.median),
         outcome.floor.ms > 0 ? formatted("%.1f %%", 100 * outcome.floorShare()) : "-", formatted("%.1f", scene / 1e6),
         formatted("%.1f", perTriangle(outcome)), formatted("%.0f %%", 100 * scene / std::max(1.0, limit)),
         formatted("%.1f", perBeam(outcome))});
  }
  table.note = "GnoSphere. The floor is the least data traffic and computation, at this machine's measured rates";
  return table;
}

Json toJson(const Report& report) {
  Json json = report.more;
  for (const Outcome& outcome : report.outcomes) json["outcomes"].push_back(outcomeJson(outcome));
  return json;
}

std::string compact(const Json& json) {
  constexpr size_t kWidth = 120;
  const std::function<std::string(const Json&, size_t)> lines = [&](const Json& value, size_t depth) {
    const std::string line = value.dump(-1, ' ', false, Json::error_handler_t::replace);
    if (value.empty() || !value.is_structured() || 2 * depth + line.size() <= kWidth) return line;
    const std::string indent(2 * depth + 2, ' ');
    std::string text;
    for (const auto& [key, item] : value.items())
      text += (text.empty() ? "\n" : ",\n") + indent + (value.is_object() ? Json(key).dump() + ": " : "") +
              lines(item, depth + 1);
    const std::string end = "\n" + indent.substr(2);
    return (value.is_object() ? "{" : "[") + text + end + (value.is_object() ? "}" : "]");
  };
  return lines(json, 0) + "\n";
}

cli::Plot plotOf(const Report& report, const std::string& title, const DeviceInfo& device) {
  static const std::pair<cli::Marker, const char*> kLooks[] = {{cli::Marker::circle, "#009e73"},
                                                               {cli::Marker::cross, "#d55e00"},
                                                               {cli::Marker::triangle, "#0072b2"},
                                                               {cli::Marker::square, "#222222"},
                                                               {cli::Marker::diamond, "#cc79a7"}};
  cli::PlotPanel panel = {"", report.xLabel, "ms per frame, median", {}};
  if (!report.panel.series.empty()) panel = report.panel;
  for (const Outcome& outcome : report.outcomes) {
    for (const Standing& s : outcome.standings) {
      auto series = std::find_if(panel.series.begin(), panel.series.end(),
                                 [&](const cli::PlotSeries& other) { return other.name == s.name; });
      if (series == panel.series.end()) {
        const auto& [marker, colour] = kLooks[panel.series.size() % std::size(kLooks)];
        const char* dash = panel.series.size() < std::size(kLooks) ? "" : "4 2";
        panel.series.push_back({s.name, marker, colour, dash, 4, {}});
        series = panel.series.end() - 1;
      }
      series->points.push_back({outcome.x, s.totalMs.median, 0, 0, ""});
    }
  }
  cli::Plot plot;
  plot.title = title;
  plot.notes = {device.name};
  plot.panels = {panel};
  plot.legend = true;
  return plot;
}

}  // namespace gnosphere::bench
