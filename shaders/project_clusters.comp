// SPDX-License-Identifier: Apache-2.0
// Stage project, second pass. One subgroup per visible group, one invocation per cluster; lists the clusters of the
// shell that a beam may meet. A cluster belongs to the shell that its nearest point lies in.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_ballot : require
#include "shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "sphere.glsl"
#include "cull.glsl"

layout(local_size_x = 64) in;

// One lane loads for all.
void loadGroup(uint i, out uvec2 pair, out Instance instance, out uint first, out uint count) {
  vec2 run;
  if (subgroupElect()) {
    pair = visibleGroups[i];
    instance = instances[pair.x];
    run = vec2(groups[pair.y].low.w, groups[pair.y].high.w);
  }
  pair = subgroupBroadcastFirst(pair);
  instance.row0 = subgroupBroadcastFirst(instance.row0);
  instance.row1 = subgroupBroadcastFirst(instance.row1);
  instance.row2 = subgroupBroadcastFirst(instance.row2);
  instance.offset = subgroupBroadcastFirst(instance.offset);
  run = subgroupBroadcastFirst(run);
  first = floatBitsToUint(run.x);
  count = floatBitsToUint(run.y);
}

bool seen(Instance instance, Cluster cluster) {
  vec3 low, high;
  sensorBox(instance, cluster.low.xyz, cluster.high.xyz, low, high);
  float nearest = nearestPoint(low, high);
  bool inShell = !(nearest < pass.shellMin) && !(nearest >= pass.shellMax);
  return inShell && !outOfSight(low, high);
}

void main() {
  uint groupCount = counters.visibleGroups;
  uint stride = gl_NumWorkGroups.x * gl_NumSubgroups;
  for (uint i = gl_WorkGroupID.x * gl_NumSubgroups + gl_SubgroupID; i < groupCount; i += stride) {
    uvec2 pair;
    Instance instance;
    uint first, count;
    loadGroup(i, pair, instance, first, count);
    for (uint k = 0; k < count; k += gl_SubgroupSize) {
      uint cluster = first + k + gl_SubgroupInvocationID;
      bool keep = k + gl_SubgroupInvocationID < count && seen(instance, clusters[cluster]);
      uvec4 ballot = subgroupBallot(keep);
      uint slot = 0;
      if (subgroupElect()) slot = atomicAdd(counters.visible, subgroupBallotBitCount(ballot));
      slot = subgroupBroadcastFirst(slot) + subgroupBallotExclusiveBitCount(ballot);
      if (keep) visible[slot] = uvec2(pair.x, cluster);
    }
  }
}
