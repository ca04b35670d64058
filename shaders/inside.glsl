// SPDX-License-Identifier: Apache-2.0
// Does a beam meet a triangle, and at what range? Both stages that ask, bin and resolve, ask here.

struct Triangle {
  vec3 a, b, c;  // sensor frame
  uint id;       // placed triangle
  bool oneSided;
  float rangeMin;  // no point of it is nearer
};

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

// cos and sin of a beam's azimuth. The same operations wherever it is asked, so every triangle sees the same beam.
vec2 beamAzimuth(vec2 column, uint row) {
  if (!AZIMUTH_OFFSETS) return column;
  precise float c = column.x * rows[row].cosOffset - column.y * rows[row].sinOffset;
  precise float s = column.y * rows[row].cosOffset + column.x * rows[row].sinOffset;
  return vec2(c, s);
}

// The corners turned so that the column lies in the plane q = 0: p along the column's horizon, q across, z up.
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

// Watertight: each corner becomes a 2-D point across the beam by the same operations for every triangle that shares
// it, the sign of a product difference is never wrong, only possibly zero, and zero counts as inside. So beams cannot
// slip between triangles (the argument of Woop, Benthin and Wald, JCGT 2(1), 2013, for a turned frame). The range is a
// convex combination of the corners' depths: it never leaves the triangle's own depth interval.
bool meetStandard(Turned turned, bool oneSided, float cosElevation, float sinElevation, out float range) {
  precise vec3 w = turned.z * cosElevation - turned.p * sinElevation;
  precise vec3 depth = turned.p * cosElevation + turned.z * sinElevation;
  precise vec3 edge = turned.q.yzx * w.zxy - w.yzx * turned.q.zxy;  // edge opposite to a, b, c
  precise float sum = edge.x + edge.y + edge.z;
  precise float weighted = edge.x * depth.x + edge.y * depth.y + edge.z * depth.z;
  range = weighted / sum;
  // (depth, q, w) is forward, left, up: counter-clockwise to the sensor's eye turns clockwise about the beam.
  bool facing = all(lessThanEqual(edge, vec3(0.0)));
  bool averted = all(greaterThanEqual(edge, vec3(0.0)));
  return (facing || (averted && !oneSided)) && sum != 0.0;
}

// Equations 2 to 4 of the paper, to the letter: edge normals a x b, and the supporting plane with a unit normal.
bool meetPaper(Triangle triangle, vec2 azimuth, float cosElevation, float sinElevation,
               out float range) {
  vec3 beam = vec3(cosElevation * azimuth.x, cosElevation * azimuth.y, sinElevation);
  vec3 edge = vec3(dot(cross(triangle.a, triangle.b), beam), dot(cross(triangle.b, triangle.c), beam),
                   dot(cross(triangle.c, triangle.a), beam));
  vec3 normal = normalize(cross(triangle.b - triangle.a, triangle.c - triangle.a));
  range = dot(normal, triangle.a) / dot(normal, beam);
  return all(greaterThanEqual(edge, vec3(0.0))) || all(lessThanEqual(edge, vec3(0.0)));
}

// True if the beam meets the triangle within the range window. Written so that NaN is a miss.
bool meet(Triangle triangle, Turned turned, vec2 azimuth, uint row, out float range) {
  float cosElevation = rows[row].cosElevation, sinElevation = rows[row].sinElevation;
  bool inside;
  if (ACCURACY == kAccuracyPaper) {
    inside = meetPaper(triangle, azimuth, cosElevation, sinElevation, range);
  } else {
    inside = meetStandard(turned, triangle.oneSided, cosElevation, sinElevation, range);
    // Never nearer than the triangle itself: so skipping what is farther than the best hit loses nothing.
    range = max(range, triangle.rangeMin);
  }
  return inside && range > 0.0 && range >= frame.rangeMin && range <= frame.rangeMax;
}
