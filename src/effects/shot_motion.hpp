// SPDX-License-Identifier: Apache-2.0
// The motion of sensor and instances during a shot, in the form that the stages read.
#pragma once

#include <optional>

#include "effects/motion_tables.hpp"
#include "effects/sensor_plan.hpp"
#include "geometry/deformables.hpp"
#include "geometry/instance_table.hpp"

namespace gnosphere {

/// The motion of one shot.
struct ShotMotion {
  MotionTables tables;
  Vec3 centre;         ///< of the lasers, from which the scene is projected, in the sensor's frame
  bool moves = false;  ///< whether anything moves; otherwise there are only lasers away from the sensor's origin
  std::vector<gpu::InstanceMotion> instances;  ///< one per instance; empty if no instance moves
  Deformables::End end;                        ///< of the meshes that are deformed meanwhile; empty if none is
  double farthest = 0;                         ///< largest distance in metres that a point of them moves
};

/// The motion that the lasers see which fire from around `lasers.centre`. Empty if neither the sensor nor an instance
/// moves during this shot, and all lasers are at the sensor's origin.
std::optional<ShotMotion> motionOf(const SensorPlan& plan, const OriginBounds& lasers, const Shot& shot,
                                   const InstanceTable& instances, const Deformables& deformables);

/// Returns by how many metres motion may bring a surface nearer to the sensor; 0 without motion.
double reachOf(const std::optional<ShotMotion>& motion);

}  // namespace gnosphere
