// SPDX-License-Identifier: Apache-2.0
// Scans from one pose after the other, and how the files of each are called.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "gnosphere/gnosphere.hpp"

namespace gnosphere::cli {

/// What is kept of each scan of a trajectory.
struct TrajectoryScan {
  Pose pose;
  Counters counters;
  Timings timings;
};

/// cloud.pcd, 12 -> cloud-000012.pcd
std::string numbered(const std::string& file, size_t number);

/// Scans from every pose, in flight where the device can, and hands each scan to `write`. A sensor that takes `period`
/// seconds for a turn goes on along the trajectory meanwhile. Throws Error(format) if its times do not ascend then.
std::vector<TrajectoryScan> scanTrajectory(Simulator& simulator, const std::vector<SensorMotion::Stamp>& trajectory,
                                           double period, const std::function<void(size_t, const Scan&)>& write);

/// All of them as one Scan without arrays: beams, hits, misses and retries are sums, nonFinite is the largest.
Scan summaryOf(const std::vector<TrajectoryScan>& scans, const Sensor& sensor);

}  // namespace gnosphere::cli
