// SPDX-License-Identifier: Apache-2.0
// The motion of sensor and instances during a shot, in the form that the stages read.
#pragma once

#include <optional>
#include <span>

#include "effects/motion_tables.hpp"
#include "effects/sensor_plan.hpp"
#include "geometry/deformables.hpp"
#include "geometry/instance_table.hpp"

namespace gnosphere {

/// The motion of one shot.
struct ShotMotion {
  MotionTables tables;
  Vec3 centre;                ///< of the lasers, from which the scene is projected, in the sensor's frame
  bool moves = false;         ///< whether anything moves; otherwise there are only lasers away from the sensor's origin
  MovingInstances instances;  ///< empty if no instance moves
  Deformables::End end;       ///< of the meshes that are deformed meanwhile; empty if none is
  double farthest = 0;        ///< largest distance in metres that a point of them moves
};

/// Returns whether the sensor or an instance moves during the shot, as far as scans of the plan simulate that.
bool moves(const SensorPlan& plan, const Shot& shot);

/// Returns whether a scan has points in the frames of its columns, which differ; see Scan::skewed.
bool isSkewed(const SensorPlan& plan, const Shot& shot);

/// The motion that the lasers see which fire from around `lasers.centre`. Empty if neither the sensor nor an instance
/// moves during this shot, and all lasers are at the sensor's origin.
std::optional<ShotMotion> motionOf(const SensorPlan& plan, const OriginBounds& lasers, const Shot& shot,
                                   const InstanceTable& instances, const Deformables& deformables);

/// The motions of shots that are submitted together: none, one for each shot, or one for all of them if nothing moves
/// but lasers stand away from the sensor's origin.
using ShotMotions = std::span<const ShotMotion>;
/// Returns the motion of a shot; null if there is none.
inline const ShotMotion* motionOf(ShotMotions motions, size_t shot) {
  return motions.empty() ? nullptr : &motions[motions.size() > 1 ? shot : 0];
}

/// Returns the pose in whose frame one of the shots is scanned.
Pose seenFrom(std::span<const Shot> shots, size_t shot, ShotMotions motions);

/// Returns by how many metres motion may bring a surface nearer to the sensor; 0 without motion.
double reachOf(ShotMotions motions);

}  // namespace gnosphere
