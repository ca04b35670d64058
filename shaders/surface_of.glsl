// SPDX-License-Identifier: Apache-2.0
// Finds the surface of a hit from the hit's owner: the corners, the normal and the material of the triangle as the beam
// sees it.
#include "deformed.glsl"

struct Corners {
  vec3 a, b, c;
};

vec3 cornerOf(Instance instance, uint vertex) {
  vec3 p = toSensor(instance, positions.at[vertex]);
  return INSIDE == kInsideExact ? onLattice(p) : p;
}

// Returns the entries in `positions` of the corners of triangle k of a cluster.
uvec3 verticesOf(uint cluster, uint k) {
  uint packed = triangleCorners.at[clusters.at[cluster].triangleFirst + k].x;
  return clusters.at[cluster].vertexFirst + (uvec3(packed, packed >> 8, packed >> 16) & 0xffu);
}

Corners cornersOf(Instance instance, uvec3 vertices) {
  return Corners(cornerOf(instance, vertices.x), cornerOf(instance, vertices.y), cornerOf(instance, vertices.z));
}

// Returns the unit normal on the side that the sensor sees; 0 for a triangle without area.
vec3 normalOf(Corners t) {
  GNO_PRECISE vec3 u = t.b - t.a;
  GNO_PRECISE vec3 v = t.c - t.a;
  return unitTowardsOrigin(crossOf(u, v), t.a);
}

// Returns the velocities of the corners of a triangle that moves, m/s in the sensor's axes.
Corners velocitiesOf(InstanceMotion moving, uint instance, Corners t, uint cluster, uvec3 vertices) {
  return Corners(vertexVelocity(moving, instance, t.a, cluster, vertices.x), vertexVelocity(moving, instance, t.b, cluster, vertices.y),
                 vertexVelocity(moving, instance, t.c, cluster, vertices.z));
}

// Returns the corners in the frame of the column when it fires, as seen from the laser.
Corners seenFrom(Corners t, Corners velocities, uint column, uint row, vec2 azimuth) {
  ColumnMotion at = columnMotionOf(row, column);
  vec3 origin = originOf(row, azimuth);
  return Corners(inColumn(at, t.a, velocities.a) - origin, inColumn(at, t.b, velocities.b) - origin,
                 inColumn(at, t.c, velocities.c) - origin);
}

Corners seenFrom(Corners t, uint column, uint row, vec2 azimuth) {
  ColumnMotion at = columnMotionOf(row, column);
  vec3 origin = originOf(row, azimuth);
  return Corners(inColumn(at, t.a) - origin, inColumn(at, t.b) - origin, inColumn(at, t.c) - origin);
}

struct Surface {
  Corners corners;     // as the beam sees them
  Corners velocities;  // of the corners, m/s in the sensor's axes; only if instances move
  vec3 normal;
  uint material;
};

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

Surface noSurface() {
  Surface surface;
  surface.normal = vec3(0.0);
  surface.material = kNone;
  return surface;
}

// Returns the surface that the beam with this index has hit.
Surface surfaceOf(uint index, uvec2 owner) {
  Surface surface = noSurface();
  if (owner.x == kNone) return surface;
  uint slot = triangleSlots.at[meshTriangles.at[instanceMeshes.at[owner.y]] + owner.x];
  uint cluster = slot / kClusterTriangles;
  uvec3 vertices = verticesOf(cluster, slot % kClusterTriangles);
  surface.corners = cornersOf(instances.at[owner.y], vertices);
  if (MOTION) {
    uint column = columnOf(index), row = rowOf(index);
    vec2 azimuth = beamWith(index).azimuth;
    if (motion.instances != 0) {
      surface.velocities = velocitiesOf(instanceMotions.at[owner.y], owner.y, surface.corners, cluster, vertices);
      surface.corners = seenFrom(surface.corners, surface.velocities, column, row, azimuth);
    } else {
      surface.corners = seenFrom(surface.corners, column, row, azimuth);
    }
  }
  surface.normal = normalOf(surface.corners);
  if (MOTION) surface.normal = reportedDirection(rowOf(index), columnOf(index), surface.normal);
  surface.material = clusters.at[cluster].material;
  return surface;
}
