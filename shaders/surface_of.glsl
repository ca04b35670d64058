// SPDX-License-Identifier: Apache-2.0
// Finds the surface of a hit from the hit's owner: the corners, the normal and the material of the triangle as the beam
// sees it.

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

Corners seenFrom(Corners t, uint instance, uint column, uint row, vec2 azimuth) {
  ColumnMotion at = columnMotionOf(column);
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

// Returns the surface that the beam with this index has hit.
Surface surfaceOf(uint index, uvec2 owner) {
  Surface surface;
  surface.normal = vec3(0.0);
  surface.material = kNone;
  if (owner.x == kNone) return surface;
  uint slot = triangleSlots.at[meshTriangles.at[instanceMeshes.at[owner.y]] + owner.x];
  uint cluster = slot / kClusterTriangles;
  surface.corners = cornersOf(instances.at[owner.y], cluster, slot % kClusterTriangles);
  if (MOTION) surface.corners = seenFrom(surface.corners, owner.y, columnOf(index), rowOf(index), beamWith(index).azimuth);
  surface.normal = normalOf(surface.corners);
  if (MOTION) surface.normal = reportedDirection(columnOf(index), surface.normal);
  surface.material = clusters.at[cluster].material;
  return surface;
}
