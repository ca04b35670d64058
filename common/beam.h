// SPDX-License-Identifier: Apache-2.0
// Computes a beam from the sensor's tables of rows and columns, in the common subset of GLSL, C++ and CUDA. Every
// stage, every effect and the host use the same operations, so all of them get the same beam.
#ifndef GNOSPHERE_BEAM_H
#define GNOSPHERE_BEAM_H

#include "effects/arithmetic.h"

#ifdef __cplusplus
namespace gnosphere::gpu {
GNO_INLINE float roundEven(float value) {
  return std::nearbyint(value);
}
#endif

// Rounds to the nearest multiple of 2^-30. With vertices (in metres) and directions on this lattice, products of three
// never underflow, whatever a device does with denormals. Every float of at least 2^-6 is such a multiple already.
GNO_INLINE float onLattice(float value) {
  GNO_PRECISE float nearest = roundEven(value * 1073741824.0f) * (1.0f / 1073741824.0f);
  return abs(value) < 0.015625f ? nearest : value;
}

GNO_INLINE vec3 onLattice(vec3 p) {
  return vec3(onLattice(p.x), onLattice(p.y), onLattice(p.z));
}

// Cos and sin of azimuth and elevation, and the direction vector that they define.
struct Beam {
  vec2 azimuth;
  float cosElevation, sinElevation;
  vec3 direction;
};

GNO_INLINE Beam beamOf(vec2 azimuth, float cosElevation, float sinElevation) {
  GNO_PRECISE float forward = cosElevation * azimuth.x;
  GNO_PRECISE float left = cosElevation * azimuth.y;
  Beam beam;
  beam.azimuth = azimuth;
  beam.cosElevation = cosElevation;
  beam.sinElevation = sinElevation;
  beam.direction = vec3(forward, left, sinElevation);
  return beam;
}

#ifdef __cplusplus
}  // namespace gnosphere::gpu
#endif
#endif
