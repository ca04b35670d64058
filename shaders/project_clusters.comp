// SPDX-License-Identifier: Apache-2.0
// Stage project, first pass. One invocation per placed cluster; lists those that a beam may meet. Keeps a cluster
// unless its whole box is out of range, above or below the sensor's field of view, or between two rows of beams.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#include "shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "sphere.glsl"

layout(local_size_x = 64) in;
layout(push_constant) uniform ChunkBlock { Chunk chunk; };

// The cluster's box in the sensor's frame: centre and half extents of the turned box, a little widened for rounding.
void sensorBox(Instance instance, Cluster cluster, out vec3 low, out vec3 high) {
  vec3 minimum = cluster.low.xyz, maximum = cluster.high.xyz;
  vec3 pivot = vec3(instance.row0.w, instance.row1.w, instance.row2.w);
  vec3 offset = instance.offset.xyz;
  vec3 middle = 0.5 * (minimum - pivot) + 0.5 * (maximum - pivot);
  vec3 extent = 0.5 * (maximum - minimum);
  vec3 centre = vec3(dot(instance.row0.xyz, middle), dot(instance.row1.xyz, middle), dot(instance.row2.xyz, middle)) +
                offset;
  vec3 size = vec3(dot(abs(instance.row0.xyz), extent), dot(abs(instance.row1.xyz), extent),
                   dot(abs(instance.row2.xyz), extent));
  // 1e-6 of each coordinate covers the roundings above and those of the corners' own transform.
  float length1 = abs(middle.x) + abs(middle.y) + abs(middle.z) + extent.x + extent.y + extent.z;
  float largest = max(max(abs(instance.row0.x) + abs(instance.row0.y) + abs(instance.row0.z),
                          abs(instance.row1.x) + abs(instance.row1.y) + abs(instance.row1.z)),
                      abs(instance.row2.x) + abs(instance.row2.y) + abs(instance.row2.z));
  vec3 slack = vec3(1e-6 * length1 * largest) + 1e-6 * abs(offset);
  low = centre - size - slack;
  high = centre + size + slack;
}

bool outOfRange(vec3 low, vec3 high) {
  vec3 nearest = max(max(low, -high), vec3(0.0));
  return dot(nearest, nearest) > frame.rangeMax * frame.rangeMax * 1.000001;
}

bool betweenRows(vec3 low, vec3 high) {
  vec2 nearest = max(max(low.xy, -high.xy), vec2(0.0));
  vec2 farthest = max(abs(low.xy), abs(high.xy));
  float near = length(nearest), far = length(farthest);
  float keyMax = elevationKey(high.z > 0.0 ? near : far, high.z) + kKeySlack;
  float keyMin = elevationKey(low.z < 0.0 ? near : far, low.z) - kKeySlack;
  uint first, end;
  rowsBetween(keyMin, keyMax, first, end);
  return first >= end;
}

void main() {
  uint culled = 0;
  uint stride = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
  uint rounds = (chunk.placedCount + stride - 1) / stride;
  for (uint k = 0; k < rounds; ++k) {
    uint i = k * stride + gl_WorkGroupID.x * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
    bool keep = false;
    uvec2 pair = uvec2(0);
    if (i < chunk.placedCount) {
      pair = placed[i];
      Cluster cluster = clusters[pair.y];
      vec3 low, high;
      sensorBox(instances[pair.x], cluster, low, high);
      // The paper culls triangle by triangle. Comparisons with NaN are false: such a cluster is kept.
      keep = (BOUNDS == kBoundsPaper || CULL == kCullFirstCorner) || !(outOfRange(low, high) || betweenRows(low, high));
      if (!keep) culled += (floatBitsToUint(cluster.high.w) >> 25 & 63) + 1;
    }
    uvec4 ballot = subgroupBallot(keep);
    uint slot = 0;
    if (subgroupElect()) slot = atomicAdd(counters.visible, subgroupBallotBitCount(ballot));
    slot = subgroupBroadcastFirst(slot) + subgroupBallotExclusiveBitCount(ballot);
    if (keep) visible[slot] = pair;
  }
  culled = subgroupAdd(culled);
  if (subgroupElect() && culled > 0) atomicAdd(counters.culledByCluster, culled);
}
