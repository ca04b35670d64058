// SPDX-License-Identifier: Apache-2.0
// Where a sensor and what it sees are at a time within a scan.
#pragma once

#include "gnosphere/simulator.hpp"

namespace gnosphere {

/// Position linear, orientation along the shorter arc (slerp), both held before the first stamp and after the last;
/// `standing` where the motion has no stamps. The orientation comes out with length 1 between stamps.
Pose poseAt(const SensorMotion& motion, const Pose& standing, double time);
/// m/s in the world; at a stamp that of what follows, 0 where the pose is held.
Vec3 velocityAt(const SensorMotion& motion, double time);

/// Where an instance that moves from `start` to `end` over `period` seconds has its points at a time.
Transform transformAt(const Transform& start, const Transform& end, double period, double time);
/// m/s in the world of the instance's points: velocity = velocityOf(...) * point of the mesh.
Transform velocityOf(const Transform& start, const Transform& end, double period);

}  // namespace gnosphere
