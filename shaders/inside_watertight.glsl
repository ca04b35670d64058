// SPDX-License-Identifier: Apache-2.0
// The watertight test whether a beam is inside a triangle. Every triangle that shares a corner computes the same 2-D
// point across the beam from it, by the same operations. The sign of a difference of products is never wrong, although
// the difference may be zero, and zero counts as inside. So no beam slips between triangles (argument of Woop, Benthin
// and Wald, JCGT 2(1), 2013, in a rotated frame).

// The corners rotated so that a column of beams lies in the plane q = 0: p points along the column's azimuth, q to its
// left, z up.
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

// True if the beam may lie between a triangle's corners. Inside a triangle this always holds. Sides of a tiny triangle
// far beside the beam may all round to 0; its box keeps such beams away, but a box that motion has widened does not.
bool surrounds(vec3 q, vec3 w) {
  return min(min(q.x, q.y), q.z) <= 0.0 && max(max(q.x, q.y), q.z) >= 0.0 && min(min(w.x, w.y), w.z) <= 0.0 &&
         max(max(w.x, w.y), w.z) >= 0.0;
}

// The corners above and below the beam.
vec3 aboveBeam(Turned turned, float cosElevation, float sinElevation) {
  precise vec3 w = turned.z * cosElevation - turned.p * sinElevation;
  return w;
}

// Returns on which side of the edges opposite to a, b and c the beam lies. (depth, q, w) is forward, left, up. A
// triangle that is counter-clockwise as the sensor sees it has negative sides if the beam is inside.
vec3 watertightSides(Turned turned, float cosElevation, float sinElevation) {
  vec3 w = aboveBeam(turned, cosElevation, sinElevation);
  precise vec3 side = turned.q.yzx * w.zxy - w.yzx * turned.q.zxy;
  return side;
}

// Depth of each corner along the beam.
vec3 cornerDepths(Turned turned, float cosElevation, float sinElevation) {
  precise vec3 depth = turned.p * cosElevation + turned.z * sinElevation;
  return depth;
}

// The sides for a beam that deviates from this axis: every corner is sheared by the same operations until the beam
// lies on the axis.
vec3 strayedSides(Turned turned, float cosElevation, float sinElevation, vec2 stray) {
  vec3 depth = cornerDepths(turned, cosElevation, sinElevation);
  vec3 above = aboveBeam(turned, cosElevation, sinElevation);
  precise vec3 q = turned.q - stray.x * depth;
  precise vec3 w = above - stray.y * depth;
  precise vec3 side = q.yzx * w.zxy - w.yzx * q.zxy;
  return !APART || surrounds(q, w) ? side : vec3(1.0, -1.0, 0.0);  // two signs are no hit
}
