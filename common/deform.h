// SPDX-License-Identifier: Apache-2.0
// How a vertex follows morph targets and joints, in the common subset of GLSL, C++ and CUDA, so that device and host
// get the same bytes. (glTF 2.0, sections 3.7.2.2 and 3.7.3.)
#ifndef GNOSPHERE_DEFORM_H
#define GNOSPHERE_DEFORM_H

#include "effects/vector.h"

#ifdef __cplusplus
namespace gnosphere::gpu {
#endif

// Weights of joints are multiples of 2^-20, and those of a vertex sum to 1 exactly.
GNO_CONST uint kWeightUnits = 1u << 20;

// An entry of boneWeights holds the number of a bone in its low 11 bits and the weight of that bone in the others.
GNO_CONST uint kMostBones = 1u << 11;
GNO_CONST uint kMostInfluences = 16;  // validate() refuses more

GNO_INLINE uint packedWeight(uint bone, uint units) {
  return bone | units * kMostBones;
}
GNO_INLINE uint boneOf(uint weight) {
  return weight & (kMostBones - 1u);
}
GNO_INLINE float shareOf(uint weight) {
  return float(weight / kMostBones) * (1.0f / float(kWeightUnits));
}

// The joint of an entry of `bones` has the low 16 bits, the least weight the 16 bits above, rounded down.
GNO_INLINE uint packedBone(uint joint, uint leastUnits) {
  uint least = leastUnits / (kWeightUnits >> 16);
  return joint | (least > 0xffffu ? 0xffffu : least) << 16;
}
GNO_INLINE uint jointOf(uint bone) {
  return bone & 0xffffu;
}
GNO_INLINE float leastShareOf(uint bone) {
  return float(bone >> 16) * (1.0f / 65536.0f);
}

// A box of deformed vertices is wider than they need by this share of its coordinates. The margin covers the rounding
// of the vertices and that of the sum of their weights.
GNO_CONST float kBoneMargin = 2e-5f;

// Adds a share of a vector: of the offset by a morph target, or of the place to which a joint takes a vertex.
GNO_INLINE vec3 withShare(vec3 sum, vec3 vector, float share) {
  GNO_PRECISE vec3 result = vec3(sum.x + vector.x * share, sum.y + vector.y * share, sum.z + vector.z * share);
  return result;
}

// Returns the middle and half the size, along one axis, of a box around what a joint makes of a box; `row` is the row
// of that axis in the joint's map. The box has a margin as a share of its coordinates.
GNO_INLINE vec2 spanThrough(vec4 row, vec3 middle, vec3 extent, float margin) {
  float size = abs(row.x) * extent.x + abs(row.y) * extent.y + abs(row.z) * extent.z;
  float reach = abs(row.x * middle.x) + abs(row.y * middle.y) + abs(row.z * middle.z) + abs(row.w) + size;
  return vec2(row.x * middle.x + row.y * middle.y + row.z * middle.z + row.w, size + margin * reach);
}

#ifdef __cplusplus
}  // namespace gnosphere::gpu
#endif
#endif
