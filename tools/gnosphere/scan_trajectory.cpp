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

/// Returns the poses around a scan that starts at number `start`, with times relative to its start: those within
/// `span`, and the nearest ones before and after it.
SensorMotion motionAround(const std::vector<SensorMotion::Stamp>& trajectory, size_t start, const TimeSpan& span) {
  const double zero = trajectory[start].time;
  const auto timeOf = [&](size_t i) { return trajectory[i].time - zero; };
  const auto checkAscent = [&](size_t i) {
    if (!(trajectory[i].time > trajectory[i - 1].time))
      throw Error(ErrorCode::format,
                  formatted("the trajectory's time %.10g does not come after %.10g; the sensor moves while "
                            "it turns, which needs ascending times, or --effect sensor-motion=off",
                            trajectory[i].time, trajectory[i - 1].time));
  };
  size_t first = start, last = start;
  for (; first > 0 && timeOf(first) > span.from; --first) checkAscent(first);
  for (; last + 1 < trajectory.size() && timeOf(last) < span.to; ++last) checkAscent(last + 1);
  if (first == last && first > 0) checkAscent(first--);  // for the speed of the last scan
  SensorMotion motion;
  for (size_t i = first; i <= last; ++i) motion.stamps.push_back({timeOf(i), trajectory[i].pose});
  return motion;
}

/// Returns the poses before and after a scan that starts at number `start`, for the speed of a sensor that does not
/// move within the scan; none where the times about it do not ascend.
SensorMotion speedAround(const std::vector<SensorMotion::Stamp>& trajectory, size_t start) {
  const SensorMotion::Stamp &before = trajectory[start > 0 ? start - 1 : 0],
                            &after = trajectory[std::min(start + 1, trajectory.size() - 1)];
  const double zero = trajectory[start].time;
  if (!(before.time <= zero && zero <= after.time && before.time < after.time)) return {};
  return {{{before.time - zero, before.pose}, {after.time - zero, after.pose}}};
}

}  // namespace

std::vector<TrajectoryScan> scanTrajectory(Simulator& simulator, const Sensor& sensor,
                                           const std::vector<SensorMotion::Stamp>& trajectory,
                                           const std::function<void(size_t, const Scan&)>& write) {
  std::vector<Shot> shots;
  const Plan plan = simulator.plan();
  const bool inTurn = firesInTurn(sensor) && plan.has("sensor-motion"), speeds = plan.has("radial-speed");
  for (size_t i = 0; i < trajectory.size(); ++i) {
    Shot& shot = shots.emplace_back();
    shot.pose = trajectory[i].pose;
    shot.frame = i;
    if (inTurn)
      shot.motion = motionAround(trajectory, i, poseTimesOf(sensor, i));
    else if (speeds)
      shot.motion = speedAround(trajectory, i);
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
