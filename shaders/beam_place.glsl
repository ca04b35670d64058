// SPDX-License-Identifier: Apache-2.0
// Where the sensor and its lasers are when the beam that an invocation processes fires. Each beam loads its place once,
// because a load of a pose reads two entries of the table and joins them.

ColumnMotion beamMotion;  // the sensor; only with motion
vec3 beamOrigin;          // the beam's laser in the sensor's frame; only with motion or origins of lasers

void loadPlaceOfBeam(uint row, uint column, vec2 azimuth) {
  if (MOTION) beamMotion = columnMotionOf(row, column);
  if (APART) beamOrigin = originOf(row, azimuth);
}
