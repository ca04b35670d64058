// SPDX-License-Identifier: Apache-2.0
// The tables that the stages read for a scan with motion.
#pragma once

#include <vector>

#include "effects/trajectory.hpp"
#include "shared.h"

namespace gnosphere {

struct MotionTables {
  Pose middle;  ///< pose of the sensor at half time; triangles are projected in this frame
  std::vector<gpu::ColumnMotion> columns;
  gpu::MotionBounds bounds = {};  ///< `instances` stays 0; the caller sets it
};

/// Computes the tables. If `moves`, the sensor moves by Shot::motion; otherwise only lasers away from the origin and
/// moving instances count as motion. With `deskew` points are reported in the frame of the shot's pose. Time offsets of
/// channels are ignored: all lasers of a column use the pose of the column.
MotionTables makeMotionTables(const Sensor& sensor, const Shot& shot, bool moves, bool deskew);

}  // namespace gnosphere
