// SPDX-License-Identifier: Apache-2.0
// The angle of incidence, in the common subset of GLSL and C++.
#ifndef GNOSPHERE_EFFECTS_INCIDENCE_H
#define GNOSPHERE_EFFECTS_INCIDENCE_H

#include "vector.h"

#ifdef __cplusplus
namespace gnosphere::gpu {
#endif

// Radians, for x in 0..1; error at most 3e-7. Abramowitz and Stegun, "Handbook of Mathematical Functions", 4.4.46.
// `rest` is 1 - x, which the caller may know with a smaller relative error.
GNO_INLINE float arcCosine(float x, float rest) {
  GNO_PRECISE float sum = -0.0012624911f;
  sum = sum * x + 0.0066700901f;
  sum = sum * x - 0.0170881256f;
  sum = sum * x + 0.0308918810f;
  sum = sum * x - 0.0501743046f;
  sum = sum * x + 0.0889789874f;
  sum = sum * x - 0.2145988016f;
  sum = sum * x + 1.5707963050f;
  GNO_PRECISE float result = sum * squareRoot(rest);
  return result;
}

// Angle in radians between a beam and a unit normal that points towards the sensor. `along` is a vector along the beam,
// away from the sensor, and `length` its length.
GNO_INLINE float incidenceOf(vec3 normal, vec3 along, float length) {
  float cosine = min(max(quotient(-dotOf(normal, along), length), 0.0f), 1.0f);
  // Near normal incidence the sine tells small angles apart, and the cosine does not: 1 - cos = sin^2 / (1 + cos).
  vec3 across = crossOf(normal, along);
  GNO_PRECISE float rest = 1.0f - cosine;
  if (cosine > 0.9f) rest = quotient(dotOf(across, across), length * length * (1.0f + cosine));
  return arcCosine(cosine, rest);
}

#ifdef __cplusplus
}  // namespace gnosphere::gpu
#endif
#endif
