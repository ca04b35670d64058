// SPDX-License-Identifier: Apache-2.0
// Poses and velocities of the sensor and of instances at a time within a scan.
#pragma once

#include "gnosphere/simulator.hpp"

namespace gnosphere {

/// Returns the pose at `time`. The position is interpolated linearly, the orientation by slerp along the shorter arc;
/// both are constant before the first and after the last stamp. Without stamps the result is `standing`. Between stamps
/// the quaternion has length 1.
Pose poseAt(const SensorMotion& motion, const Pose& standing, double time);
/// Returns the velocity in m/s in the world, which is constant between two stamps; at a stamp it is that of the
/// following interval. Before the first and after the last stamp it is that of the nearest interval, although the pose
/// is constant: stamps at the start and the end of a scan do not stop the sensor there. Without an interval it is 0.
Vec3 velocityAt(const SensorMotion& motion, double time);
/// Returns the angular velocity in rad/s in the frame of the sensor, of the same interval.
Vec3 angularVelocityAt(const SensorMotion& motion, double time);

/// Returns the map from a point of the mesh to its velocity in m/s in the world, velocity = velocityOf(...) * point, of
/// an instance that moves from `start` to `end` within `period` seconds.
Transform velocityOf(const Transform& start, const Transform& end, double period);

}  // namespace gnosphere
