// SPDX-License-Identifier: Apache-2.0
// Tests whether any beam can hit something in a box. All tests are conservative: a culled box cannot contain a hit.

// The box of a group or cluster in the sensor's frame: the axis-aligned bounds of the rotated box, slightly widened.
void sensorBox(Instance instance, vec3 minimum, vec3 maximum, out vec3 low, out vec3 high) {
  vec3 pivot = pivotOf(instance);
  vec3 offset = instance.offset;
  vec3 middle = 0.5 * (minimum - pivot) + 0.5 * (maximum - pivot);
  vec3 extent = 0.5 * (maximum - minimum);
  vec3 centre = vec3(dot(instance.row0.xyz, middle), dot(instance.row1.xyz, middle), dot(instance.row2.xyz, middle)) +
                offset;
  vec3 size = vec3(dot(abs(instance.row0.xyz), extent), dot(abs(instance.row1.xyz), extent),
                   dot(abs(instance.row2.xyz), extent));
  // 1e-6 of each coordinate covers the rounding errors above and those of the corners' own transform.
  float sumOfExtents = abs(middle.x) + abs(middle.y) + abs(middle.z) + extent.x + extent.y + extent.z;
  float largest = max(max(abs(instance.row0.x) + abs(instance.row0.y) + abs(instance.row0.z),
                          abs(instance.row1.x) + abs(instance.row1.y) + abs(instance.row1.z)),
                      abs(instance.row2.x) + abs(instance.row2.y) + abs(instance.row2.z));
  vec3 slack = vec3(1e-6 * sumOfExtents * largest) + 1e-6 * abs(offset);
  low = centre - size - slack;
  high = centre + size + slack;
}

// Returns how an instance moves during the scan: InstanceMotion::bound, or 0 if it is at rest.
vec2 boundOf(uint instance) {
  return MOTION && motion.instances != 0 ? instanceMotions.at[instance].bound.xy : vec2(0.0);
}

// Returns the largest distance in metres that a point of a box in the mesh frame moves with an instance that is not
// deformed meanwhile. The velocity is affine, so it is largest at a corner. 1e-6 of each term covers rounding.
float farthestMove(InstanceMotion moving, vec3 low, vec3 high) {
  vec3 middle = 0.5 * (low + high), extent = 0.5 * (high - low);
  vec3 size = abs(middle) * 1e-6 + abs(extent) * 1.00001;
  vec3 most = abs(velocityOf(moving, middle)) +
              vec3(dot(abs(moving.row0.xyz), size), dot(abs(moving.row1.xyz), size), dot(abs(moving.row2.xyz), size)) +
              1e-6 * abs(vec3(moving.row0.w, moving.row1.w, moving.row2.w));
  return length(most) * motion.seconds * 1.00001;
}

// Widens a box in the sensor's frame by how far its content moves; `meshLow` and `meshHigh` are the box in the mesh frame.
void widenByMotion(uint instance, vec3 meshLow, vec3 meshHigh, inout vec3 low, inout vec3 high) {
  float reach = boundOf(instance).x;
  // The bound is that of the whole instance, and of one whose vertices only the device knows it is no bound at all.
  if (reach > 0.0 && instanceMotions.at[instance].bound.z == 0.0)
    reach = min(reach, farthestMove(instanceMotions.at[instance], meshLow, meshHigh));
  low -= reach;
  high += reach;
}

float farthestPoint(vec3 low, vec3 high) { return length(max(abs(low), abs(high))) * 1.000001; }

// The beams that may hit the box: rows first..end - 1, and columns from..to, which may wrap.
struct Window {
  uint first, end;
  float from, to;
};

// Computes the elevation keys of the part of the box that is at least `beyond` metres away.
void coverKeys(vec3 low, vec3 high, float beyond, out float keyMin, out float keyMax) {
  float near = length(max(max(low.xy, -high.xy), vec2(0.0))), far = length(max(abs(low.xy), abs(high.xy)));
  float height = max(abs(low.z), abs(high.z));
  near = max(near, 0.9999 * sqrt(max(beyond * beyond - height * height, 0.0)));
  keyMax = elevationKey(high.z > 0.0 ? near : far, high.z) + keySlack();
  keyMin = elevationKey(low.z < 0.0 ? near : far, low.z) - keySlack();
}

// A rectangle that does not contain the vertical axis spans the azimuths between two of its corners.
void coverAzimuths(vec3 low, vec3 high, float keyMin, float keyMax, inout Window window) {
  window.from = 0.0;
  window.to = float(frame.columns - 1);
  float slack = columnSlack(keyMin, keyMax);
  if ((all(lessThanEqual(low.xy, vec2(0.0))) && all(greaterThanEqual(high.xy, vec2(0.0)))) ||
      slack > 0.25 * float(frame.columns))
    return;
  // The corners farthest to the right and to the left depend on the sides of the rectangle that face the axis.
  bool ahead = low.x > 0.0, behind = high.x < 0.0, left = low.y > 0.0, right = high.y < 0.0;
  vec2 first = vec2((ahead ? low.y >= 0.0 : behind ? high.y > 0.0 : left) ? high.x : low.x,
                    ahead || (!behind && left) ? low.y : high.y);
  vec2 last = vec2((ahead ? high.y > 0.0 : behind ? low.y >= 0.0 : left) ? low.x : high.x,
                   ahead || (!behind && right) ? high.y : low.y);
  float start = azimuthOf(first.y, first.x), end = azimuthOf(last.y, last.x);
  if (end < start - 0.5 * kPi) end += 2.0 * kPi;  // it lies behind the sensor; rounding alone turns it back by less
  window.from = columnAt(start) - slack;
  window.to = columnAt(end) + slack;
}

// Returns the window of the beams that may hit a box.
Window windowOf(vec3 low, vec3 high) {
  float keyMin, keyMax;
  coverKeys(low, high, 0.0, keyMin, keyMax);
  Window window;
  rowsBetween(keyMin, keyMax, window.first, window.end);
  coverAzimuths(low, high, keyMin, keyMax, window);
  return window;
}

// Returns the first column of a window and the column after its last one. If the window continues behind the sensor's
// last column with column 0, the second number is larger than the number of columns. The first column exists even if
// the bounds of a box are NaN, which a device may convert to any number.
uvec2 columnsOf(Window window) {
  int unwrapped = whole(ceil(window.from - BESIDE));
  uint from = min(wrapColumn(unwrapped), frame.columns - 1);
  return uvec2(from, uint(whole(floor(window.to)) + int(from) - unwrapped + 1));
}

// True if a window has at most `most` beams, all in places of a grid.
bool hasFewBeams(Window window, uint most) {
  uvec2 span = columnsOf(window);
  uint columnCount = span.y - span.x;
  return !LISTED && columnCount <= most && columnCount * (window.end - window.first) <= most;
}

// True if every beam of a window has a hit nearer than `nearest`. Each lane may ask about another window. There is one
// loop instead of two nested ones, because a subgroup then takes only as long as its lane with the most beams.
bool behindHits(Window window, float nearest) {
  uvec2 span = columnsOf(window);
  uint nearestBits = floatBitsToUint(nearest), row = window.first, column = span.x;
  bool behind = true;
  while (behind && row < window.end && column < span.y) {
    behind = words.at[firstWord() + row * frame.columns +
                      (column < frame.columns ? column : column - frame.columns)].y < nearestBits;
    bool rowEnds = ++column == span.y;
    column = rowEnds ? span.x : column;
    row += rowEnds ? 1 : 0;
  }
  return behind;
}

// True if the box is farther than the largest range that any beam of the window has found so far; then nothing in it
// can be a hit.
bool occluded(Window window, float nearest) {
  if (hasFewBeams(window, kMaxLookups)) return behindHits(window, nearest);
  uint nearestBits = floatBitsToUint(nearest);
  uvec2 span = columnsOf(window), shift = uvec2(findMSB(kFineColumns), findMSB(kFineRows));
  uint from = span.x, to = span.y - 1, base = firstFarthest();
  for (uint level = 0; level < 2; ++level) {
    uint perRow = (frame.columns - 1 >> shift.x) + 1;
    // Columns wrap, and so do table entries. The last entry of a row may cover fewer columns, so one more entry is
    // read.
    uint first = from >> shift.x, last = (to >> shift.x) + uint(to >= frame.columns);
    uint rowFirst = window.first >> shift.y, rowLast = window.end - 1 >> shift.y;
    uint count = min(last - first + 1, perRow), lookups = count * (rowLast - rowFirst + 1);
    if (lookups <= kMaxLookups) {
      for (uint row = rowFirst; row <= rowLast; ++row)
        for (uint k = first; k < first + count; ++k)
          if (farthest.at[base + row * perRow + (k < perRow ? k : k - perRow)] >= nearestBits) return false;
      return true;
    }
    base += perRow * ((frame.rows - 1 >> shift.y) + 1);
    shift = uvec2(findMSB(kCoarseColumns), findMSB(kCoarseRows));
  }
  return false;
}

// The beams of a window fire during a part of the scan, in which the sensor moves less than during the whole scan. If
// that part is short, moves the box to the frame of the sensor in the middle of it, and sets by how many metres and
// radians the sensor moves meanwhile at most.
bool narrowToTime(Window window, inout vec3 low, inout vec3 high, out float shift, out float turn) {
  shift = turn = 0.0;
  uvec2 span = columnsOf(window);
  float farthest_ = farthestPoint(low, high);
  if (!(farthest_ < 1e30) || window.first >= window.end || span.x >= span.y || span.x >= frame.columns) return false;
  uvec2 interval = uvec2(span.x, span.y - 1);
  if (LISTED) {
    uint slices = slicesWithin(window.first, window.end, span.x, span.y - span.x);
    if (slices == 0) return false;
    interval = runOfSlices(slices);
  } else if (span.y > frame.columns) {
    return false;  // the box is seen at the start and at the end of the scan
  }
  vec2 places = placesOf(interval.x, interval.y);
  float reach = reachOf(places);
  if (!(reach < 0.5 * motion.columnsToMiddle)) return false;
  ColumnMotion at = columnMotionOfPlace(0.5 * (places.x + places.y));
  vec3 extent = 0.5 * (high - low), centre = inColumn(at, 0.5 * low + 0.5 * high);
  float slack = 1e-6 * (farthest_ + motion.shift);
  vec3 size = vec3(dot(abs(at.row0.xyz), extent), dot(abs(at.row1.xyz), extent), dot(abs(at.row2.xyz), extent)) + slack;
  low = centre - size;
  high = centre + size;
  shift = min(motion.shiftPerColumn * reach + motion.origins, 2.0 * motion.shift) + slack;
  turn = min(motion.turnPerColumn * reach, 2.0 * motion.turn);
  return true;
}

// Sets by how much the content of a box appears to move during the scan, and returns a lower bound of its distance from
// any laser.
float seemFromSensor(vec3 low, vec3 high) {
  float nearest = nearestPoint(low, high);
  if (!APART) return nearest;
  if (MOTION && motion.sensor != 0)
    setSeeming(seemingAngle(motion.shift, motion.turn, nearest));
  else
    seemFromLasers(low, high);
  return max(nearest - motion.shift, 0.0);
}

// Returns the window of the beams that may hit a box after seemFromSensor(). If these fire within a short time, `nearest`
// becomes a lower bound of the distance during that time.
Window windowInTime(vec3 low, vec3 high, inout float nearest) {
  Window window = windowOf(low, high);
  float shift, turn, whole = seeming;
  if (!MOTION || motion.sensor == 0 || !narrowToTime(window, low, high, shift, turn)) return window;
  nearest = nearestPoint(low, high);
  setSeeming(seemingAngle(shift, turn, nearest));
  nearest = max(nearest - shift, 0.0);
  window = windowOf(low, high);
  setSeeming(whole);
  return window;
}

// Comparisons with NaN are false, so a box with NaN bounds is not culled.
bool outOfSight(vec3 low, vec3 high) {
  float nearest = seemFromSensor(low, high);
  if ((CULLING & kCullRange) != 0 && nearest > frame.rangeMax) return true;
  if (APART && seeming > 1.0) return false;
  Window window = windowInTime(low, high, nearest);
  if ((CULLING & kCullRows) != 0 && window.first >= window.end) return true;
  if ((CULLING & kCullColumns) != 0 && betweenColumns(window.from, window.to)) return true;
  return (CULLING & kCullOccluded) != 0 && pass.occluders != 0 && window.first < window.end &&
         occluded(window, nearest);
}
