// SPDX-License-Identifier: Apache-2.0
#include "scan_trajectory.hpp"

#include <algorithm>
#include <filesystem>

#include "console.hpp"

namespace gnosphere::cli {

std::string numbered(const std::string& file, size_t number) {
  const std::filesystem::path path(file);
  const std::string name = path.stem().string() + formatted("-%06zu", number) + path.extension().string();
  return (path.parent_path() / name).string();
}

std::vector<TrajectoryScan> scanTrajectory(Simulator& simulator, const std::vector<Pose>& poses,
                                           const std::function<void(size_t, const Scan&)>& write) {
  std::vector<Shot> shots;
  for (const Pose& pose : poses) shots.push_back({pose});
  std::vector<TrajectoryScan> scans;
  Progress progress("scan", poses.size());
  simulator.scanAll(shots, [&](size_t i, const Scan& scan) {
    progress.step(i + 1);
    write(i, scan);
    scans.push_back({scan.pose, scan.counters, scan.timings});
  });
  return scans;
}

Scan summaryOf(const std::vector<TrajectoryScan>& scans, const Sensor& sensor) {
  Scan sum;
  sum.sensor = sensor.name;
  sum.columns = sensor.columns;
  sum.channels = static_cast<uint32_t>(sensor.channels.size());
  sum.pose = scans.front().pose;
  sum.timings = scans.front().timings;
  for (const TrajectoryScan& scan : scans) {
    sum.counters.beams += scan.counters.beams;
    sum.counters.hits += scan.counters.hits;
    sum.counters.misses += scan.counters.misses;
    sum.counters.retries += scan.counters.retries;
    sum.counters.nonFinite = std::max(sum.counters.nonFinite, scan.counters.nonFinite);
  }
  return sum;
}

}  // namespace gnosphere::cli
