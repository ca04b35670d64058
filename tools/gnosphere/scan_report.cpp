// SPDX-License-Identifier: Apache-2.0
#include "scan_report.hpp"

#include <algorithm>

#include "base/json_text.hpp"
#include "console.hpp"
#include "json.hpp"
#include "pose_text.hpp"
#include "scanning.hpp"

namespace gnosphere::cli {
namespace {

template <class Get>
std::vector<double> collect(const std::vector<Timings>& runs, Get get) {
  std::vector<double> values;
  for (const Timings& run : runs) values.push_back(get(run));
  return values;
}

struct Stage {
  std::string name;
  double medianMs;
};

/// Medians over the runs, in the order of the steps; empty if the device has no timestamps.
std::vector<Stage> stages(const ScanReport& report) {
  std::vector<Stage> list;
  for (size_t s = 0; s < report.scan.timings.stages.size(); ++s) {
    list.push_back({report.scan.timings.stages[s].name, spreadOf(collect(report.runs, [&](const Timings& run) {
                                                          return s < run.stages.size() ? run.stages[s].ms : 0.0;
                                                        })).median});
  }
  return list;
}

Json medianAndMin(const std::vector<double>& values) {
  const Spread spread = spreadOf(values);
  return {{"median", spread.median}, {"min", spread.min}};
}

Json choiceJson(const AccuracyChoice& choice) {
  Json rows = Json::array();
  for (const AccuracyRow& row : choice.report.settings) rows.push_back(toJson(row, choice.report.runs, false));
  return {{"limit_m", choice.limit},
          {"error_m", choice.chosen->errorBound()},
          {"beams", choice.report.beams},
          {"sampled", choice.report.sampled},
          {"why", choice.why},
          {"settings", rows}};
}

struct NamedCount {
  const char* name;
  uint64_t Counters::*count;
};

constexpr NamedCount kCounters[] = {
    {"beams", &Counters::beams},
    {"hits", &Counters::hits},
    {"misses", &Counters::misses},
    {"triangles", &Counters::triangles},
    {"non_finite", &Counters::nonFinite},
    {"degenerate", &Counters::degenerate},
    {"culled_by_cluster", &Counters::culledByCluster},
    {"reused", &Counters::reused},
    {"culled_by_range", &Counters::culledByRange},
    {"culled_by_face", &Counters::culledByFace},
    {"culled_between_beams", &Counters::culledBetweenBeams},
    {"culled_hidden", &Counters::culledHidden},
    {"projected", &Counters::projected},
    {"candidates", &Counters::candidates},
    {"integer_sides", &Counters::integerSides},
    {"integer_ranges", &Counters::integerRanges},
    {"lost_echoes", &Counters::lostEchoes},
    {"retries", &Counters::retries},
};
static_assert(std::size(kCounters) * sizeof(uint64_t) + sizeof(Counters::causes) == sizeof(Counters),
              "every count has a name");

/// Names in the order of Cause.
constexpr const char* kCauses[kCauseCount] = {"returned",    "no_surface", "weak",     "attenuated",
                                              "dropped_out", "dead",       "too_near", "not_chosen"};

Json countersJson(const Counters& counters) {
  Json json;
  for (const NamedCount& counter : kCounters) json[counter.name] = counters.*counter.count;
  for (size_t i = 0; i < kCauseCount; ++i) json["causes"][kCauses[i]] = counters.causes[i];
  return json;
}

Json frameJson(const TrajectoryScan& scan) {
  Json times = Json::object();
  for (const StageTime& stage : scan.timings.stages) times[stage.name] = stage.ms;
  return {{"pose", toJson(scan.pose)},
          {"wall_ms", scan.timings.wallMs},
          {"gpu_ms", times.empty() ? Json() : Json(scan.timings.gpuMs)},
          {"stages_ms", times},
          {"counters", countersJson(scan.counters)}};
}

/// Returns a share in per cent. One that is not the whole is not rounded to it.
std::string shareOf(uint64_t part, uint64_t whole) {
  if (whole == 0) return "-";
  const double percent = 100.0 * static_cast<double>(part) / static_cast<double>(whole);
  return part < whole && percent >= 99.95 ? "more than 99.9 %" : formatted("%.1f %%", percent);
}

/// `many`: the counters are those of several scans.
void printTriangles(const Counters& c, bool many) {
  std::string text = grouped(c.triangles) + (many ? " placed in all scans together" : " placed");
  const auto add = [&](uint64_t count, const char* why) {
    if (count > 0) text += ", " + grouped(count) + " " + why;
  };
  add(c.projected, "projected");
  add(c.culledByCluster, "culled in clusters");
  add(c.reused, "as in the scan before");
  add(c.culledByRange, "out of range");
  add(c.culledByFace, "facing away");
  add(c.culledBetweenBeams, "between the beams");
  add(c.culledHidden, "hidden");
  add(c.degenerate, "degenerate");
  add(c.nonFinite, "not finite");
  say("triangles", text);
}

void printTimes(const ScanReport& report) {
  const auto wall = collect(report.runs, [](const Timings& run) { return run.wallMs; });
  std::string text = milliseconds(spreadOf(wall).median);
  // Drivers of CPUs compile a kernel when it first runs.
  if (report.trajectory.empty() && wall.size() == 1 && report.simulator.device().type != "reference")
    text += ", the first scan, in which the driver may still compile; --repeat times further ones";
  if (wall.size() > 1) {
    text += " median of " + grouped(wall.size()) + " scans, " +
            milliseconds(*std::min_element(wall.begin(), wall.end())) + " at best";
  }
  if (!report.trajectory.empty() && report.simulator.device().type != "reference")
    text += "; scans that are submitted together share their time, and the first may include compilation";
  std::string separator = "; on the device ";
  for (const Stage& stage : stages(report)) {
    text += separator + stage.name + " " + milliseconds(stage.medianMs);
    separator = ", ";
  }
  say("time", text);
}

/// Beams that fire and have no return, by cause; empty if no effect can lose one. `masked` is the number of those that
/// do not fire.
std::string lostText(Counters counters, uint64_t masked) {
  constexpr const char* kWords[kCauseCount] = {"",     "met nothing", "too weak",  "attenuated", "dropped out",
                                               "dead", "too near",    "not chosen"};
  uint64_t& dead = counters.causes[static_cast<size_t>(Cause::dead)];
  dead -= std::min(dead, masked);  // causes are not counted where no effect loses beams
  std::string text;
  for (size_t i = 1; i < kCauseCount; ++i)
    if (counters.causes[i] > 0) text += (text.empty() ? "" : ", ") + grouped(counters.causes[i]) + " " + kWords[i];
  if (counters.lostEchoes > 0)
    text += (text.empty() ? "" : "; ") + counted(counters.lostEchoes, "echo", "echoes") + " more than a beam keeps";
  return text;
}

/// Whether the summary tells that an effect is out: it was asked for, or the sensor states a range at 10 % that nothing
/// uses.
bool isMissing(const Plan::Decision& decision, const Sensor& sensor) {
  const bool states = decision.effect == "detection" && sensor.rangeAt10Percent > 0;
  return decision.leftOut || (states && !decision.in && decision.request == EffectUse::automatic);
}

/// Prints the names and reasons of the effects that `chosen` chooses, one per line.
template <class Chosen>
void printEffects(const char* label, const Plan& plan, const Chosen& chosen) {
  for (const Plan::Decision& decision : plan.effects) {
    if (!chosen(decision)) continue;
    say(label, formatted("%-15s ", decision.effect.c_str()) + decision.reason);
    label = "";
  }
}

}  // namespace

void printSummary(const ScanReport& report) {
  const Scene& scene = report.scene;
  const DeviceInfo& device = report.simulator.device();
  const Vec3& at = report.scan.pose.position;
  const Bounds bounds = worldBounds(scene);
  const Counters& counters = report.scan.counters;
  say("scene", report.sceneFile + ": " + counted(scene.placedTriangleCount(), "triangle", "triangles") + " (" +
                   grouped(scene.uniqueTriangleCount()) + " unique) in " +
                   counted(scene.instances.size(), "instance", "instances") +
                   (bounds.empty() ? "" : ", " + extentText(bounds)) + ", loaded in " + milliseconds(report.loadMs));
  std::string about = device.name;
  if (device.type != device.name) about += ", " + device.type;
  if (!device.driver.empty()) about += ", " + device.driver;
  say("device", about + ", ready in " + milliseconds(report.setUpMs));
  const bool moves = !report.trajectory.empty();
  const std::string turn = turnText(report.scan.pose.orientation);
  const uint32_t channels = report.sensor.height(), columns = report.sensor.width();
  const std::string cloud =
      channels == 1 ? grouped(columns) + " beams" : grouped(channels) + " channels x " + grouped(columns) + " columns";
  say("sensor", report.sensor.name + report.head +
                    (moves ? " at " + counted(report.trajectory.size(), "pose", "poses") + ": "
                           : " at " + placeText(at) + (turn.empty() ? "" : ", ") + turn + ": ") +
                    cloud + ", " + coordinateText(report.sensor.rangeMin) + ".." +
                    coordinateText(report.sensor.rangeMax) + " m");
  const Plan plan = report.simulator.plan();
  printEffects("effects", plan, [](const Plan::Decision& decision) { return decision.in; });
  printEffects("left out", plan, [&](const Plan::Decision& decision) { return isMissing(decision, report.sensor); });
  const uint64_t masked = maskedBeams(report.sensor) * (counters.beams / report.sensor.beamCount());
  say("hits",
      grouped(counters.hits) + " of " + grouped(counters.beams) + " beams (" + shareOf(counters.hits, counters.beams) +
          ")" +
          (report.ofMedium == 0 ? "" : ", " + grouped(report.ofMedium) + " of them by " + report.media + " alone") +
          maskedText(masked));
  if (const std::string lost = lostText(counters, masked); !lost.empty()) say("lost", lost);
  printTriangles(counters, report.trajectory.size() > 1);
  printTimes(report);
  if (moves)
    say("rate", formatted("%.1f scans a second", 1000 * static_cast<double>(report.runs.size()) / report.totalMs) +
                    " with writing files, in " + milliseconds(report.totalMs));
}

std::string statsJson(const ScanReport& report) {
  const MemoryUse memory = report.simulator.memory();
  Json stats;
  stats["made_by"] = report.madeBy;
  stats["device"] = toJson(report.simulator.device());
  stats["scene"] = {{"file", report.sceneFile}};
  stats["scene"].update(sceneJson(report.scene));
  stats["scene"].update({{"clusters", report.simulator.clusterCount()},
                         {"bytes", memory.scene},
                         {"load_ms", report.loadMs},
                         {"set_up_ms", report.setUpMs}});
  stats["sensor"] = sensorJson(report.sensor);
  stats["sensor"]["bytes"] = memory.sensor;
  if (report.trajectory.empty()) stats["pose"] = toJson(report.scan.pose);
  Json times = Json::object();
  for (const Stage& stage : stages(report)) {
    times[stage.name] = stage.medianMs;
  }
  stats["plan"] = parseJson<Json>(toJson(report.simulator.plan()));
  stats["plan"]["accuracy"] = report.accuracy;
  if (report.choice) stats["plan"]["max_error"] = choiceJson(*report.choice);
  const auto wall = collect(report.runs, [](const Timings& run) { return run.wallMs; });
  const auto gpu = collect(report.runs, [](const Timings& run) { return run.gpuMs; });
  stats["frame"] = {{"runs", report.runs.size()},
                    {"wall_ms", medianAndMin(wall)},
                    {"gpu_ms", times.empty() ? Json() : medianAndMin(gpu)},  // null if the device has no timestamps
                    {"stages_ms", times}};
  if (report.trajectory.empty()) {
    stats["counters"] = countersJson(report.scan.counters);
  } else {
    stats["frame"]["total_ms"] = report.totalMs;  // all scans, including writing files
    for (const TrajectoryScan& scan : report.trajectory) stats["frames"].push_back(frameJson(scan));
  }
  return dump(stats);
}

}  // namespace gnosphere::cli
