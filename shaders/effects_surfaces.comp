// SPDX-License-Identifier: Apache-2.0
// Stage effects: finds the surface at every hit from the hit's owner. Neighbouring beams mostly hit the same triangle,
// so only the first of them in a subgroup loads it and shares it with the others.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_shuffle : require
#include "shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "effects/vector.h"
#include "to_sensor.glsl"
#include "beam.h"
#include "motion.glsl"
#include "strays.glsl"

layout(local_size_x = 64) in;

struct Corners {
  vec3 a, b, c;
};

vec3 cornerOf(Instance instance, uint vertex) {
  vec3 p = toSensor(instance, positions.at[vertex]);
  return INSIDE == kInsideExact ? onLattice(p) : p;
}

Corners cornersOf(Instance instance, uint cluster, uint k) {
  uint vertexFirst = clusters.at[cluster].vertexFirst, triangleFirst = clusters.at[cluster].triangleFirst;
  uint packed = triangleCorners.at[triangleFirst + k].x;
  return Corners(cornerOf(instance, vertexFirst + (packed & 0xff)), cornerOf(instance, vertexFirst + (packed >> 8 & 0xff)),
                 cornerOf(instance, vertexFirst + (packed >> 16 & 0xff)));
}

// Returns the unit normal on the side that the sensor sees; 0 for a triangle without area.
vec3 normalOf(Corners t) {
  GNO_PRECISE vec3 u = t.b - t.a;
  GNO_PRECISE vec3 v = t.c - t.a;
  return unitTowardsOrigin(crossOf(u, v), t.a);
}

// Returns the barycentric weights of the second and third corner (Ericson, Real-Time Collision Detection, 3.4).
vec2 barycentricsOf(Corners t, vec3 p) {
  GNO_PRECISE vec3 u = t.b - t.a;
  GNO_PRECISE vec3 v = t.c - t.a;
  GNO_PRECISE vec3 w = p - t.a;
  GNO_PRECISE float uu = dotOf(u, u), uv = dotOf(u, v), vv = dotOf(v, v), wu = dotOf(w, u), wv = dotOf(w, v);
  GNO_PRECISE float area = uu * vv - uv * uv;
  GNO_PRECISE float second = vv * wu - uv * wv, third = uu * wv - uv * wu;
  return area > 0.0 ? vec2(quotient(second, area), quotient(third, area)) : vec2(0.0);
}

vec2 azimuthAt(uint row, uint column) {
  return azimuthOfBeam(columns.at[column], rows.at[row].offset, AZIMUTH_OFFSETS, INSIDE == kInsideExact);
}

Corners seenFrom(Corners t, uint instance, uint column, uint row, vec2 azimuth) {
  ColumnMotion at = columnMotions.at[column];
  vec3 origin = originOf(row, azimuth);
  if (motion.instances == 0)
    return Corners(inColumn(at, t.a) - origin, inColumn(at, t.b) - origin, inColumn(at, t.c) - origin);
  InstanceMotion moving = instanceMotions.at[instance];
  return Corners(inColumn(at, t.a, velocityOf(moving, t.a)) - origin, inColumn(at, t.b, velocityOf(moving, t.b)) - origin,
                 inColumn(at, t.c, velocityOf(moving, t.c)) - origin);
}

struct Surface {
  Corners corners;
  vec3 normal;
  uint material;
};

Surface surfaceOf(uint row, uint column, uvec2 owner) {
  Surface surface;
  surface.normal = vec3(0.0);
  surface.material = kNone;
  if (owner.x == kNone) return surface;
  uint slot = triangleSlots.at[meshTriangles.at[instanceMeshes.at[owner.y]] + owner.x];
  uint cluster = slot / kClusterTriangles;
  surface.corners = cornersOf(instances.at[owner.y], cluster, slot % kClusterTriangles);
  if (MOTION) surface.corners = seenFrom(surface.corners, owner.y, column, row, azimuthAt(row, column));
  surface.normal = normalOf(surface.corners);
  if (MOTION) surface.normal = reportedDirection(column, surface.normal);
  surface.material = clusters.at[cluster].material;
  return surface;
}

// Returns the point that the beam meets, in the frame of its laser.
vec3 pointOf(uint row, uint column, uint at) {
  if (!MOTION && (EFFECTS & kStrays) == 0) return points.at[at].xyz;
  vec3 angles = rows.at[row].angles;
  Beam axis = beamOf(azimuthAt(row, column), angles.x, angles.y);
  vec3 direction = axis.direction;
  if ((EFFECTS & kStrays) != 0) direction = strayed(axis, strays.at[row * frame.columns + column]);
  return direction * points.at[at].w;
}

// True if the lane is the first of consecutive lanes with the same owner.
bool leads(uvec2 owner) {
  uint lane = gl_SubgroupInvocationID;
  return lane == 0 || owner != subgroupShuffle(owner, (lane - 1) & (gl_SubgroupSize - 1));
}

// Returns the lane itself if it is the first with its owner, otherwise the last such lane before it.
uint leaderOf(bool leading) {
  uint lane = gl_SubgroupInvocationID, leader = leading ? lane : kNone;
  for (uint step = 1; step < gl_SubgroupSize; step *= 2) {
    uint before = subgroupShuffle(leader, (lane - step) & (gl_SubgroupSize - 1));
    if (leader == kNone && lane >= step) leader = before;
  }
  return leader;
}

// Returns the leader's surface.
Surface told(Surface surface, uint leader) {
  surface.normal = subgroupShuffle(surface.normal, leader);
  surface.material = subgroupShuffle(surface.material, leader);
  if ((FIELDS & kFieldBarycentrics) != 0)
    surface.corners = Corners(subgroupShuffle(surface.corners.a, leader), subgroupShuffle(surface.corners.b, leader),
                              subgroupShuffle(surface.corners.c, leader));
  return surface;
}

void main() {
  uint row = gl_WorkGroupID.y, channel = rows.at[row].channel;
  uint first = gl_WorkGroupID.x * kResolveColumns, end = min(first + kResolveColumns, frame.columns);
  // No lane leaves the loop early, because all lanes take part in the shuffles.
  for (uint from = first; from < end; from += gl_WorkGroupSize.x) {
    uint column = min(from + gl_LocalInvocationID.x, end - 1);
    uint at = (channel * frame.columns + column) * RETURNS;
    uvec2 owner = owners.at[at];
    // With motion each beam sees its triangle at a different time, so no lane can share.
    bool leading = MOTION || leads(owner);
    Surface surface;
    if (leading) surface = surfaceOf(row, column, owner);
    if (!MOTION) surface = told(surface, leaderOf(leading));
    if (from + gl_LocalInvocationID.x >= end) continue;
    surfaces.at[at] = SurfaceRecord(surface.normal, surface.material);
    if ((FIELDS & kFieldBarycentrics) != 0 && owner.x != kNone)
      barycentrics.at[at] = barycentricsOf(surface.corners, pointOf(row, column, at));
  }
}
