// SPDX-License-Identifier: Apache-2.0
// Loads the pose of the sensor and the position of the laser at the time when an invocation's beam fires. Each beam
// loads the pose once, because a load reads two entries of the table and interpolates between them.

ColumnMotion beamMotion;  // the sensor; only with motion
vec3 beamOrigin;          // the beam's laser in the sensor's frame; only with motion or origins of lasers

void loadPlaceOfBeam(uint row, uint column, vec2 azimuth) {
  if (MOTION) beamMotion = columnMotionOf(row, column);
  if (APART) beamOrigin = originOf(row, azimuth);
}
