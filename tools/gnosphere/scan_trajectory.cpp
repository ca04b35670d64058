// SPDX-License-Identifier: Apache-2.0
#include "scan_trajectory.hpp"

#include <algorithm>
#include <filesystem>

#include "base/path.hpp"
#include "console.hpp"
#include "sensor/beams.hpp"

namespace gnosphere::cli {

std::string numbered(const std::string& file, size_t number) {
  const std::filesystem::path path = pathOf(file);
  const std::string name = path.stem().string() + formatted("-%06zu", number) + path.extension().string();
  return (path.parent_path() / pathOf(name)).string();
}

namespace {

/// Returns the poses around a scan of `duration` seconds that starts at number `first`, with times relative to its
/// start.
SensorMotion motionFrom(const std::vector<SensorMotion::Stamp>& trajectory, size_t first, double duration) {
  SensorMotion motion;
  const double start = trajectory[first].time;
  for (size_t i = first; i < trajectory.size(); ++i) {
    const double time = trajectory[i].time - start;
    if (i > first && !(trajectory[i].time > trajectory[i - 1].time))
      throw Error(ErrorCode::format,
                  formatted("the trajectory's time %.10g does not come after %.10g; the sensor moves while "
                            "it turns, which needs ascending times, or --effect sensor-motion=off",
                            trajectory[i].time, trajectory[i - 1].time));
    motion.stamps.push_back({time, trajectory[i].pose});
    if (time >= duration) break;
  }
  return motion;
}

}  // namespace

std::vector<TrajectoryScan> scanTrajectory(Simulator& simulator, const Sensor& sensor,
                                           const std::vector<SensorMotion::Stamp>& trajectory,
                                           const std::function<void(size_t, const Scan&)>& write) {
  std::vector<Shot> shots;
  const bool moves = firesInTurn(sensor) && simulator.plan().has("sensor-motion");
  for (size_t i = 0; i < trajectory.size(); ++i) {
    Shot& shot = shots.emplace_back();
    shot.pose = trajectory[i].pose;
    shot.frame = i;
    if (moves) shot.motion = motionFrom(trajectory, i, durationOf(sensor, i));
  }
  std::vector<TrajectoryScan> scans;
  Progress progress("scan", trajectory.size());
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
    const uint64_t nonFinite = std::max(sum.counters.nonFinite, scan.counters.nonFinite);
    sum.counters += scan.counters;
    sum.counters.nonFinite = nonFinite;
  }
  return sum;
}

}  // namespace gnosphere::cli
