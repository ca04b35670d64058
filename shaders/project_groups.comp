// SPDX-License-Identifier: Apache-2.0
// Stage project, first pass. One invocation per placed group of clusters; lists those of which a beam may see something
// in the shell.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_ballot : require
#include "shared.h"
#include "options.glsl"
#include "bindings.glsl"
#ifdef MOTION
#include "effects/arithmetic.h"
#include "effects/parameters.h"
#include "effects_bindings.glsl"
#include "motion.glsl"
#endif
#include "sphere.glsl"
#include "place.glsl"
#include "cull.glsl"
#include "lanes.glsl"

layout(local_size_x = 64) in;

bool seen(uvec2 pair) {
  vec3 low, high;
  sensorBox(instances[pair.x], groups[pair.y].low.xyz, groups[pair.y].high.xyz, low, high);
#ifdef MOTION
  widenByMotion(pair.x, low, high);
#endif
  return !(nearestPoint(low, high) >= pass.shellMax || farthestPoint(low, high) < pass.shellMin || outOfSight(low, high));
}

void main() {
  uint stride = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
  uint rounds = (pass.placedCount + stride - 1) / stride;
  for (uint k = 0; k < rounds; ++k) {
    uint i = k * stride + gl_WorkGroupID.x * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
    uvec2 pair = uvec2(0);
    bool keep = false;
    if (i < pass.placedCount) {
      pair = placed[pass.placedFirst + i];
      keep = seen(pair);
    }
    uvec4 ballot = subgroupBallot(keep);
    uint slot = 0;
    if (subgroupElect()) slot = atomicAdd(counters.visibleGroups, subgroupBallotBitCount(ballot));
    slot = slotAfter(slot, ballot);
    if (keep) visibleGroups[slot] = pair;
  }
}
