// SPDX-License-Identifier: Apache-2.0
// Stage effects, what was met: the surface under every hit of one chunk of the scene, from its owner. Neighbouring beams
// mostly meet the same triangle: the first of them asks for all.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_shuffle : require
#define RESULTS_ARE_READ
#include "shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "effects/parameters.h"
#include "effects/vector.h"
#include "effects_bindings.glsl"
#include "to_sensor.glsl"
#include "lattice.glsl"
#include "beam.glsl"
#ifdef MOTION
#include "motion.glsl"
#endif

layout(local_size_x = 64) in;

struct Corners {
  vec3 a, b, c;
};

vec3 cornerOf(Instance instance, uint vertex) {
  vec3 p = toSensor(instance, positions[vertex]);
  return INSIDE == kInsideExact ? snapToLattice(p) : p;
}

Corners cornersOf(Instance instance, uint cluster, uint k) {
  uint vertexFirst = floatBitsToUint(clusters[cluster].low.w) & (kChunkVertices - 1);
  uint triangleFirst = floatBitsToUint(clusters[cluster].high.w) & (kChunkTriangles - 1);
  uint packed = triangleCorners[triangleFirst + k].x;
  return Corners(cornerOf(instance, vertexFirst + (packed & 0xff)), cornerOf(instance, vertexFirst + (packed >> 8 & 0xff)),
                 cornerOf(instance, vertexFirst + (packed >> 16 & 0xff)));
}

// Unit normal of the side that the sensor sees; 0 for a triangle without area.
vec3 normalOf(Corners t) {
  GNO_PRECISE vec3 u = t.b - t.a;
  GNO_PRECISE vec3 v = t.c - t.a;
  return unitTowardsOrigin(crossOf(u, v), t.a);
}

// Weights of the second and third corner (Ericson, Real-Time Collision Detection, 3.4).
vec2 barycentricsOf(Corners t, vec3 p) {
  GNO_PRECISE vec3 u = t.b - t.a;
  GNO_PRECISE vec3 v = t.c - t.a;
  GNO_PRECISE vec3 w = p - t.a;
  GNO_PRECISE float uu = dotOf(u, u), uv = dotOf(u, v), vv = dotOf(v, v), wu = dotOf(w, u), wv = dotOf(w, v);
  GNO_PRECISE float area = uu * vv - uv * uv;
  GNO_PRECISE float second = vv * wu - uv * wv, third = uu * wv - uv * wu;
  return area > 0.0 ? vec2(quotient(second, area), quotient(third, area)) : vec2(0.0);
}

#ifdef MOTION
vec2 azimuthAt(uint row, uint column) {
  return AZIMUTH_OFFSETS ? shiftedAzimuth(columns[column], rows[row].offset) : columns[column];
}

Corners seenFrom(Corners t, uint instance, uint column, uint row, vec2 azimuth) {
  ColumnMotion at = columnMotions[column];
  vec3 origin = originOf(row, azimuth);
  if (motion.instances == 0)
    return Corners(inColumn(at, t.a) - origin, inColumn(at, t.b) - origin, inColumn(at, t.c) - origin);
  InstanceMotion moving = instanceMotions[instance];
  return Corners(inColumn(at, t.a, velocityOf(moving, t.a)) - origin, inColumn(at, t.b, velocityOf(moving, t.b)) - origin,
                 inColumn(at, t.c, velocityOf(moving, t.c)) - origin);
}
#endif

struct Surface {
  Corners corners;
  vec3 normal;
  uint material;
  bool known;  // false in another chunk
};

Surface surfaceOf(uint row, uint column, uvec2 owner) {
  Surface surface;
  surface.normal = vec3(0.0);
  surface.material = kNone;
  surface.known = owner.x == kNone;
  if (surface.known) return surface;
  uint base = meshPlaces[instanceMeshes[owner.y]];
  if (base == kNone) return surface;
  uint place = trianglePlaces[base + owner.x];
  if (place == kNone) return surface;
  uint cluster = place / kClusterTriangles;
  surface.corners = cornersOf(instances[owner.y], cluster, place % kClusterTriangles);
#ifdef MOTION
  surface.corners = seenFrom(surface.corners, owner.y, column, row, azimuthAt(row, column));
  surface.normal = reportedDirection(column, normalOf(surface.corners));
#else
  surface.normal = normalOf(surface.corners);
#endif
  surface.material = clusterMaterials[cluster];
  surface.known = true;
  return surface;
}

vec3 pointOf(uint row, uint column, uint at) {
#ifdef MOTION
  vec4 angles = rows[row].angles;
  return beamOf(azimuthAt(row, column), angles.x, angles.y).direction * points[at].w;
#else
  return points[at].xyz;
#endif
}

#ifndef MOTION
// Whether a lane is the first of those with its owner.
bool leads(uvec2 owner) {
  uint lane = gl_SubgroupInvocationID;
  return lane == 0 || owner != subgroupShuffle(owner, (lane - 1) & (gl_SubgroupSize - 1));
}

// The lane itself if it leads, or else the last one before it that does.
uint leaderOf(bool leading) {
  uint lane = gl_SubgroupInvocationID, leader = leading ? lane : kNone;
  for (uint step = 1; step < gl_SubgroupSize; step *= 2) {
    uint before = subgroupShuffle(leader, (lane - step) & (gl_SubgroupSize - 1));
    if (leader == kNone && lane >= step) leader = before;
  }
  return leader;
}

// What the leader knows.
Surface told(Surface surface, uint leader) {
  surface.normal = subgroupShuffle(surface.normal, leader);
  surface.material = subgroupShuffle(surface.material, leader);
  surface.known = subgroupShuffle(uint(surface.known), leader) != 0;
  if ((FIELDS & kFieldBarycentrics) != 0)
    surface.corners = Corners(subgroupShuffle(surface.corners.a, leader), subgroupShuffle(surface.corners.b, leader),
                              subgroupShuffle(surface.corners.c, leader));
  return surface;
}
#endif

void main() {
  uint row = gl_WorkGroupID.y, channel = uint(rows[row].angles.w);
  uint first = gl_WorkGroupID.x * kResolveColumns, end = min(first + kResolveColumns, frame.columns);
  // No lane leaves before the others: they tell one another.
  for (uint from = first; from < end; from += gl_WorkGroupSize.x) {
    uint column = min(from + gl_LocalInvocationID.x, end - 1);
    uint at = (channel * frame.columns + column) * RETURNS;
    uvec2 owner = owners[at];
#ifdef MOTION
    Surface surface = surfaceOf(row, column, owner);  // each sees it at a time of its own
#else
    bool leading = leads(owner);
    Surface surface;
    if (leading) surface = surfaceOf(row, column, owner);
    surface = told(surface, leaderOf(leading));
#endif
    if (!surface.known || from + gl_LocalInvocationID.x >= end) continue;
    surfaces[at] = vec4(surface.normal, uintBitsToFloat(surface.material));
    if ((FIELDS & kFieldBarycentrics) != 0 && owner.x != kNone)
      barycentrics[at] = barycentricsOf(surface.corners, pointOf(row, column, at));
  }
}
