// SPDX-License-Identifier: Apache-2.0
// Bounds of a triangle for a sensor that moves while it rotates. A column fires at one time, so the triangle is
// bounded in the frame of the column that looks at it; the bounds are then widened by the possible motion until the
// other columns of its box fire. The columns at the seam are the start and the end of the scan, far apart in time, so
// a triangle at the seam gets one box on each side of it.

// True if all lasers see a triangle from one place and always in the same place.
bool atRest(bool moves) { return !moves && motion.sensor == 0 && motion.origins == 0.0; }

// True if neither motion nor rounding can change the side. In the frames of the columns each corner is up to `shift`
// elsewhere and rounded anew, by up to 6e-7 of its distance. Both edges change by that and by their share `bend`.
bool facesAwayThroughout(vec3 a, vec3 b, vec3 c, float shift, float bend) {
  vec3 u = b - a, v = c - a, normal = cross(u, v);
  float distance = max(max(length(a), length(b)), length(c)) + shift, lengthU = length(u), lengthV = length(v);
  float changeU = bend * lengthU + 1.2e-6 * distance, changeV = bend * lengthV + 1.2e-6 * distance;
  float turned = lengthU * changeV + lengthV * changeU + changeU * changeV;  // the most by which the normal changes
  return dot(normal, a) > distance * (2e-6 * lengthU * lengthV + 1.00001 * turned) + 1.00001 * length(normal) * shift;
}

// As culledEarly(); `bound` is that of the triangle's instance.
uint culledMoving(vec3 a, vec3 b, vec3 c, bool oneSided, vec2 bound) {
  float shift = motion.shift + bound.x;
  float rangeMin = nearestPoint(min(min(a, b), c), max(max(a, b), c)) - shift;
  uint fate = oneSided && facesAwayThroughout(a, b, c, shift, bound.y) ? kFace : kKeep;
  return rangeMin > frame.rangeMax ? kRange : fate;
}

// Widens the bounds of a triangle that were found in the frame of column `at`, a column near the triangle. The box's
// columns are unwrapped so that they lie around `at`. Returns false if the motion is so large that the triangle may be
// in any direction.
bool widenByMotion(uint at, float distance, float speed, inout Outline outline, inout Box box) {
  float turnColumns = float(frame.columns);
  if (box.columnMax - box.columnMin >= 0.5 * turnColumns) return false;
  float wrap = floor((float(at) - 0.5 * (box.columnMin + box.columnMax)) / turnColumns + 0.5) * turnColumns;
  box.columnMin += wrap;
  box.columnMax += wrap;
  // Radians per column, and columns per column, which grows towards the poles.
  float perColumn = seemingAngle(motion.shiftPerColumn + speed * motion.secondsPerColumn, motion.turnPerColumn, distance);
  float inverse = 1.0 / max(1.0 - max(-outline.keyMin, outline.keyMax), 1e-6);
  float ratio = perColumn * inverse * frame.columnsPerRadian * 1.05;
  if (!(ratio < 0.5)) return false;
  float reach = max(abs(box.columnMin - float(at)), abs(box.columnMax - float(at))) + 1.0;
  // A row with an azimuth offset looks in that direction with an earlier or later column.
  if (AZIMUTH_OFFSETS) reach += max(abs(frame.shiftMin), abs(frame.shiftMax));
  float columnsAway = reach / (1.0 - ratio);
  float origins = seemingAngle(motion.origins, 0.0, distance);
  float angle = perColumn * columnsAway + origins;
  if (angle > 0.25) return false;
  float more = angle * inverse * frame.columnsPerRadian * 1.05 + frame.columnSlack;  // the latter covers rounding
  box.columnMin -= more;
  box.columnMax += more;
  outline.keyMin -= angle;
  outline.keyMax += angle;
  return true;
}

// Returns the least and the largest place in the table of the sensor's poses among the listed beams in the columns of a
// box; the first is larger if there are none.
vec2 placesWithin(Box box) {
  uint blocks = (frame.columns - 1) / kPlaceColumns + 1;
  uint column = wrapColumn(firstColumn(box)), count = boxColumnCount(box), block = column / kPlaceColumns;
  vec2 places = vec2(1e9, -1.0);
  // One block more than the columns fill, because the last block of a turn may be smaller.
  for (uint k = 0; k < min((column % kPlaceColumns + count - 1) / kPlaceColumns + 2, blocks); ++k) {
    vec2 of = columnPlaces.at[block];
    places = vec2(min(places.x, of.x), max(places.y, of.y));
    block = block + 1 == blocks ? 0 : block + 1;
  }
  return places;
}

// Bounds a triangle for beams of a list. The bounds with all motion during the scan tell which columns may see it;
// their beams fire within a part of the scan, and the bounds that count are those with the motion during that part.
uint listedBox(mat3 corners, mat3 velocities, float speed, float distance, float rangeMin, out Box box) {
  vec3 low = min(min(corners[0], corners[1]), corners[2]), high = max(max(corners[0], corners[1]), corners[2]);
  vec3 a = corners[0], b = corners[1], c = corners[2];
  setSeeming(seemingAngle(motion.shift + speed * motion.seconds, motion.turn, nearestPoint(low, high)));
  bool some = false;
  // This is a loop because some compilers take gigabytes if the bounds are inlined several times.
  for (uint pass_ = 0; pass_ < 2; ++pass_) {
    Outline outline = outlineOf(a, b, c);
    some = coverColumns(a, b, c, outline, box);
    some = coverRows(outline, box) && some;
    if (!some || pass_ == 1) break;
    vec2 places = placesWithin(box);
    if (places.x > places.y) return kBetween;
    // The beams fire at most `apart` entries of the table before or after the middle; the rest covers rounding.
    float apart = 0.5 * (places.y - places.x) + 0.01;
    float angle = seemingAngle((motion.shiftPerColumn + speed * motion.secondsPerColumn) * apart + motion.origins,
                               motion.turnPerColumn * apart, distance) + 2e-6;
    if (!(angle < seeming)) break;
    setSeeming(angle);
    ColumnMotion at = columnMotionAt(0.5 * (places.x + places.y));
    a = inColumn(at, a, velocities[0]);
    b = inColumn(at, b, velocities[1]);
    c = inColumn(at, c, velocities[2]);
  }
  return !some ? kBetween : hidden(box, rangeMin) ? kHidden : kKeep;
}

// The frame in which a triangle is bounded: that of the column that sees it; that of the first or last column, for a
// triangle at the seam; or that of the middle of the scan, with bounds widened by all motion during the scan.
const uint kItsColumn = 0, kEndColumn = 1, kMiddle = 2;

// Sets `atSeam` if the triangle needs a box on the second side as well.
uint movingBox(mat3 corners, mat3 velocities, bool moves, uint side, out Box box, out float rangeMin, out bool atSeam) {
  atSeam = false;
  vec3 low = min(min(corners[0], corners[1]), corners[2]), high = max(max(corners[0], corners[1]), corners[2]);
  float speed = max(max(length(velocities[0]), length(velocities[1])), length(velocities[2])) * 1.00001;
  float distance = max(nearestPoint(low, high) - motion.shift - speed * motion.seconds, 0.0);
  rangeMin = distance;
  if (rangeMin > frame.rangeMax) return kRange;
  uint last = frame.columns - 1, at = 0, from = kMiddle;
  bool still = !moves && motion.sensor == 0;
  if (LISTED && !still) return listedBox(corners, velocities, speed, distance, rangeMin, box);
  if (!still) {
    vec3 middle = (corners[0] + corners[1] + corners[2]) * (1.0 / 3.0);
    float azimuth = (azimuthOf(middle.y, middle.x) + kPi) * frame.columnsPerRadian;
    at = min(uint(max(azimuth, 0.0)), last);
    // The column is computed a second time, with the triangle's position at the time of the first estimate.
    middle = inColumn(columnMotions.at[at], middle, (velocities[0] + velocities[1] + velocities[2]) * (1.0 / 3.0));
    azimuth = (azimuthOf(middle.y, middle.x) + kPi) * frame.columnsPerRadian;
    at = min(uint(max(azimuth, 0.0)), last);
    from = kItsColumn;
  }
  if (still) {
    seemFromLasers(low, high);
    return boundedBox(corners[0], corners[1], corners[2], box, rangeMin);
  }
  Outline outline;
  // This is a loop although each frame is tried at most once: some compilers take gigabytes if the bounds are inlined
  // three times.
  while (true) {
    vec3 a = corners[0], b = corners[1], c = corners[2];
    setSeeming(seemingAngle(motion.shift + speed * motion.seconds, motion.turn, nearestPoint(low, high)));
    if (from != kMiddle) {
      ColumnMotion column = columnMotions.at[at];
      a = inColumn(column, a, velocities[0]);
      b = inColumn(column, b, velocities[1]);
      c = inColumn(column, c, velocities[2]);
      setSeeming(0.0);
    }
    outline = outlineOf(a, b, c);
    bool any = coverColumns(a, b, c, outline, box);
    if (from == kMiddle) return !(coverRows(outline, box) && any) ? kBetween : hidden(box, rangeMin) ? kHidden : kKeep;
    bool bounded = widenByMotion(at, distance, speed, outline, box);
    if (from == kEndColumn && bounded) break;
    // The triangle's positions at the start and at the end of the scan may lie on different sides of the seam.
    float apart = seemingAngle(2.0 * motion.shift + speed * motion.seconds, 2.0 * motion.turn, distance);
    float margin = apart * frame.columnsPerRadian * 1.05 / max(1.0 - max(-outline.keyMin, outline.keyMax), 1e-6);
    bool shifted = AZIMUTH_OFFSETS && (box.columnMin - margin < frame.shiftMax ||
                                       box.columnMax + margin > float(last) + frame.shiftMin);
    atSeam = box.columnMin < margin || box.columnMax > float(last) - margin;
    // The two sides of the seam are distinguished by column numbers as floats, which are not exact above 2^24.
    bool anywhere = !bounded || shifted || frame.columns > 1u << 24;
    atSeam = atSeam && !anywhere;
    if (!anywhere && !atSeam) break;
    from = anywhere ? kMiddle : kEndColumn;
    at = side == 0 ? 0 : last;
  }
  if (from == kEndColumn) {
    float half_ = 0.5 * float(frame.columns);
    box.columnMin = max(box.columnMin, side == 0 ? 0.0 : ceil(half_));
    box.columnMax = min(box.columnMax, side == 0 ? ceil(half_) - 1.0 : float(last));
    if (box.columnMin > box.columnMax) return side == 0 ? kBetween : kNoTriangle;
  }
  bool any = coverRows(outline, box) && boxColumnCount(box) > 0;
  uint fate = !any ? kBetween : hidden(box, rangeMin) ? kHidden : kKeep;
  return side == 1 && fate != kKeep ? kNoTriangle : fate;
}
