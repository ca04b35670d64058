// SPDX-License-Identifier: Apache-2.0
// A scan of a sensor that moves, as the tables that the stages read.
#pragma once

#include <vector>

#include "effects/trajectory.hpp"
#include "shared.h"

namespace gnosphere {

struct MotionTables {
  Pose middle;  ///< where the sensor is halfway: the frame that triangles are projected in
  std::vector<gpu::ColumnMotion> columns;
  gpu::MotionBounds bounds = {};  ///< `instances` is left 0
};

/// `moves`: by Shot::motion; else only lasers away from the origin and instances are in motion. With `deskew` points
/// are reported from the shot's pose. A channel's time offset is not looked at: all lasers of a column see from one
/// place.
MotionTables makeMotionTables(const Sensor& sensor, const Shot& shot, bool moves, bool deskew);

}  // namespace gnosphere
