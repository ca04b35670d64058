// SPDX-License-Identifier: Apache-2.0
// Scans from every pose of a trajectory, and names the files of each scan.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "gnosphere/gnosphere.hpp"

namespace gnosphere::cli {

/// The data kept of each scan of a trajectory.
struct TrajectoryScan {
  Pose pose;
  Counters counters;
  Timings timings;
};

/// Returns the name of scan `number`: cloud.pcd, 12 -> cloud-000012.pcd.
std::string numbered(const std::string& file, size_t number);

/// Scans from every pose, several in flight if the device can, and passes each scan to `write`. A sensor whose beams
/// fire one after the other moves along the trajectory during a scan; Error(format) is thrown if its times do not
/// ascend.
std::vector<TrajectoryScan> scanTrajectory(Simulator& simulator, const Sensor& sensor,
                                           const std::vector<SensorMotion::Stamp>& trajectory,
                                           const std::function<void(size_t, const Scan&)>& write);

/// Combines all scans into one Scan without arrays: counters are sums, except that nonFinite is the largest, as it
/// counts triangles of one scene.
Scan summaryOf(const std::vector<TrajectoryScan>& scans, const Sensor& sensor);

}  // namespace gnosphere::cli
