// SPDX-License-Identifier: Apache-2.0
// Bounds of a triangle for a sensor that moves while it rotates. A column fires at one time, so the triangle is
// bounded in the frame of the column that looks at it; the bounds are then widened by the possible motion until the
// other columns of its box fire. A triangle that moves fast around the sensor, because it is near, or that both the
// start and the end of the scan may see, is bounded for intervals of the scan, and has a box for each.

// Culls a triangle that moves relative to the sensor, as culledEarly() culls others. `bound` is InstanceMotion::bound of its
// instance.
uint culledMoving(vec3 a, vec3 b, vec3 c, bool oneSided, vec2 bound) {
  float shift = motion.shift + bound.x;
  float rangeMin = nearestPoint(min(min(a, b), c), max(max(a, b), c)) - shift;
  uint fate = oneSided && facesAwayThroughout(a, b, c, shift, bound.y) ? kFace : kKeep;
  return rangeMin > frame.rangeMax ? kRange : fate;
}

// Returns the speed of the fastest of three corners.
float fastestOf(mat3 velocities) {
  return max(max(length(velocities[0]), length(velocities[1])), length(velocities[2]));
}

// How a triangle moves relative to the sensor during the scan. Both may be fast and yet stay side by side.
struct Course {
  float perColumn;  // metres: most that a point of it moves from one column to the next
  float shift;      // metres: most that it is away from where the sensor sees it in the middle of the scan
  float rounding;   // metres: most by which the corners are wrong in the frames of the columns
  float nearest;    // metres: lower bound of its distance from any laser at any time
};

Course courseOf(mat3 corners, mat3 velocities) {
  float speed = fastestOf(velocities) * 1.00001;
  vec3 ofA = velocities[0] * motion.secondsPerColumn - motion.drift,
       ofB = velocities[1] * motion.secondsPerColumn - motion.drift,
       ofC = velocities[2] * motion.secondsPerColumn - motion.drift;
  float apart = motion.shiftPerColumn + speed * motion.secondsPerColumn;
  float beside = max(max(length(ofA), length(ofB)), length(ofC)) * 1.00001 + 1e-6 * apart;
  vec3 a = corners[0] + velocities[0] * motion.middle, b = corners[1] + velocities[1] * motion.middle,
       c = corners[2] + velocities[2] * motion.middle;
  vec3 low = min(min(a, b), c), high = max(max(a, b), c);
  float shiftApart = motion.shift + speed * motion.seconds;
  Course course;
  course.perColumn = min(apart, beside + motion.wanderPerColumn);
  course.rounding = 1e-6 * (length(max(abs(low), abs(high))) + shiftApart);
  course.shift = min(shiftApart, beside * motion.columnsToMiddle + motion.wander + motion.origins) + course.rounding;
  course.nearest = max(nearestPoint(low, high) - course.shift, 0.0);
  return course;
}

float seemingMotion = 0.0;  // the part of `seeming` that is due to motion

vec3 lowestOf(mat3 corners) { return min(min(corners[0], corners[1]), corners[2]); }
vec3 highestOf(mat3 corners) { return max(max(corners[0], corners[1]), corners[2]); }

// Sets the angles by which the content of the box low..high appears elsewhere if it moves by up to `shift` metres, is
// turned by up to `turn` radians, and is seen from any laser. The box is in the frame that the content moves from.
void seemInMotion(vec3 low, vec3 high, float shift, float turn) {
  float angle = seemingAngle(shift, turn, nearestPoint(low, high));
  seemingMotion = angle;
  setSeeming(0.0);
  if (ORIGINS) {
    float moved = shift + 1.05 * turn * length(max(abs(low), abs(high)));
    seemFromLasers(low - moved, high + moved);
  }
  seeming += angle;
  seemingAcross += angle;
  seemingUp += angle;
}

// Widens the bounds of a triangle by the angles by which it appears elsewhere. Up to half a radian, asin(x) is at most
// 1.05 x; beyond that, every column is covered.
void widenBySeeming(inout Outline outline, inout Box box) {
  outline.keyMin -= seemingUp;
  outline.keyMax += seemingUp;
  float perRadian = azimuthPerRadianSeen(outline.keyMin, outline.keyMax, seemingUp), across = seemingAcross * perRadian;
  if (spreadAcross() * perRadian > 0.5) {
    box.columnMin = 0.0;
    box.columnMax = float(frame.columns);
  } else {
    float more = across * frame.columnsPerRadian * 1.05 + frame.columnSlack;  // the latter covers rounding
    box.columnMin -= more;
    box.columnMax += more;
  }
}

// Returns the place of a point's azimuth among the columns, not less than that of the first.
float placeOf(vec3 p) {
  float place = columnAt(azimuthOf(p.y, p.x));
  return place < 0.0 ? place + float(frame.columns) : place;
}

// Returns the column that sees the middle of a triangle, or one near it.
uint seeingColumn(mat3 corners, mat3 velocities) {
  float last = float(frame.columns - 1);
  vec3 middle = (corners[0] + corners[1] + corners[2]) * (1.0 / 3.0);
  uint at = uint(clamp(placeOf(middle), 0.0, last));
  // The column is computed a second time, with the triangle's position at the time of the first estimate.
  middle = inColumn(columnMotionOfPlace(float(at)), middle, (velocities[0] + velocities[1] + velocities[2]) * (1.0 / 3.0));
  return uint(clamp(placeOf(middle), 0.0, last));
}

// The largest angle in radians by which a triangle with one box may appear elsewhere during the scan.
const float kMostSeeming = 0.25;

// Widens the bounds of a triangle that were found in the frame of column `at`, a column near the triangle. The box's
// columns are unwrapped so that they lie around `at`. Returns false if the triangle moves too fast for this, or if both
// the start and the end of the scan may see it.
bool widenByMotion(uint at, mat3 seen, Course course, inout Outline outline, inout Box box) {
  float turnColumns = float(frame.columns);
  if (box.columnMax - box.columnMin >= 0.5 * turnColumns) return false;
  float wrap = floor((float(at) - 0.5 * (box.columnMin + box.columnMax)) / turnColumns + 0.5) * turnColumns;
  box.columnMin += wrap;
  box.columnMax += wrap;
  // Radians per column, and columns per column, which grows towards the poles.
  float perColumn = seemingAngle(course.perColumn, motion.turnPerColumn, course.nearest);
  float perRadian = azimuthPerRadianSeen(outline.keyMin, outline.keyMax, kMostSeeming);
  float ratio = perColumn * perRadian * frame.columnsPerRadian * 1.05;
  if (!(ratio < 0.5)) return false;
  float reach = max(abs(box.columnMin - float(at)), abs(box.columnMax - float(at))) + 1.0;
  if (ORIGINS) reach += seemingAngle(motion.left, 0.0, course.nearest) * perRadian * frame.columnsPerRadian;
  // Rows with shifts look in that direction earlier or later.
  if (STAGGERED) reach += max(abs(frame.shiftMin), abs(frame.shiftMax));
  float columnsAway = reach / (1.0 - ratio);
  seemInMotion(lowestOf(seen), highestOf(seen), course.perColumn * columnsAway + course.rounding,
               motion.turnPerColumn * columnsAway);
  if (seeming > kMostSeeming) return false;
  widenBySeeming(outline, box);
  // The triangle's positions at the start and at the end of the scan may lie on different sides of the seam.
  float apart = seemingAngle(2.0 * course.shift, 2.0 * motion.turn, course.nearest);
  float margin = 1.05 * apart * azimuthPerRadianSeen(outline.keyMin, outline.keyMax, apart) *
                 frame.columnsPerRadian;
  vec2 shifts = STAGGERED ? vec2(frame.shiftMin, frame.shiftMax) : vec2(0.0);
  return box.columnMin >= margin + shifts.y + BESIDE && box.columnMax <= turnColumns - 1.0 - margin + shifts.x;
}

#include "project_intervals.glsl"

uint fateIn(Outline outline, float rangeMin, inout Box box) {
  bool any = coverRows(outline, box) && boxColumnCount(box) > 0;
  return !any ? kBetween : hidden(box, rangeMin) ? kHidden : kKeep;
}

#include "project_hull.glsl"

// Bounds a triangle that each laser sees in one place throughout the scan; the box keeps its times.
uint restingBox(mat3 corners, inout Box box, out float rangeMin) {
  vec3 low = lowestOf(corners), high = highestOf(corners);
  rangeMin = max(nearestPoint(low, high) - motion.shift, 0.0);
  if (rangeMin > frame.rangeMax) return kRange;
  seemFromLasers(low, high);
  uvec2 times = box.times;
  uint fate = boundedBox(corners[0], corners[1], corners[2], box, rangeMin);
  box.times = times;
  return fate;
}

// Bounds a triangle for the columns from interval.from on that a first box can hold, and sets the interval of the next
// box; it is empty if there is none. If the box is that of one frame, sets the corners in that frame, and by how much
// the triangle seems elsewhere in others.
uint movingBox(mat3 corners, bool moves, inout Interval interval, inout Projected projected, out Box box,
               out float rangeMin) {
  mat3 velocities = projected.velocities;
  Interval part = interval;
  interval = noInterval();
  box.times = uvec2(part.from, part.to);
  projected.seen = corners;
  projected.inOneFrame = true;
  if (!MOTION || atRest(moves)) return restingBox(corners, box, rangeMin);
  Course course = courseOf(corners, velocities);
  rangeMin = course.nearest;
  if (rangeMin > frame.rangeMax) return kRange;
  setSeeming(0.0);
  projected.inOneFrame = false;
  bool inOne = !LISTED && part.from == 0 && frame.columns <= kMostExactColumns;  // one box is tried first
  // Both cases share one loop because some compilers take gigabytes if the bounds are inlined several times. The loop has
  // one exit because SwiftShader, where lanes return from within it, loads entries of columnMotions that no lane asks for.
  uint fate = kNoTriangle;
  for (bool more = true; more;) {
    vec2 places = inOne ? vec2(float(seeingColumn(corners, velocities))) : placesIn(part);
    bool anyBeams = places.x <= places.y;
    Outline outline;
    float area;
    if (!HULLS || inOne || !anyBeams || !narrowHull(places, corners, velocities, course, outline, box, rangeMin, area)) {
      mat3 seen = cornersAt(columnMotionOfPlace(anyBeams ? 0.5 * (places.x + places.y) : 0.0), corners, velocities);
      outline = outlineOf(seen[0], seen[1], seen[2]);
      coverColumns(seen[0], seen[1], seen[2], outline, box);
      if (inOne) {
        projected.seen = seen;
      } else {
        area = areaOf(outline, box);
        float reach = reachOf(places), shift = min(course.perColumn * reach + course.rounding, 2.0 * course.shift);
        vec3 low = lowestOf(seen), high = highestOf(seen);
        rangeMin = max(nearestPoint(low, high) - shift - motion.origins, course.nearest);
        seemInMotion(low, high, shift, min(motion.turnPerColumn * reach, 2.0 * motion.turn));
      }
    }
    if (inOne) {
      inOne = false;
      projected.inOneFrame = widenByMotion(uint(places.x), projected.seen, course, outline, box);
      if (projected.inOneFrame) {
        fate = fateIn(outline, rangeMin, box);
        more = false;
      } else {
        setSeeming(0.0);
      }
    } else {
      widenBySeeming(outline, box);
      setSeeming(0.0);
      bool muchWider = areaOf(outline, box) > 2.0 * area;
      cutColumns(part, box);
      bool any = coverRows(outline, box) && boxColumnCount(box) > 0 && anyBeams;
      if (LISTED && any) any = slicesIn(part.from, part.to, box) != 0;
      if (any && !(muchWider && repaysDivision(part, box))) {
        interval = intervalAfter(part);
        box.times = uvec2(part.from, part.to);
        fate = hidden(box, rangeMin) ? kHidden : kKeep;
        more = false;
      } else if (any) {
        divide(box, part);
      } else {
        part = intervalAfter(part);
        fate = kBetween;
        more = !isEmpty(part);
      }
    }
  }
  return fate;
}
