// SPDX-License-Identifier: Apache-2.0
// Stage project, second pass. One subgroup per visible group, one invocation per cluster. Lists the clusters of the
// shell that a beam may hit. A cluster belongs to the shell that contains its nearest point.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_ballot : require
#include "shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "motion.glsl"
#include "sphere.glsl"
#include "to_sensor.glsl"
#include "cull.glsl"
#include "lanes.glsl"

layout(local_size_x = 64) in;

// The first lane loads the group and its instance and broadcasts them.
void loadGroup(uint i, out uvec2 pair, out Instance instance, out uint first, out uint count) {
  uvec2 run;
  if (gl_SubgroupInvocationID == 0) {
    pair = visibleGroups.at[i];
    instance = instances.at[pair.x];
    run = uvec2(groups.at[pair.y].clusterFirst, groups.at[pair.y].clusterCount);
  }
  pair = subgroupBroadcast(pair, 0);
  instance = fromFirstLane(instance);
  run = subgroupBroadcast(run, 0);
  first = run.x;
  count = run.y;
}

// True if the back-face cone of the mesh is valid for the instance: the transform is a rotation, optionally with one
// uniform scale, and the pivot is the sensor's position.
bool keepsShape(Instance instance, vec3 distance) {
  vec3 a = instance.row0.xyz, b = instance.row1.xyz, c = instance.row2.xyz;
  float scale = dot(a, a);
  float skew = max(max(abs(dot(a, b)), abs(dot(b, c))), abs(dot(c, a)));
  float stretch = max(abs(dot(b, b) - scale), abs(dot(c, c) - scale));
  return max(skew, stretch) <= 1e-3 * scale && dot(instance.offset, instance.offset) <=
                                                    1e-8 * scale * dot(distance, distance);
}

// True if all triangles of the cluster are back-facing by more than rounding can undo. The margin is 1e-3 for the
// cone's own rounding. A corner rounded to 1e-7 of its distance tilts a triangle by that error over the triangle's
// height; the margin is 40 times as much, to cover the steps that follow.
bool showsItsBack(Instance instance, uint cluster) {
  bool oneSided = FACES == kFacesFront || (FACES == kFacesMaterial && clusters.at[cluster].doubleSided == 0);
  if ((CULLING & kCullCones) == 0 || !oneSided) return false;
  vec3 eye = pivotOf(instance), low = clusters.at[cluster].low, high = clusters.at[cluster].high;
  vec3 towards = 0.5 * (low - eye) + 0.5 * (high - eye);
  float radius = 0.5 * length(high - low), distance = length(towards);
  vec2 cone = unpackHalf2x16(clusters.at[cluster].cone);
  float sine = cone.x + 1e-3 + 4e-6 * (distance + radius) * cone.y;
  return dot(towards, clusters.at[cluster].coneAxis) >= sine * distance + radius * 1.00001 && keepsShape(instance, towards);
}

bool seen(uint number, Instance instance, uint cluster) {
  vec3 low, high;
  sensorBox(instance, clusters.at[cluster].low, clusters.at[cluster].high, low, high);
  if (MOTION) widenByMotion(number, low, high);
  float nearest = nearestPoint(low, high);
  bool inShell = !(nearest < pass.shellMin) && !(nearest >= pass.shellMax);
  // The cone is tested last because then most clusters do not have to load it.
  return inShell && !outOfSight(low, high) && (MOTION || !showsItsBack(instance, cluster));
}

void main() {
  loadMotion();
  uint groupCount = counters.visibleGroups;
  uint stride = gl_NumWorkGroups.x * gl_NumSubgroups;
  for (uint i = gl_WorkGroupID.x * gl_NumSubgroups + gl_SubgroupID; i < groupCount; i += stride) {
    uvec2 pair;
    Instance instance;
    uint first, count;
    loadGroup(i, pair, instance, first, count);
    for (uint k = 0; k < count; k += gl_SubgroupSize) {
      uint cluster = first + k + gl_SubgroupInvocationID;
      bool keep = k + gl_SubgroupInvocationID < count && seen(pair.x, instance, cluster);
      uvec4 ballot = subgroupBallot(keep);
      uint slot = 0;
      if (gl_SubgroupInvocationID == 0) slot = atomicAdd(counters.visible, subgroupBallotBitCount(ballot));
      slot = slotAfter(slot, ballot);
      if (keep) visible.at[slot] = uvec2(pair.x, cluster);
    }
  }
}
