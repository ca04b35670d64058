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

// Returns the unit normal on the side that the sensor sees.
vec3 normalOf(Corners t) {
  GNO_PRECISE vec3 u = t.b - t.a;
  GNO_PRECISE vec3 v = t.c - t.a;
  return unitTowardsOrigin(crossOf(u, v), t.a);
}

// Returns the velocities of the corners of a triangle that moves, m/s in the sensor's axes.
Corners velocitiesOf(InstanceMotion moving, uint instance, uint cluster, uvec3 vertices) {
  return Corners(vertexVelocity(moving, instance, cluster, vertices.x),
                 vertexVelocity(moving, instance, cluster, vertices.y),
                 vertexVelocity(moving, instance, cluster, vertices.z));
}

struct Surface {
  Corners corners;     // as the beam sees them
  Corners velocities;  // of the corners, m/s in the sensor's axes; only if instances move
  vec3 normal;
  uint material;
};

// Returns the barycentric weights of the second and third corner, which are never negative and together at most 1.
// Weights are the areas of the three parts into which the point divides the triangle, seen along the axis that the
// triangle faces most. Corners are taken relative to the point, so that the errors of a long and narrow triangle grow as
// its length over its height, and not as the square of that.
vec2 barycentricsOf(Corners t, vec3 p) {
  GNO_PRECISE vec3 a = t.a - p;
  GNO_PRECISE vec3 b = t.b - p;
  GNO_PRECISE vec3 c = t.c - p;
  vec3 first = crossOf(b, c), second = crossOf(c, a), third = crossOf(a, b);
  GNO_PRECISE vec3 normal = first + second + third;
  vec3 size = abs(normal), parts = vec3(first.z, second.z, third.z);
  float whole = normal.z;
  if (size.x >= max(size.y, size.z)) {
    parts = vec3(first.x, second.x, third.x);
    whole = normal.x;
  } else if (size.y >= size.z) {
    parts = vec3(first.y, second.y, third.y);
    whole = normal.y;
  }
  parts = max(whole < 0.0 ? -parts : parts, vec3(0.0));
  GNO_PRECISE float area = parts.x + parts.y + parts.z;
  return area > 0.0 ? vec2(quotient(parts.y, area), quotient(parts.z, area)) : vec2(0.0);
}

Surface noSurface() {
  Surface surface;
  surface.normal = vec3(0.0);
  surface.material = kNone;
  return surface;
}

// Returns the surface of a triangle in the frame in which scenes are projected, whatever moves. With motion it has no
// normal yet.
Surface placedSurfaceOf(uvec2 owner) {
  Surface surface = noSurface();
  if (owner.x == kNone) return surface;
  uint slot = triangleSlots.at[meshTriangles.at[instanceMeshes.at[owner.y]] + owner.x];
  uint cluster = slot / kClusterTriangles;
  uvec3 vertices = verticesOf(cluster, slot % kClusterTriangles);
  surface.corners = cornersOf(instances.at[owner.y], vertices);
  if (!MOTION)
    surface.normal = normalOf(surface.corners);
  else if (motion.instances != 0)
    surface.velocities = velocitiesOf(instanceMotions.at[owner.y], owner.y, cluster, vertices);
  surface.material = clusters.at[cluster].material;
  return surface;
}

// Returns a placed surface as a beam sees it from its laser, when the sensor is at `at`.
Surface seenSurface(Surface surface, ColumnMotion at, vec3 laser) {
  if (!MOTION || surface.material == kNone) return surface;
  Corners t = surface.corners, v = surface.velocities;
  if (motion.instances != 0)
    surface.corners =
        Corners(inColumn(at, t.a, v.a) - laser, inColumn(at, t.b, v.b) - laser, inColumn(at, t.c, v.c) - laser);
  else
    surface.corners = Corners(inColumn(at, t.a) - laser, inColumn(at, t.b) - laser, inColumn(at, t.c) - laser);
  surface.normal = reportedDirection(at, normalOf(surface.corners));
  return surface;
}

Surface surfaceOf(uvec2 owner, ColumnMotion at, vec3 laser) { return seenSurface(placedSurfaceOf(owner), at, laser); }
