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

#include "beam.h"
#include "inside_plain.glsl"
#include "inside_watertight.glsl"
#include "inside_exact.glsl"

Triangle triangleOf(TaggedCorner a, vec4 b, vec3 c) {
  return Triangle(a.corner, b.xyz, c, a.tag & 0x7fffffffu, (a.tag >> 31) != 0, b.w);
}

Triangle loadProjected(uint i) { return triangleOf(projectedA.at[i], projectedB.at[i], projectedC.at[i].corner); }

// What the tests need of a triangle whatever the beam; what a pipeline does not use, it does not compute.
struct Prepared {
  vec3 reach;  // footprint times the length of each edge's normal
  EdgeNormals normals;
  vec4 plane;
  ExactTriangle exact;
  vec2 window;  // of ranges that count
};

Prepared prepare(Triangle triangle) {
  Prepared prepared;
  prepared.window = vec2(frame.rangeMin, frame.rangeMax);
  if ((EFFECTS & kFootprintEffects) != 0)
    prepared.reach = (frame.footprint * 1.001 + 1e-6) * vec3(length(cross(triangle.b, triangle.c)),
                                                             length(cross(triangle.c, triangle.a)),
                                                             length(cross(triangle.a, triangle.b)));
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
  // Never nearer than the triangle itself: so skipping what is farther than the best hit loses nothing.
  bool ahead = range > 0.0;
  if (BOUNDS != kBoundsPaper) range = max(range, triangle.rangeMin);
  bool facing = all(lessThanEqual(side, vec3(0.0)));
  bool averted = all(greaterThanEqual(side, vec3(0.0)));
  return (facing || (averted && !triangle.oneSided)) && ahead && sum != 0.0;
}

// May some line within the footprint around the beam meet the triangle? Its direction is off by at most so much, so its
// side of an edge's plane by that times the length of the plane's normal. More is found near corners, nothing missed.
bool mayMeet(Triangle triangle, Prepared prepared, Turned turned, Beam beam) {
  vec3 side = watertightSides(turned, beam.cosElevation, beam.sinElevation);
  bool facing = all(lessThanEqual(side, prepared.reach));
  bool averted = all(greaterThanEqual(side, -prepared.reach));
  return facing || (averted && !triangle.oneSided);
}

// True if the beam with this index meets the triangle within the range window. NaN is a miss.
bool meet(Triangle triangle, Prepared prepared, Turned turned, Beam beam, uint index, out float range) {
  bool inside = INSIDE == kInsideExact ? meetExact(triangle, prepared.exact, beam.direction, index, range)
                                       : meetRounded(triangle, prepared, turned, beam, range);
  return inside && (INSIDE != kInsideExact || range > 0.0) && range >= prepared.window.x && range <= prepared.window.y;
}
