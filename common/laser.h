// SPDX-License-Identifier: Apache-2.0
// The point that a laser of a moving sensor reports, in the common subset of GLSL, C++ and CUDA, so that device and
// host get the same bytes.
#ifndef GNOSPHERE_LASER_H
#define GNOSPHERE_LASER_H

#include "effects/vector.h"

#ifdef __cplusplus
namespace gnosphere::gpu {
#endif

GNO_INLINE vec4 between(vec4 a, vec4 b, float share) {
  GNO_PRECISE float rest = 1.0f - share;
  GNO_PRECISE vec4 result;
  result.x = a.x * rest + b.x * share;
  result.y = a.y * rest + b.y * share;
  result.z = a.z * rest + b.z * share;
  result.w = a.w * rest + b.w * share;
  return result;
}

// Returns the sensor between two moments, which a straight line joins.
GNO_INLINE ColumnMotion motionBetween(ColumnMotion a, ColumnMotion b, float share) {
  ColumnMotion at;
  at.row0 = between(a.row0, b.row0, share);
  at.row1 = between(a.row1, b.row1, share);
  at.row2 = between(a.row2, b.row2, share);
  at.report0 = between(a.report0, b.report0, share);
  at.report1 = between(a.report1, b.report1, share);
  at.report2 = between(a.report2, b.report2, share);
  at.velocity = between(a.velocity, b.velocity, share);
  at.spin = between(a.spin, b.spin, share);
  at.bends = a.bends;
  return at;
}

// Returns the entry of the table of poses at which the beam in a place of a row fires, between two entries. `first` and
// `lag` are the row's.
GNO_INLINE float momentOf(int first, float lag, uint column, uint columns) {
  int beam = int(column) - first;
  beam = beam < 0 ? beam + int(columns) : beam;
  beam = beam >= int(columns) ? beam - int(columns) : beam;
  return float(beam) + lag;
}

// Returns the position of a laser: its origin in the head, rotated to the beam's azimuth.
GNO_INLINE vec3 laserAt(vec3 origin, vec2 azimuth) {
  GNO_PRECISE vec3 turned =
      vec3(origin.x * azimuth.x - origin.y * azimuth.y, origin.x * azimuth.y + origin.y * azimuth.x, origin.z);
  return turned;
}

// Returns the point at a range along a beam, in the frame that points are reported in.
GNO_INLINE vec3 reportedPoint(ColumnMotion at, vec3 laser, vec3 direction, float range) {
  GNO_PRECISE vec3 p = direction * range + laser;
  return through(at.report0, at.report1, at.report2, p);
}

#ifdef __cplusplus
}  // namespace gnosphere::gpu
#endif
#endif
