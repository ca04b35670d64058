// SPDX-License-Identifier: Apache-2.0
// Tests whether a beam hits a triangle, and computes the range. Stages bin and resolve both use this test.

struct Triangle {
  vec3 a, b, c;    // sensor frame
  uint id;         // placed triangle
  bool oneSided;   // only the front face (counter-clockwise as the sensor sees it) reflects
  float rangeMin;  // lower bound of the range to any point of the triangle
  bool moves;      // during the scan
};

// A range beyond which a hit cannot change the result of the beam; each stage defines its own. Called where more than a
// comparison is saved: by `exact`, whose ranges are expensive, and before a surface is searched for holes.
float farthestOf(uint index);

#include "common/beam.h"
#include "beams.glsl"
#include "strays.glsl"
#include "inside_plain.glsl"
#include "inside_watertight.glsl"
#include "inside_exact.glsl"
#include "holes.glsl"

Triangle triangleOf(TaggedCorner a, vec4 b, vec3 c) {
  return Triangle(a.corner, b.xyz, c, a.tag & 0x7fffffffu, (a.tag >> 31) != 0, abs(b.w),
                  (floatBitsToUint(b.w) >> 31) != 0);
}

float rangeMinOf(uint projected) { return abs(projectedB.at[projected].w); }

Triangle loadProjected(uint i) { return triangleOf(loadedA(i), loadedB(i), loadedC(i).corner); }

// Values of a triangle that do not depend on the beam. A pipeline computes only those that it uses.
struct Prepared {
  vec3 reach;  // half angle of the footprint times the length of each edge's normal
  float longest, farthest;  // with a footprint: the length of the longest of these normals, of the farthest corner
  float area;  // twice the triangle's, with a footprint
  EdgeNormals normals;
  vec4 plane;
  ExactTriangle exact;
  vec2 window;  // least and largest range that counts
};

Prepared prepare(Triangle triangle) {
  Prepared prepared;
  prepared.window = vec2(frame.rangeMin, frame.rangeMax);
  if ((EFFECTS & kFootprint) != 0) {
    vec3 a = triangle.a, b = triangle.b, c = triangle.c;
    vec3 lengths = vec3(length(cross(b, c)), length(cross(c, a)), length(cross(a, b)));
    prepared.reach = (frame.footprint * 1.001 + 1e-6) * lengths;
    prepared.longest = max(max(lengths.x, lengths.y), lengths.z);
    prepared.farthest = 1.00001 * sqrt(max(max(dot(a, a), dot(b, b)), dot(c, c)));
    prepared.area = length(cross(b - a, c - a));
  }
  if (INSIDE == kInsidePlain) prepared.normals = edgeNormals(triangle);
  if (RANGE == kRangePlane) prepared.plane = supportingPlane(triangle);
  if (INSIDE == kInsideExact) prepared.exact = exactTriangle(triangle);
  return prepared;
}

// `side` becomes the weights of the corners at the hit, not yet divided by their sum.
bool meetRounded(Triangle triangle, Prepared prepared, Turned turned, Beam beam, uint index, out vec3 side,
                 out float range) {
  vec2 stray = vec2(0.0);
  if ((EFFECTS & kStrays) != 0) {
    stray = strays.at[beamEntry(index)];
    side = strayedSides(turned, beam.cosElevation, beam.sinElevation, stray);
  } else {
    side = INSIDE == kInsidePlain ? plainSides(prepared.normals, beam.direction)
                                  : watertightSides(turned, beam.cosElevation, beam.sinElevation);
    if (APART && INSIDE == kInsideWatertight &&
        !surrounds(turned.q, aboveBeam(turned, beam.cosElevation, beam.sinElevation)))
      return false;
  }
  precise float sum = side.x + side.y + side.z;
  if (RANGE == kRangePlane) {
    range = prepared.plane.w / dot(prepared.plane.xyz, beam.direction);
  } else {
    // The range is a convex combination of the corners' depths, so it never leaves the triangle's own depth interval.
    vec3 depth = cornerDepths(turned, beam.cosElevation, beam.sinElevation);
    precise float weighted = side.x * depth.x + side.y * depth.y + side.z * depth.z;
    range = weighted / sum;
    if ((EFFECTS & kStrays) != 0) {
      precise float along = range * lengthOf(stray.x, stray.y);
      range = along;
    }
  }
  // The range is at least rangeMin, so skipping triangles whose rangeMin is beyond the best hit loses nothing.
  bool ahead = range > 0.0;
  if (BOUNDS != kBoundsPaper) range = max(range, triangle.rangeMin);
  bool facing = all(lessThanEqual(side, vec3(0.0)));
  bool averted = all(greaterThanEqual(side, vec3(0.0)));
  return (facing || (averted && !triangle.oneSided)) && ahead && sum != 0.0;
}

// True if a line within the footprint around the beam may hit the triangle. The line's direction differs from the
// beam's by at most the footprint angle, so its side of an edge's plane differs by at most that angle times the length
// of the normal. Near corners the test accepts too much, but it misses nothing.
bool mayMeet(Triangle triangle, Prepared prepared, vec3 side) {
  bool facing = all(lessThanEqual(side, prepared.reach));
  bool averted = all(greaterThanEqual(side, -prepared.reach));
  return facing || (averted && !triangle.oneSided);
}

// The least and the largest range at which a hit of the beam with this index counts.
vec2 windowOf(Prepared prepared, uint index) {
  vec2 window = prepared.window;
  if (NUMBERED && frame.hasBeamRanges != 0) window = beamRanges.at[tableEntry(index)];
  if (NUMBERED && frame.hidesNear != 0) window.x = 0.0;
  return window;
}

// Whether a hit of the projected triangle `slot` is in a hole. The stages that find triangles again look their materials
// and textures up.
#ifndef HOLES_ARE_AT_HAND
bool inHole(uint slot, vec3 weights) {
  Optics4 surface = optics.at[projectedMaterials.at[slot]];
  return surface.passage.y > 0.0 && isHole(surface, textureCornersOf(slot), weights);
}
#endif

// True if the beam with this index hits the projected triangle `slot` within the range window, and not in a hole. A
// range of NaN is a miss.
bool meet(Triangle triangle, Prepared prepared, Turned turned, Beam beam, uint index, uint slot, out float range) {
  vec3 side = vec3(0.0);
  bool inside = INSIDE == kInsideExact ? meetExact(triangle, prepared.exact, beam.direction, index, range)
                                       : meetRounded(triangle, prepared, turned, beam, index, side, range);
  vec2 window = windowOf(prepared, index);
  bool met = inside && (INSIDE != kInsideExact || range > 0.0) && range >= window.x && range <= window.y;
  // Whether a hit that cannot change the result of the beam is in a hole does not matter.
  if ((EFFECTS & kCutOuts) != 0 && met && range <= farthestOf(index))
    met = !inHole(slot, side);
  return met;
}
