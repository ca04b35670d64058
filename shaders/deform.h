// SPDX-License-Identifier: Apache-2.0
// How a vertex follows morph targets and joints, in the common subset of GLSL, C++ and CUDA, so that device and host
// get the same bytes. (glTF 2.0, sections 3.7.2.2 and 3.7.3.)
#ifndef GNOSPHERE_DEFORM_H
#define GNOSPHERE_DEFORM_H

#include "effects/arithmetic.h"

#ifdef __cplusplus
namespace gnosphere::gpu {
#endif

// Adds the offset of a morph target.
GNO_INLINE vec3 morphed(vec3 position, vec3 offset, float weight) {
  GNO_PRECISE vec3 result =
      vec3(position.x + offset.x * weight, position.y + offset.y * weight, position.z + offset.z * weight);
  return result;
}

// Adds the share of a joint to the position of a deformed vertex; the rows are those of the joint's map.
GNO_INLINE vec3 withJoint(vec3 sum, vec4 row0, vec4 row1, vec4 row2, vec3 position, float weight) {
  GNO_PRECISE vec3 p = vec3(row0.x * position.x + row0.y * position.y + row0.z * position.z + row0.w,
                            row1.x * position.x + row1.y * position.y + row1.z * position.z + row1.w,
                            row2.x * position.x + row2.y * position.y + row2.z * position.z + row2.w);
  GNO_PRECISE vec3 result = vec3(sum.x + p.x * weight, sum.y + p.y * weight, sum.z + p.z * weight);
  return result;
}

#ifdef __cplusplus
}  // namespace gnosphere::gpu
#endif
#endif
