// SPDX-License-Identifier: Apache-2.0
// The angle of incidence, in the common subset of GLSL and C++.
#ifndef GNOSPHERE_EFFECTS_INCIDENCE_H
#define GNOSPHERE_EFFECTS_INCIDENCE_H

#include "vector.h"

#ifdef __cplusplus
namespace gnosphere::gpu {
#endif

// Radians, for x in 0..1; error at most 3e-7. Abramowitz and Stegun, "Handbook of Mathematical Functions", 4.4.46.
GNO_INLINE float arcCosine(float x) {
  GNO_PRECISE float sum = -0.0012624911f;
  sum = sum * x + 0.0066700901f;
  sum = sum * x - 0.0170881256f;
  sum = sum * x + 0.0308918810f;
  sum = sum * x - 0.0501743046f;
  sum = sum * x + 0.0889789874f;
  sum = sum * x - 0.2145988016f;
  sum = sum * x + 1.5707963050f;
  GNO_PRECISE float result = sum * squareRoot(1.0f - x);
  return result;
}

// Angle in radians between a beam and a unit normal that points towards the sensor. `along` is a vector along the beam,
// away from the sensor, and `length` its length.
GNO_INLINE float incidenceOf(vec3 normal, vec3 along, float length) {
  float cosine = quotient(-dotOf(normal, along), length);
  return arcCosine(min(max(cosine, 0.0f), 1.0f));
}

#ifdef __cplusplus
}  // namespace gnosphere::gpu
#endif
#endif
