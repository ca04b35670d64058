// SPDX-License-Identifier: Apache-2.0
// The motion of the sensor and of the instances during a scan.
#ifndef GNOSPHERE_COMMON_MOVEMENT_H
#define GNOSPHERE_COMMON_MOVEMENT_H

#include "types.h"

#ifdef __cplusplus
namespace gnosphere::gpu {
#endif

// The velocity of an instance's points, m/s in the sensor's axes: rows * (point, 1), for points of the mesh frame.
struct InstanceMotion {
  vec4 row0, row1, row2;
  // x: largest distance in metres that any of its points moves during the scan; y: largest change of a vector between
  // two of its points, as a share of the vector's length. If its mesh is deformed meanwhile, z is 1 and w is one over
  // the time that this takes, in 1/s; otherwise both are 0.
  vec4 bound;
};

// The sensor when a column fires: the column's frame = rows * (point, 1), where points are in the sensor's frame at
// the middle of the scan.
struct ColumnMotion {
  vec4 row0, row1, row2;
  vec4 report0, report1, report2;  // the frame that points are reported in = report * (point of the column's frame, 1)
  vec4 velocity;                   // of the sensor, m/s in the column's frame; w: seconds since the scan's start
  vec4 spin;                       // angular velocity of the sensor, rad/s in the column's frame; w is not used
  // Sums, over the entries before this one, of how much the motion bends there: the lengths of the second differences
  // of the shifts in metres and of the rotations (Frobenius norm). The other two are not used.
  vec4 bends;
};

// The frame of a beam when it fires: forward along its azimuth, to the left, and up. The axes are given in the sensor's
// frame at the middle of the scan; w is minus the position of the beam's laser along them.
struct BeamFrame {
  vec4 forward, left, up;
};

// Bounds of the motion during the scan, relative to the sensor's frame at the middle of the scan.
struct MotionBounds {
  float shift, turn;                    // most metres and radians that the sensor moves, laser origins included
  float shiftPerColumn, turnPerColumn;  // at most, between neighbouring columns
  float origins;                        // metres: largest distance of a laser from the sensor's origin
  float forward, left, up;              // metres: largest parts of it, along the beam's azimuth, across and upwards
  float secondsPerColumn, seconds;      // per column, and for the whole scan
  uint instances, sensor;               // 1 if instances move, if the sensor moves; else its columns' frames are one
  float middle, columnsToMiddle;        // from the start of the scan to its middle: seconds, and columns
  vec3 drift;                           // metres by which the sensor moves in secondsPerColumn, on average
  float wander, wanderPerColumn;        // most metres that it is elsewhere than with this average, and per column
  float bendShift, bendTurn;            // columnMotions have at most these second differences of their shifts and of
                                        // their rotations (Frobenius norm), from the first stamp to the last
  uint bendFirst, bendEnd;              // entries of columnMotions between these stamps
};

#ifdef __cplusplus
static_assert(sizeof(InstanceMotion) == 64 && sizeof(ColumnMotion) == 144 && sizeof(MotionBounds) == 92);
}  // namespace gnosphere::gpu
#endif
#endif
