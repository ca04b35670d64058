// SPDX-License-Identifier: Apache-2.0
// Stage project, second pass, once per shell. A subgroup takes several groups, one per invocation, then the clusters of
// each group that a beam may hit. Lists the clusters of the shell for the next pass, and the groups that reach beyond
// the shell for the next shell. A cluster belongs to the shell that contains its nearest point.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#ifdef INT64
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#endif
#include "common/shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "views.glsl"
#include "motion.glsl"
#include "sphere.glsl"
#include "to_sensor.glsl"
#include "firing_times.glsl"
#include "cull.glsl"
#include "lanes.glsl"
#include "dealt.glsl"
#include "deformed.glsl"

layout(local_size_x = 64) in;

float shellMin, shellMax;

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

// Returns whether a beam may hit the cluster in this shell, and sets `nearest`, the distance of its box in metres.
// `deformer` is that of the instance's mesh.
bool seen(uint number, Instance instance, Deformer deformer, uint cluster, out float nearest) {
  vec3 meshLow, meshHigh, low, high;
  bool deformed = DEFORMED != kDeformsNothing && deformer.deformed != 0;
  if (deformed) {
    deformedBox(deformer, cluster, meshLow, meshHigh);
  } else {
    Group box = loadedBox(cluster);
    meshLow = box.low;
    meshHigh = box.high;
  }
  sensorBox(instance, meshLow, meshHigh, low, high);
  if (MOTION) widenByMotion(number, meshLow, meshHigh, low, high);
  nearest = nearestPoint(low, high);
  bool inShell = !(nearest < shellMin) && !(nearest >= shellMax);
  // The cone is tested last because then most clusters do not have to load it.
  return inShell && !outOfSight(low, high) && (APART || deformed || !showsItsBack(instance, cluster));
}

// Records the rows that the part of a box beyond this shell may cover. The farthest-range table is computed only for
// these rows.
void noteLater(vec3 low, vec3 high, inout uvec2 later) {
  if (APART) setSeeming(seemingAngle(motion.shift, motion.turn, shellMax));  // bounds all content beyond the shell
  float keyMin, keyMax;
  coverKeys(low, high, shellMax, keyMin, keyMax);
  uint first, end;
  // The range is widened by one lookup cell, because the boxes of clusters are rounded to whole cells.
  rowsBetween(keyMin - 2.0 / float(lookupCells()), keyMax + 2.0 / float(lookupCells()), first, end);
  later = max(later, uvec2(frame.rows - first, end));
}

// Appends clusters to the list of the shell. With slabs, where stage project tries beams itself, those in the far halves
// of their groups come last, because the near halves often hide them; they are listed from the end of the array on. All
// lanes of the subgroup must call this.
void list(bool keep, bool behind, uint instance, uint cluster, inout bool any) {
  uvec4 all = ballotOf(keep), near = all;
  uint count = subgroupBallotBitCount(all), nearCount = count, slot = 0, slotBehind = 0;
  if (count == 0) return;
  any = true;
  if (BINNING == kBinningSlabs) {
    near = ballotOf(keep && !behind);
    nearCount = subgroupBallotBitCount(near);
  }
  if (isFirstLane()) {
    if (nearCount > 0) slot = atomicAdd(shells.of[pass.shell].visible, nearCount);
    if (nearCount < count) slotBehind = atomicAdd(shells.of[pass.shell].visibleBehind, count - nearCount);
  }
  slot = slotAfter(slot, near);
  if (BINNING == kBinningSlabs) {
    slotBehind = slotAfter(slotBehind, all) - subgroupBallotExclusiveBitCount(near);
    if (behind) slot = pass.clusters - 1 - slotBehind;
  }
  if (keep) visible.at[slot] = uvec2(instance, cluster);
}

// Lists the visible clusters of the group that lane `lane` has taken.
void listClusters(uvec2 pair, uvec2 run, float middle, uint lane, inout bool any) {
  pair = subgroupShuffle(pair, lane);
  run = subgroupShuffle(run, lane);
  middle = subgroupShuffle(middle, lane);
  Instance instance = instanceAt(pair.x);
  setView(pair.x);
  Deformer deformer;
  if (DEFORMED != kDeformsNothing) deformer = deformerOf(pair.x);
  for (uint k = 0; k < run.y; k += gl_SubgroupSize) {
    uint cluster = run.x + k + gl_SubgroupInvocationID;
    float nearest = 0.0;
    bool keep = k + gl_SubgroupInvocationID < run.y && seen(pair.x, instance, deformer, cluster, nearest);
    list(keep, nearest > middle, pair.x, cluster, any);
  }
}

// Hands groups that reach beyond this shell on to the next one.
void handOn(bool goesOn, uvec4 entry, inout bool any) {
  uvec4 ballot = ballotOf(goesOn);
  uint slot = 0, count = subgroupBallotBitCount(ballot);
  if (count == 0) return;
  if (isFirstLane()) slot = atomicAdd(shells.of[pass.shell + 1].groups, count);
  slot = slotAfter(slot, ballot);
  if (goesOn) shellGroups.at[(pass.shell + 1 & 1) * pass.placedCount + slot] = entry;
  any = true;
}

void main() {
  useOwnAddresses();
  loadMotion();
  bool first_ = pass.shell == 0 || pass.shell == kMostShells;
  shellMin = first_ ? 0.0 : shells.of[pass.shell - 1].end;
  shellMax = pass.last != 0 ? uintBitsToFloat(0x7f800000u) : shells.of[pass.shell].end;
  uint count = shells.of[pass.shell].groups, half_ = (pass.shell & 1) * pass.placedCount;
  // If there are few groups, every subgroup takes one at a time.
  uint subgroups = gl_NumWorkGroups.x * gl_NumSubgroups, lane = gl_SubgroupInvocationID;
  uint share = clamp((count + subgroups - 1) / subgroups, 1, gl_SubgroupSize);
  bool anyVisible = false, anyLater = false;
  uvec2 later = uvec2(0);
  uint group = dealt(gl_WorkGroupID.x, gl_NumWorkGroups.x);
  for (uint first = (group * gl_NumSubgroups + gl_SubgroupID) * share; first < count;
       first += subgroups * share) {
    bool keep = false, goesOn = false;
    uvec4 entry = uvec4(0);
    uvec2 run = uvec2(0);
    float middle = 0.0;  // distance of the middle of the group
    if (lane < share && first + lane < count) {
      entry = shellGroups.at[half_ + first + lane];
      // Nothing comes after the last shell, not even what lies infinitely far.
      goesOn = pass.last == 0 && uintBitsToFloat(entry.z) >= shellMax;
      if (goesOn) {
        later = max(later, uvec2(frame.rows - (entry.w & 0xffff), entry.w >> 16));
      } else {
        vec3 low, high;
        Group group = loadedGroup(entry.y);
        sensorBox(loadedInstance(entry.x), group.low, group.high, low, high);
        middle = length(0.5 * (low + high));
        setView(entry.x);
        if (MOTION) widenByMotion(entry.x, group.low, group.high, low, high);
        keep = pass.occluders == 0 || !outOfSight(low, high);
        if (keep) run = uvec2(group.clusterFirst, group.clusterCount);
        goesOn = pass.last == 0 && run.y > 1 && farthestPoint(low, high) >= shellMax;
        if (goesOn) noteLater(low, high, later);
      }
    }
    handOn(goesOn, entry, anyLater);
    // The box of a group with one cluster is the cluster's.
    list(keep && run.y == 1, false, entry.x, run.x, anyVisible);
    for (uint k = 0; k < share; ++k)
      if (subgroupShuffle(run.y, k) > 1) listClusters(entry.xy, run, middle, k, anyVisible);
  }
  later = uvec2(subgroupMax(later.x), subgroupMax(later.y));
  if (!subgroupElect()) return;
  if (later.y > 0) {
    atomicMax(shells.of[pass.shell].laterRowsDown, later.x);
    atomicMax(shells.of[pass.shell].laterRowsUp, later.y);
  }
  if (anyLater) atomicMax(shells.of[pass.shell + 1].clusterWork.x, frame.cullWorkgroups);
  if (anyVisible) atomicMax(shells.of[pass.shell].triangleWork.x, frame.triangleWorkgroups);
}
