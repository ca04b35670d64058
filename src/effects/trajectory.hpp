// SPDX-License-Identifier: Apache-2.0
// Poses and velocities of the sensor and of instances at a time within a scan.
#pragma once

#include "gnosphere/simulator.hpp"

namespace gnosphere {

/// Returns the pose at `time`. The position is interpolated linearly, the orientation by slerp along the shorter arc;
/// both are constant before the first and after the last stamp. Without stamps the result is `standing`. Between stamps
/// the quaternion has length 1.
Pose poseAt(const SensorMotion& motion, const Pose& standing, double time);
/// Returns the velocity in m/s in the world: at a stamp that of the following interval, 0 where the pose is constant.
Vec3 velocityAt(const SensorMotion& motion, double time);

/// Returns the transform at `time` of an instance that moves from `start` to `end` within `period` seconds.
Transform transformAt(const Transform& start, const Transform& end, double period, double time);
/// Returns the map from a point of the mesh to its velocity in m/s in the world: velocity = velocityOf(...) * point.
Transform velocityOf(const Transform& start, const Transform& end, double period);

}  // namespace gnosphere
