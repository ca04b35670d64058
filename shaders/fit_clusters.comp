// SPDX-License-Identifier: Apache-2.0
// Before the scans of a recording: takes the vertices of meshes from buffers of the caller to `positions`, and fits the
// boxes of clusters and groups to them. One workgroup per group of clusters, one subgroup per cluster.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#define OUTSIDE_OF_SCANS
#include "common/shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "limits.glsl"

layout(local_size_x = 64) in;

const uint kMostSubgroups = gl_WorkGroupSize.x / 4;
shared vec3 lows[kMostSubgroups];
shared vec3 highs[kMostSubgroups];

// The mesh that the workgroup is at: its number in vertexSources, and the caller's buffer.
uint sourceNumber;
VertexSource source;
CallerMemory memory;

// Returns the 16 bits at a place in bytes.
uint halfWord(uint place) { return memory.at[place / 4] >> 8 * (place & 2) & 0xffff; }

// Returns a vertex by its number in the mesh. Integers of 16 bits become floats without rounding.
vec3 vertexOfMesh(uint number) {
  uint place = number * source.stride;
  if (source.format == kVertexF32)
    return uintBitsToFloat(uvec3(memory.at[place / 4], memory.at[place / 4 + 1], memory.at[place / 4 + 2]));
  uvec3 bits = uvec3(halfWord(place), halfWord(place + 2), halfWord(place + 4));
  vec3 value = vec3(bits);
  if (source.format == kVertexS16) value = vec3(ivec3(bits << 16) >> 16);
  if (source.format == kVertexSnorm16) value = vec3(max(ivec3(bits << 16) >> 16, ivec3(-32767)));
  precise vec3 position = value * source.scale + source.offset;
  return position;
}

// Returns a vertex by its entry in `positions`.
vec3 vertexAt(uint vertex) { return vertexOfMesh(vertexNumbers.at[source.numberFirst + vertex - source.vertexFirst]); }

// Stores the vertices of a cluster and extends a box by them. A vertex beyond the limits becomes NaN, because no triangle
// may have it as a corner, and is not in the box.
void takeVertices(uint first, uint count, inout vec3 low, inout vec3 high) {
  for (uint k = gl_SubgroupInvocationID; k < count; k += gl_SubgroupSize) {
    vec3 position = vertexAt(first + k);
    bool usable = inLimits(position);
    positions.at[first + k] = usable ? position : uintBitsToFloat(uvec3(0x7fc00000u));
    if (!usable) continue;
    low = min(low, position);
    high = max(high, position);
  }
}

// Counts the triangles of a cluster that cannot be hit. All stay in the cluster: stage project drops those with a NaN,
// and no beam hits one with two corners at one place.
void countDropped(uint cluster) {
  uint first = clusters.at[cluster].triangleFirst, count = clusters.at[cluster].triangleCount;
  uint vertexFirst = clusters.at[cluster].vertexFirst;
  uvec2 dropped = uvec2(0);
  for (uint k = gl_SubgroupInvocationID; k < count; k += gl_SubgroupSize) {
    uint packed = triangleCorners.at[first + k].x;
    uvec3 vertices = vertexFirst + (uvec3(packed, packed >> 8, packed >> 16) & 0xff);
    vec3 a = vertexAt(vertices.x), b = vertexAt(vertices.y), c = vertexAt(vertices.z);
    bool finite = inLimits(a) && inLimits(b) && inLimits(c);
    dropped += uvec2(!finite, finite && (a == b || b == c || c == a));
  }
  dropped = subgroupAdd(dropped);
  if (subgroupElect() && dropped != uvec2(0)) {
    atomicAdd(droppedTriangles.at[2 * sourceNumber], dropped.x);
    atomicAdd(droppedTriangles.at[2 * sourceNumber + 1], dropped.y);
  }
}

void fitCluster(uint cluster, inout vec3 groupLow, inout vec3 groupHigh) {
  vec3 low = vec3(kCoordinateLimit), high = vec3(-kCoordinateLimit);
  takeVertices(clusters.at[cluster].vertexFirst, clusters.at[cluster].vertexCount, low, high);
  countDropped(cluster);
  low = subgroupMin(low);
  high = subgroupMax(high);
  groupLow = min(groupLow, low);
  groupHigh = max(groupHigh, high);
  if (subgroupElect()) {
    clusters.at[cluster].low = low;
    clusters.at[cluster].high = high;
  }
}

void main() {
  useOwnAddresses();
  for (uint work = gl_WorkGroupID.x; work < pass.placedCount; work += gl_NumWorkGroups.x) {
    uvec2 pair = sourceGroups.at[work];
    sourceNumber = pair.x;
    source = vertexSources.at[sourceNumber];
    memory = CallerMemory(vertexBuffers.at[sourceNumber].memory);
    uint first = groups.at[pair.y].clusterFirst, count = groups.at[pair.y].clusterCount;
    vec3 low = vec3(kCoordinateLimit), high = vec3(-kCoordinateLimit);
    for (uint k = gl_SubgroupID; k < count; k += gl_NumSubgroups) fitCluster(first + k, low, high);
    if (subgroupElect()) {
      lows[gl_SubgroupID] = low;
      highs[gl_SubgroupID] = high;
    }
    barrier();
    if (gl_LocalInvocationID.x == 0) {
      for (uint k = 0; k < gl_NumSubgroups; ++k) {  // this invocation may belong to any subgroup
        low = min(low, lows[k]);
        high = max(high, highs[k]);
      }
      groups.at[pair.y].low = low;
      groups.at[pair.y].high = high;
    }
    barrier();
  }
}
