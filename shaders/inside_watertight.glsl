// SPDX-License-Identifier: Apache-2.0
// Watertight: each corner becomes a 2-D point across the beam by the same operations for every triangle that shares
// it, the sign of a product difference is never wrong, only possibly zero, and zero counts as inside. So beams cannot
// slip between triangles (the argument of Woop, Benthin and Wald, JCGT 2(1), 2013, for a turned frame).

// The corners turned so that a column of beams lies in the plane q = 0: p along its horizon, q across it, z up.
struct Turned {
  vec3 p, q, z;  // one component per corner
};

Turned turn(Triangle triangle, vec2 azimuth) {
  vec3 x = vec3(triangle.a.x, triangle.b.x, triangle.c.x);
  vec3 y = vec3(triangle.a.y, triangle.b.y, triangle.c.y);
  precise vec3 p = x * azimuth.x + y * azimuth.y;
  precise vec3 q = y * azimuth.x - x * azimuth.y;
  return Turned(p, q, vec3(triangle.a.z, triangle.b.z, triangle.c.z));
}

// Sides of the edges opposite to a, b and c. (depth, q, w) is forward, left, up: a triangle that is counter-clockwise
// to the sensor's eye turns clockwise about the beam, so its sides are negative where the beam is inside.
vec3 watertightSides(Turned turned, float cosElevation, float sinElevation) {
  precise vec3 w = turned.z * cosElevation - turned.p * sinElevation;
  precise vec3 side = turned.q.yzx * w.zxy - w.yzx * turned.q.zxy;
  return side;
}

// Depth of each corner along the beam.
vec3 cornerDepths(Turned turned, float cosElevation, float sinElevation) {
  precise vec3 depth = turned.p * cosElevation + turned.z * sinElevation;
  return depth;
}
