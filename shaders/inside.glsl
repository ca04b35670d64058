// SPDX-License-Identifier: Apache-2.0
// Does a beam meet a triangle, and at what range? Both stages that ask, bin and resolve, ask here.

struct Triangle {
  vec3 a, b, c;    // sensor frame
  uint id;         // placed triangle
  bool oneSided;   // only its front reflects: counter-clockwise to the sensor's eye
  float rangeMin;  // no point of it is nearer
};

// What lies behind this cannot change the answer of the beam; each stage says what it knows. Only `exact` asks, whose
// ranges are dear.
float farthestOf(uint index);

#include "inside_plain.glsl"
#include "inside_watertight.glsl"
#include "inside_exact.glsl"

Triangle loadProjected(uint i) {
  uint id = projectedIds[i];
  Triangle triangle;
  triangle.a = vec3(projectedA[3 * i], projectedA[3 * i + 1], projectedA[3 * i + 2]);
  triangle.b = vec3(projectedB[3 * i], projectedB[3 * i + 1], projectedB[3 * i + 2]);
  triangle.c = vec3(projectedC[3 * i], projectedC[3 * i + 1], projectedC[3 * i + 2]);
  triangle.id = id & 0x7fffffffu;
  triangle.oneSided = (id >> 31) != 0;
  triangle.rangeMin = projectedBoxes[i].rangeMin;
  return triangle;
}

// A beam: cos and sin of azimuth and elevation, and the direction they make.
struct Beam {
  vec2 azimuth;
  float cosElevation, sinElevation;
  vec3 direction;
};

// The same operations wherever a beam is asked for, so every triangle sees the same beam.
Beam beamOf(vec2 column, uint row) {
  Beam beam;
  beam.azimuth = column;
  if (AZIMUTH_OFFSETS) {
    precise float c = column.x * rows[row].cosOffset - column.y * rows[row].sinOffset;
    precise float s = column.y * rows[row].cosOffset + column.x * rows[row].sinOffset;
    beam.azimuth = INSIDE == kInsideExact ? snapToLattice(vec3(c, s, 0.0)).xy : vec2(c, s);
  }
  beam.cosElevation = rows[row].cosElevation;
  beam.sinElevation = rows[row].sinElevation;
  precise vec2 horizontal = beam.cosElevation * beam.azimuth;
  beam.direction = vec3(horizontal, beam.sinElevation);
  return beam;
}

// What the tests need of a triangle whatever the beam; what a pipeline does not use, it does not compute.
struct Prepared {
  EdgeNormals normals;
  vec4 plane;
  ExactTriangle exact;
};

Prepared prepare(Triangle triangle) {
  Prepared prepared;
  if (INSIDE == kInsidePlain) prepared.normals = edgeNormals(triangle);
  if (RANGE == kRangePlane) prepared.plane = supportingPlane(triangle);
  if (INSIDE == kInsideExact) prepared.exact = exactTriangle(triangle);
  return prepared;
}

bool meetRounded(Triangle triangle, Prepared prepared, Turned turned, Beam beam, out float range) {
  vec3 side = INSIDE == kInsidePlain ? plainSides(prepared.normals, beam.direction)
                                     : watertightSides(turned, beam.cosElevation, beam.sinElevation);
  precise float sum = side.x + side.y + side.z;
  if (RANGE == kRangePlane) {
    range = prepared.plane.w / dot(prepared.plane.xyz, beam.direction);
  } else {
    // A convex combination: the range never leaves the triangle's own depth interval.
    vec3 depth = cornerDepths(turned, beam.cosElevation, beam.sinElevation);
    precise float weighted = side.x * depth.x + side.y * depth.y + side.z * depth.z;
    range = weighted / sum;
  }
  // Never nearer than the triangle itself: so skipping what is farther than the best hit loses nothing. What lies
  // behind the sensor stays there.
  if (BOUNDS != kBoundsPaper && range > 0.0) range = max(range, triangle.rangeMin);
  bool facing = all(lessThanEqual(side, vec3(0.0)));
  bool averted = all(greaterThanEqual(side, vec3(0.0)));
  return (facing || (averted && !triangle.oneSided)) && sum != 0.0;
}

// True if the beam with this index meets the triangle within the range window. NaN is a miss.
bool meet(Triangle triangle, Prepared prepared, Turned turned, Beam beam, uint index, out float range) {
  bool inside = INSIDE == kInsideExact ? meetExact(triangle, prepared.exact, beam.direction, index, range)
                                       : meetRounded(triangle, prepared, turned, beam, range);
  return inside && range > 0.0 && range >= frame.rangeMin && range <= frame.rangeMax;
}
