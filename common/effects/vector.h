// SPDX-License-Identifier: Apache-2.0
// Products of vectors and affine maps that give the same bytes everywhere: the built-in ones may use fused
// multiply-add.
#ifndef GNOSPHERE_EFFECTS_VECTOR_H
#define GNOSPHERE_EFFECTS_VECTOR_H

#include "arithmetic.h"

#ifdef __cplusplus
namespace gnosphere::gpu {
#endif

GNO_INLINE float dotOf(vec3 a, vec3 b) {
  GNO_PRECISE float result = a.x * b.x + a.y * b.y + a.z * b.z;
  return result;
}

GNO_INLINE vec3 crossOf(vec3 a, vec3 b) {
  GNO_PRECISE vec3 result = vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
  return result;
}

// Returns where the affine map with these rows takes a point.
GNO_INLINE vec3 through(vec4 row0, vec4 row1, vec4 row2, vec3 p) {
  GNO_PRECISE vec3 result =
      vec3(row0.x * p.x + row0.y * p.y + row0.z * p.z + row0.w, row1.x * p.x + row1.y * p.y + row1.z * p.z + row1.w,
           row2.x * p.x + row2.y * p.y + row2.z * p.z + row2.w);
  return result;
}

GNO_INLINE float largestComponent(vec3 v) {
  return max(max(abs(v.x), abs(v.y)), abs(v.z));
}

// Normalises a normal and turns it to the side of its plane that contains the origin; `on` is a point of the plane.
// A triangle that rounding has left without area has no normal; it counts as one that faces the origin.
GNO_INLINE vec3 unitTowardsOrigin(vec3 normal, vec3 on) {
  // The normal is divided by its largest component first, so that its square neither overflows nor underflows.
  float largest = largestComponent(normal);
  if (!(largest > 1e-30f)) {
    normal = on;
    largest = largestComponent(on);
  }
  if (!(largest > 1e-30f && largest < 1e30f)) return vec3(0.0f);
  GNO_PRECISE float scale = quotient(1.0f, largest);
  GNO_PRECISE vec3 scaled = normal * scale;
  GNO_PRECISE float inverse = quotient(1.0f, squareRoot(dotOf(scaled, scaled)));
  GNO_PRECISE vec3 unit = scaled * (dotOf(scaled, on) > 0.0f ? -inverse : inverse);
  return unit;
}

#ifdef __cplusplus
}  // namespace gnosphere::gpu
#endif
#endif
