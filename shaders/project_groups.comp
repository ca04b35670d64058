// SPDX-License-Identifier: Apache-2.0
// Stage project, first pass. One invocation per placed group of clusters. Lists the groups in which a beam may hit
// something in the shell.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#include "shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "motion.glsl"
#include "sphere.glsl"
#include "to_sensor.glsl"
#include "cull.glsl"
#include "lanes.glsl"

layout(local_size_x = 64) in;

// Records the rows that content beyond this shell may cover. The farthest-range table is computed only for these rows.
void noteLater(vec3 low, vec3 high, inout uvec2 later) {
  bool occluders = (CULLING & kCullOccluded) != 0 && pass.shellMax < kCoordinateLimit;
  if (!occluders || farthestPoint(low, high) < pass.shellMax) return;
  if (MOTION) seeming = seemingAngle(motion.shift, motion.turn, pass.shellMax);  // bounds all content beyond the shell
  float keyMin, keyMax;
  coverKeys(low, high, pass.shellMax, keyMin, keyMax);
  uint first, end;
  // The range is widened by one lookup cell, because the boxes of clusters are rounded to whole cells.
  rowsBetween(keyMin - 2.0 / float(kRowLookupCells), keyMax + 2.0 / float(kRowLookupCells), first, end);
  later = max(later, uvec2(frame.rows - first, end));
}

bool seen(uvec2 pair, inout uvec2 later) {
  vec3 low, high;
  sensorBox(instances.at[pair.x], groups.at[pair.y].low, groups.at[pair.y].high, low, high);
  if (MOTION) widenByMotion(pair.x, low, high);
  noteLater(low, high, later);
  return !(nearestPoint(low, high) >= pass.shellMax || farthestPoint(low, high) < pass.shellMin || outOfSight(low, high));
}

void main() {
  loadMotion();
  uint stride = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
  uvec2 later = uvec2(0);
  uint rounds = (pass.placedCount + stride - 1) / stride;
  for (uint k = 0; k < rounds; ++k) {
    uint i = k * stride + gl_WorkGroupID.x * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
    uvec2 pair = uvec2(0);
    bool keep = false;
    if (i < pass.placedCount) {
      pair = placed.at[pass.placedFirst + i];
      keep = seen(pair, later);
    }
    uvec4 ballot = subgroupBallot(keep);
    uint slot = 0;
    if (gl_SubgroupInvocationID == 0) slot = atomicAdd(counters.visibleGroups, subgroupBallotBitCount(ballot));
    slot = slotAfter(slot, ballot);
    if (keep) visibleGroups.at[slot] = pair;
  }
  later = uvec2(subgroupMax(later.x), subgroupMax(later.y));
  if (gl_SubgroupInvocationID == 0 && later.y > 0) {
    atomicMax(counters.laterRowsDown, later.x);
    atomicMax(counters.laterRowsUp, later.y);
  }
}
