// SPDX-License-Identifier: Apache-2.0
// The tables that the stages read for a scan with motion.
#pragma once

#include <vector>

#include "common/shared.h"
#include "effects/trajectory.hpp"
#include "sensor/beams.hpp"

namespace gnosphere {

struct MotionTables {
  Pose middle;  ///< pose of the lasers' centre at half time; triangles are projected in this frame
  std::vector<gpu::ColumnMotion> columns;
  gpu::MotionBounds bounds = {};  ///< `instances` stays 0; the caller sets it
};

/// The pose of a point of the sensor's frame, with the sensor's orientation.
Pose movedTo(const Vec3& point, const Pose& pose);

/// Computes the tables of motion. The sensor moves by Shot::motion if that is given and `simulated`; otherwise only
/// lasers away from the origin and moving instances count as motion, and nothing but `middle` depends on the pose. With
/// `deskew` points are reported in the frame of the shot's pose. Everything else is seen from the centre of the lasers.
MotionTables makeMotionTables(const ScanTimes& times, const OriginBounds& lasers, const Shot& shot, bool simulated,
                              bool deskew);

}  // namespace gnosphere
