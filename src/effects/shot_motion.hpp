// SPDX-License-Identifier: Apache-2.0
// How the sensor and the instances of a shot move within it, as the stages read it.
#pragma once

#include <optional>

#include "effects/motion_tables.hpp"
#include "effects/sensor_plan.hpp"
#include "geometry/instance_table.hpp"

namespace gnosphere {

/// A shot in motion.
struct ShotMotion {
  MotionTables tables;
  std::vector<gpu::InstanceMotion> instances;  ///< of all; empty: none moves
  double farthest = 0;                         ///< metres that any of their points goes
};

/// Empty if neither the sensor nor an instance moves during this shot; the scan then uses the pipelines without motion.
std::optional<ShotMotion> motionOf(const SensorPlan& plan, const Shot& shot, const InstanceTable& instances);

/// Metres that something may come nearer by.
double reachOf(const std::optional<ShotMotion>& motion);

}  // namespace gnosphere
