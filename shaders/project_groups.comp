// SPDX-License-Identifier: Apache-2.0
// First pass of the stage project. One invocation per placed group of clusters. Lists the groups in which a beam may
// hit something, for the first shell. A second run of this shader, in one workgroup, chooses the shells.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_ballot : require
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
#include "buckets.glsl"

layout(local_size_x = 64) in;

// The rows that the box may cover: the first one, and the one after the last << 16. The rows are widened by one lookup
// cell, because the boxes of clusters are rounded to whole cells.
uint rowsOf(vec3 low, vec3 high) {
  if (seeming > 1.0) return frame.rows << 16;
  float keyMin, keyMax;
  coverKeys(low, high, 0.0, keyMin, keyMax);
  uint first, end;
  rowsBetween(keyMin - 2.0 / float(lookupCells()), keyMax + 2.0 / float(lookupCells()), first, end);
  return first | end << 16;
}

// Adds the clusters of a group to the buckets, as if they were spread evenly between its nearest and farthest point.
void countClusters(uint count, float nearest, float farthest_) {
  const uint kParts = 4;
  for (uint part = 0; part < min(count, kParts); ++part)
    atomicAdd(shells.clusters[bucketOf(nearest + (farthest_ - nearest) * (float(part) / float(kParts)))],
              (count + kParts - 1 - part) / kParts);
}

void listGroups() {
  uint stride = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
  uint rounds = (pass.placedCount + stride - 1) / stride, half_ = (pass.shell & 1) * pass.placedCount;
  for (uint k = 0; k < rounds; ++k) {
    uint i = k * stride + gl_WorkGroupID.x * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
    bool keep = false;
    uvec4 entry = uvec4(0);
    if (i < pass.placedCount) {
      uvec2 pair = placed.at[pass.placedFirst + i];
      vec3 low, high;
      Group group = loadedGroup(pair.y);
      sensorBox(loadedInstance(pair.x), group.low, group.high, low, high);
      setView(pair.x);
      if (MOTION) widenByMotion(pair.x, group.low, group.high, low, high);
      keep = !outOfSight(low, high);
      float nearest = nearestPoint(low, high);
      entry = uvec4(pair, floatBitsToUint(nearest), rowsOf(low, high));
      if (keep && pass.last == 0) countClusters(group.clusterCount, nearest, farthestPoint(low, high));
    }
    uvec4 ballot = ballotOf(keep);
    uint slot = 0;
    if (isFirstLane()) slot = atomicAdd(shells.of[pass.shell].groups, subgroupBallotBitCount(ballot));
    slot = slotAfter(slot, ballot);
    if (keep) shellGroups.at[half_ + slot] = entry;
  }
}

// A shell ends where it has a multiple of the clusters of the one before, because the farthest-range table costs the
// same after every shell, or at the hint. The rest goes to the last shell if it is hardly more than one shell's worth.
void chooseShells() {
  uint left = 0;
  for (uint k = 0; k < kShellBuckets; ++k) left += shells.clusters[k];
  uint bucket = 0, sum = 0, wanted = frame.shellClusters;
  bool hinted = frame.shellHint > 0.0;
  for (uint shell = 0; shell < frame.shellCount; ++shell) {
    uint inShell = 0;
    bool full = false;
    while (!full && bucket < kShellBuckets) {
      inShell += shells.clusters[bucket];
      float end = endOfBucket(bucket);
      ++bucket;
      bool atHint = hinted && end >= frame.shellHint;
      if (atHint) hinted = false;
      full = inShell >= wanted || (atHint && inShell > 0);
    }
    left -= inShell;
    bool last = shell == frame.shellCount - 1 || bucket == kShellBuckets || left < frame.shellClusters;
    shells.of[shell].end = last ? uintBitsToFloat(0x7f800000u) : endOfBucket(bucket - 1);
    if (last) break;
    wanted *= kShellGrowth;
  }
}

void main() {
  useOwnAddresses();
  loadMotion();
  if (gl_WorkGroupID.x == 0 && gl_LocalInvocationID.x == 0) counters.alive = kAlive;
  if (PASS == kPassGroupsList) {
    listGroups();
  } else if (gl_LocalInvocationID.x == 0) {
    chooseShells();
    for (uint k = 0; k <= kMostShells; ++k) {
      shells.of[k].clusterWork = Workgroups(k == 0 ? frame.cullWorkgroups : 0, 1, 1);
      shells.of[k].triangleWork = Workgroups(0, 1, 1);
      shells.of[k].binWork = Workgroups(0, 1, 1);
    }
  }
}
