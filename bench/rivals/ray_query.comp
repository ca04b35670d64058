// SPDX-License-Identifier: Apache-2.0
// Finds the nearest triangle of either face by a ray query; one invocation per beam. A workgroup is a tile of the grid
// of beams, so that its rays are close together.
#version 460
#extension GL_EXT_ray_query : require
#extension GL_GOOGLE_include_directive : require
#include "rays.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

void main() {
  const uvec2 at = gl_GlobalInvocationID.xy;
  if (at.x >= columns || at.y >= channels) return;
  const uint beam = at.y * columns + at.x;
  rayQueryEXT query;
  rayQueryInitializeEXT(query, scene, gl_RayFlagsOpaqueEXT, 0xff, origin(), rangeMin, direction(beam), rangeMax);
  while (rayQueryProceedEXT(query)) {
  }
  if (rayQueryGetIntersectionTypeEXT(query, true) == gl_RayQueryCommittedIntersectionNoneEXT)
    writeMiss(beam);
  else
    writeHit(beam, rayQueryGetIntersectionTEXT(query, true), rayQueryGetIntersectionInstanceIdEXT(query, true),
             rayQueryGetIntersectionPrimitiveIndexEXT(query, true));
}
