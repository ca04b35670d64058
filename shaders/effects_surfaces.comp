// SPDX-License-Identifier: Apache-2.0
// Stage effects, what was met: the surface under every hit of one chunk of the scene, from its owner.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#define RESULTS_ARE_READ
#include "shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "effects/parameters.h"
#include "effects/vector.h"
#include "effects_bindings.glsl"
#include "place.glsl"
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

void look(uint row, uint column, uint at, uvec2 owner) {
  uint base = meshPlaces[instanceMeshes[owner.y]];
  if (base == kNone) return;  // in another chunk
  uint place = trianglePlaces[base + owner.x];
  if (place == kNone) return;
  uint cluster = place / kClusterTriangles;
  Corners corners = cornersOf(instances[owner.y], cluster, place % kClusterTriangles);
  vec3 point = points[at].xyz;
#ifdef MOTION
  vec4 angles = rows[row].angles;
  vec2 azimuth = AZIMUTH_OFFSETS ? shiftedAzimuth(columns[column], rows[row].offset) : columns[column];
  corners = seenFrom(corners, owner.y, column, row, azimuth);
  point = beamOf(azimuth, angles.x, angles.y).direction * points[at].w;
  vec3 normal = reportedDirection(column, normalOf(corners));
#else
  vec3 normal = normalOf(corners);
#endif
  surfaces[at] = vec4(normal, uintBitsToFloat(clusterMaterials[cluster]));
  if ((FIELDS & kFieldBarycentrics) != 0) barycentrics[at] = barycentricsOf(corners, point);
}

void main() {
  uint row = gl_WorkGroupID.y, channel = uint(rows[row].angles.w);
  uint first = gl_WorkGroupID.x * kResolveColumns, end = min(first + kResolveColumns, frame.columns);
  for (uint column = first + gl_LocalInvocationID.x; column < end; column += gl_WorkGroupSize.x) {
    uint at = (channel * frame.columns + column) * RETURNS;
    uvec2 owner = owners[at];
    if (owner.x == kNone)
      surfaces[at] = vec4(vec3(0.0), uintBitsToFloat(kNone));
    else
      look(row, column, at, owner);
  }
}
