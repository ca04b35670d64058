// SPDX-License-Identifier: Apache-2.0
// A beam: cos and sin of azimuth and elevation, and the direction they make.
struct Beam {
  vec2 azimuth;
  float cosElevation, sinElevation;
  vec3 direction;
};

// The azimuth of a column as a channel with its own offset has it.
vec2 shiftedAzimuth(vec2 column, vec4 offset) {
  precise float c = column.x * offset.x - column.y * offset.y;
  precise float s = column.y * offset.x + column.x * offset.y;
  return INSIDE == kInsideExact ? snapToLattice(vec3(c, s, 0.0)).xy : vec2(c, s);
}

// The same operations wherever a beam is asked for, so every triangle and every effect sees the same beam.
Beam beamOf(vec2 azimuth, float cosElevation, float sinElevation) {
  precise vec2 horizontal = cosElevation * azimuth;
  return Beam(azimuth, cosElevation, sinElevation, vec3(horizontal, sinElevation));
}
