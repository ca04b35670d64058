// SPDX-License-Identifier: Apache-2.0
#include "scan_report.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "console.hpp"

namespace gnosphere::cli {
namespace {

using Json = nlohmann::ordered_json;

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const size_t half = values.size() / 2;
  return values.size() % 2 ? values[half] : (values[half - 1] + values[half]) / 2;
}

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

/// Medians over the runs, in the order of the pipeline; empty where the device has no timestamps.
std::vector<Stage> stages(const ScanReport& report) {
  std::vector<Stage> list;
  for (size_t s = 0; s < report.scan.timings.stages.size(); ++s) {
    list.push_back({report.scan.timings.stages[s].name, median(collect(report.runs, [&](const Timings& run) {
                      return s < run.stages.size() ? run.stages[s].ms : 0.0;
                    }))});
  }
  return list;
}

Json medianAndMin(const std::vector<double>& values) {
  return {{"median", median(values)}, {"min", *std::min_element(values.begin(), values.end())}};
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
    {"culled_by_range", &Counters::culledByRange},
    {"culled_by_face", &Counters::culledByFace},
    {"culled_between_beams", &Counters::culledBetweenBeams},
    {"projected", &Counters::projected},
    {"candidates", &Counters::candidates},
    {"retries", &Counters::retries},
};

std::string percent(uint64_t part, uint64_t whole) {
  return whole ? formatted("%.1f %%", 100.0 * static_cast<double>(part) / static_cast<double>(whole)) : "-";
}

void printTriangles(const Counters& c) {
  std::string text = grouped(c.triangles) + " placed";
  const auto add = [&](uint64_t count, const char* why) {
    if (count > 0) text += ", " + grouped(count) + " " + why;
  };
  add(c.projected, "projected");
  add(c.culledByCluster, "culled in clusters");
  add(c.culledByRange, "out of range");
  add(c.culledByFace, "facing away");
  add(c.culledBetweenBeams, "between the beams");
  add(c.degenerate, "degenerate");
  add(c.nonFinite, "not finite");
  say("triangles", text);
}

void printTimes(const ScanReport& report) {
  const auto wall = collect(report.runs, [](const Timings& run) { return run.wallMs; });
  std::string text = milliseconds(median(wall));
  if (wall.size() > 1) {
    text += " median of " + grouped(wall.size()) + " scans, " +
            milliseconds(*std::min_element(wall.begin(), wall.end())) + " at best";
  }
  std::string separator = "; on the device ";
  for (const Stage& stage : stages(report)) {
    text += separator + stage.name + " " + milliseconds(stage.medianMs);
    separator = ", ";
  }
  say("time", text);
}

}  // namespace

void printSummary(const ScanReport& report) {
  const Scene& scene = report.scene;
  const DeviceInfo& device = report.simulator.device();
  const Vec3& at = report.scan.pose.position;
  const Counters& counters = report.scan.counters;
  say("scene", report.sceneFile + ": " + grouped(scene.placedTriangleCount()) + " triangles (" +
                   grouped(scene.uniqueTriangleCount()) + " unique) in " + grouped(scene.instances.size()) +
                   " instances, loaded in " + milliseconds(report.loadMs));
  std::string about = device.name;
  if (device.type != device.name) about += ", " + device.type;
  if (!device.driver.empty()) about += ", " + device.driver;
  say("device", about + ", ready in " + milliseconds(report.setUpMs));
  say("sensor", report.sensor.name + formatted(" at %.10g, %.10g, %.10g: ", at.x, at.y, at.z) +
                    grouped(report.scan.channels) + " channels x " + grouped(report.scan.columns) + " columns, " +
                    formatted("%g..%g m", report.sensor.rangeMin, report.sensor.rangeMax));
  say("hits", grouped(counters.hits) + " of " + grouped(counters.beams) + " beams (" +
                  percent(counters.hits, counters.beams) + ")");
  printTriangles(counters);
  printTimes(report);
}

std::string statsJson(const ScanReport& report) {
  const DeviceInfo& device = report.simulator.device();
  const MemoryUse memory = report.simulator.memory();
  Json stats;
  stats["device"] = {{"name", device.name},
                     {"type", device.type},
                     {"driver", device.driver},
                     {"api_version", device.apiVersion},
                     {"max_buffer_bytes", device.maxBufferBytes},
                     {"subgroup_size", device.subgroupSize}};
  stats["scene"] = {{"file", report.sceneFile},
                    {"triangles", report.scene.placedTriangleCount()},
                    {"unique_triangles", report.scene.uniqueTriangleCount()},
                    {"instances", report.scene.instances.size()},
                    {"meshes", report.scene.meshes.size()},
                    {"clusters", report.simulator.clusterCount()},
                    {"bytes", memory.scene},
                    {"load_ms", report.loadMs},
                    {"set_up_ms", report.setUpMs}};
  stats["sensor"] = {{"name", report.sensor.name},
                     {"beams", report.sensor.beamCount()},
                     {"columns", report.sensor.columns},
                     {"channels", report.sensor.channels.size()},
                     {"range", {{"min", report.sensor.rangeMin}, {"max", report.sensor.rangeMax}}},
                     {"bytes", memory.sensor}};
  const Pose& pose = report.scan.pose;
  stats["pose"] = {
      {"position", {pose.position.x, pose.position.y, pose.position.z}},
      {"orientation_xyzw", {pose.orientation.x, pose.orientation.y, pose.orientation.z, pose.orientation.w}}};
  Json names = Json::array();
  Json times = Json::object();
  for (const Stage& stage : stages(report)) {
    names.push_back(stage.name);
    times[stage.name] = stage.medianMs;
  }
  stats["plan"] = {
      {"stages", names}, {"accuracy", report.accuracy}, {"binning", report.binning}, {"bytes", memory.work}};
  const auto wall = collect(report.runs, [](const Timings& run) { return run.wallMs; });
  const auto gpu = collect(report.runs, [](const Timings& run) { return run.gpuMs; });
  stats["frame"] = {{"runs", report.runs.size()},
                    {"wall_ms", medianAndMin(wall)},
                    {"gpu_ms", times.empty() ? Json() : medianAndMin(gpu)},  // null: the device has no timestamps
                    {"stages_ms", times}};
  for (const NamedCount& counter : kCounters) stats["counters"][counter.name] = report.scan.counters.*counter.count;
  return stats.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace gnosphere::cli
