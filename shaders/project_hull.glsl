// SPDX-License-Identifier: Apache-2.0
// Bounds a triangle between two times by the hull of its corners at both, because each corner moves along a nearly straight
// line.

// Returns the most metres by which a corner is off the straight line between its places in the frames of two entries of
// columnMotions that lie `count` entries apart, if both are within the sensor's stamps. A series whose second differences
// are at most B is off its chord by at most n^2 / 8 B. A triangle that moves itself is also turned with the sensor, which
// bends its way by twice the product of both. `farthest` is the largest distance of a corner from the sensor in the middle
// of the scan.
float bendWithin(float count, float farthest, mat3 velocities) {
  float speed = fastestOf(velocities);
  float bent = motion.bendShift + motion.bendTurn * farthest + 2.0 * motion.turnPerColumn * speed * motion.secondsPerColumn;
  return 0.125 * count * count * bent;
}

// Returns another such bound for a triangle at rest, from the sums of the bends up to both entries. A path that bends by D
// from one step to the next is off its chord by at most n / 4 D, and the bends of a path add up. A path that bends at one
// time alone, as that of a pose that is corrected, is straight before and after. The last term covers the rounding of sums.
float bendBetween(float count, vec2 first, vec2 last, float farthest) {
  vec2 bends = max(last - first, vec2(0.0)) + 2.4e-7 * last;
  return 0.25 * count * (bends.x + bends.y * farthest);
}

// Returns the corners as the sensor sees them at an entry of its table of poses.
mat3 cornersAt(ColumnMotion at, mat3 corners, mat3 velocities) {
  return mat3(inColumn(at, corners[0], velocities[0]), inColumn(at, corners[1], velocities[1]),
              inColumn(at, corners[2], velocities[2]));
}

// Returns the tangents of the azimuths of three corners, counted from that of a point.
vec3 tangentsFrom(vec2 p, mat3 q) {
  return vec3(p.x * q[0].y - p.y * q[0].x, p.x * q[1].y - p.y * q[1].x, p.x * q[2].y - p.y * q[2].x) /
         vec3(dot(p, q[0].xy), dot(p, q[1].xy), dot(p, q[2].xy));
}

float smallestOf(vec3 v) { return min(min(v.x, v.y), v.z); }
float greatestOf(vec3 v) { return max(max(v.x, v.y), v.z); }
float spanOf(vec3 v) { return greatestOf(v) - smallestOf(v); }

// True if boxes between two times are those of hulls. Few triangles of a grid need such boxes, and on GPUs the hull would
// take registers of all: 12 waves instead of 14 on AMD's navi31.
#define HULLS (LISTED || BINNING == kBinningSlabs)

// Bounds a triangle between two places in the table of the sensor's poses by its corners at both. Meanwhile each corner
// moves along a nearly straight line, so the triangle stays near the hull of these six points. The hull is bounded as
// narrowOutline() and coverNarrowColumns() bound a triangle, and false is returned if it is not narrow. `area` becomes
// that of the triangle's own box at the first place.
bool narrowHull(vec2 places, mat3 corners, mat3 velocities, Course course, out Outline outline, inout Box box,
                out float rangeMin, out float area) {
  float before = float(frame.momentsBefore);
  bool narrow = places.x + before >= float(motion.bendFirst) && places.y + before < float(motion.bendEnd);
  if (narrow) {
    vec3 low = vec3(uintBitsToFloat(0x7f800000u)), high = -low;
    vec2 beside = vec2(0.0);
    vec2 bendsBefore, bends;
    float keyMin = 2.0, keyMax = -2.0, from = 0.0, to = 0.0, ownKeys, ownTangents;
    for (uint k = 0; k < 2; ++k) {
      ColumnMotion at = columnMotionOfPlace(k == 0 ? places.x : places.y);
      mat3 seen = cornersAt(at, corners, velocities);
      bends = at.bends.xy;
      if (k == 0) bendsBefore = bends;
      low = min(low, lowestOf(seen));
      high = max(high, highestOf(seen));
      if (k == 0) beside = seen[0].xy;
      vec3 keys = keysOf(seen[0], seen[1], seen[2]), tangents = tangentsFrom(beside, seen);
      if (k == 0) {
        ownKeys = spanOf(keys);
        ownTangents = spanOf(tangents);
      }
      keyMin = min(keyMin, smallestOf(keys));
      keyMax = max(keyMax, greatestOf(keys));
      from = min(from, smallestOf(tangents));
      to = max(to, greatestOf(tangents));
    }
    float nearest = nearestPoint(low, high);
    narrow = narrowOutline(keyMin, keyMax, high - low, nearest, outline);
    float slack = columnSlack(outline.keyMin, outline.keyMax);
    box.columnMin = columnAt(azimuthOf(beside.y, beside.x) + from) - slack;
    box.columnMax = box.columnMin + (to - from) * frame.columnsPerRadian + 2.0 * slack;
    area = (ownTangents * frame.columnsPerRadian + 2.0 * slack) * (ownKeys + 2.0 * keySlack());
    float farthest = length(max(abs(low), abs(high))) + motion.shift;
    float count = places.y - places.x, bend = bendWithin(count, farthest, velocities);
    if (fastestOf(velocities) == 0.0) bend = min(bend, bendBetween(count, bendsBefore, bends, farthest));
    bend += course.rounding;
    rangeMin = max(nearest - bend - motion.origins, course.nearest);
    seemInMotion(low, high, bend, 0.0);
    narrow = narrow && slack < 0.25 * float(frame.columns) && seeming < 0.25;
  }
  if (!narrow) setSeeming(0.0);
  return narrow;
}
