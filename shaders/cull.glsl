// SPDX-License-Identifier: Apache-2.0
// Can any beam see something of a box? Every answer errs towards yes: what is culled would not have been met.

layout(push_constant) uniform PassBlock { Pass pass; };

// The box of a group or cluster in the sensor's frame: centre and half extents of the turned box, a little widened.
void sensorBox(Instance instance, vec3 minimum, vec3 maximum, out vec3 low, out vec3 high) {
  vec3 pivot = pivotOf(instance);
  vec3 offset = instance.offset.xyz;
  vec3 middle = 0.5 * (minimum - pivot) + 0.5 * (maximum - pivot);
  vec3 extent = 0.5 * (maximum - minimum);
  vec3 centre = vec3(dot(instance.row0.xyz, middle), dot(instance.row1.xyz, middle), dot(instance.row2.xyz, middle)) +
                offset;
  vec3 size = vec3(dot(abs(instance.row0.xyz), extent), dot(abs(instance.row1.xyz), extent),
                   dot(abs(instance.row2.xyz), extent));
  // 1e-6 of each coordinate covers the roundings above and those of the corners' own transform.
  float length1 = abs(middle.x) + abs(middle.y) + abs(middle.z) + extent.x + extent.y + extent.z;
  float largest = max(max(abs(instance.row0.x) + abs(instance.row0.y) + abs(instance.row0.z),
                          abs(instance.row1.x) + abs(instance.row1.y) + abs(instance.row1.z)),
                      abs(instance.row2.x) + abs(instance.row2.y) + abs(instance.row2.z));
  vec3 slack = vec3(1e-6 * length1 * largest) + 1e-6 * abs(offset);
  low = centre - size - slack;
  high = centre + size + slack;
}

#ifdef MOTION
void widenByMotion(uint instance, inout vec3 low, inout vec3 high) {
  float bound = motion.instances != 0 ? instanceMotions[instance].bound.x : 0.0;
  low -= bound;
  high += bound;
}
#endif

float farthestPoint(vec3 low, vec3 high) { return length(max(abs(low), abs(high))) * 1.000001; }

// Rows first..end - 1 of which a beam may meet the box, and columns from..to, which wrap.
struct Window {
  uint first, end;
  float from, to;
};

// Of what in the box is no nearer than `beyond`.
void coverKeys(vec3 low, vec3 high, float beyond, out float keyMin, out float keyMax) {
  float near = length(max(max(low.xy, -high.xy), vec2(0.0))), far = length(max(abs(low.xy), abs(high.xy)));
  float height = max(abs(low.z), abs(high.z));
  near = max(near, 0.9999 * sqrt(max(beyond * beyond - height * height, 0.0)));
  keyMax = elevationKey(high.z > 0.0 ? near : far, high.z) + keySlack();
  keyMin = elevationKey(low.z < 0.0 ? near : far, low.z) - keySlack();
}

// The azimuths of a rectangle that does not hold the axis are those between two of its corners.
void coverAzimuths(vec3 low, vec3 high, float keyMin, float keyMax, inout Window window) {
  window.from = 0.0;
  window.to = float(frame.columns - 1);
  float slack = columnSlack(keyMin, keyMax);
  if ((all(lessThanEqual(low.xy, vec2(0.0))) && all(greaterThanEqual(high.xy, vec2(0.0)))) ||
      slack > 0.25 * float(frame.columns))
    return;
  vec2 centre = 0.5 * (low.xy + high.xy);
  float least = 0.0, most = 0.0;
  for (uint k = 0; k < 4; ++k) {
    vec2 corner = vec2((k & 1) == 0 ? low.x : high.x, (k & 2) == 0 ? low.y : high.y);
    float turned = azimuthOf(centre.x * corner.y - centre.y * corner.x, dot(centre, corner));
    least = min(least, turned);
    most = max(most, turned);
  }
  float middle = azimuthOf(centre.y, centre.x) + kPi;
  window.from = (middle + least) * frame.columnsPerRadian - slack;
  window.to = (middle + most) * frame.columnsPerRadian + slack;
}

// The largest range that any beam of the window has met so far is nearer than the box: nothing of it can be a hit.
bool occluded(Window window, float nearest) {
  uint nearestBits = floatBitsToUint(nearest);
  int from = int(ceil(window.from - frame.shiftMax)), to = int(floor(window.to - frame.shiftMin));
  uvec2 tile = uvec2(kFineColumns, kFineRows);
  uint base = 0;
  uint perRow = (frame.columns + tile.x - 1) / tile.x;
  for (uint level = 0; level < 2; ++level) {
    int turn = int(perRow);
    // Columns that wrap come to entries that wrap: the last entry of a turn may be narrower, so one more is looked at.
    int first = int(floor(float(from) / float(tile.x))), last = int(floor(float(to) / float(tile.x)));
    if (from < 0) --first;
    if (to >= int(frame.columns)) ++last;
    uint rowFirst = window.first / tile.y, rowLast = (window.end - 1) / tile.y;
    uint lookups = uint(min(last - first + 1, turn)) * (rowLast - rowFirst + 1);
    if (lookups <= kMaxLookups) {
      for (uint row = rowFirst; row <= rowLast; ++row)
        for (int k = first; k <= last && k < first + turn; ++k) {
          int wrapped = k - turn * int(floor(float(k) / float(turn)));
          if (farthest[base + row * perRow + uint(wrapped)] >= nearestBits) return false;
        }
      return true;
    }
    base += perRow * ((frame.rows + tile.y - 1) / tile.y);
    tile = uvec2(kCoarseColumns, kCoarseRows);
    perRow = (frame.columns + tile.x - 1) / tile.x;
  }
  return false;
}

// Comparisons with NaN are false: such a box is seen.
bool outOfSight(vec3 low, vec3 high) {
  float nearest = nearestPoint(low, high);
#ifdef MOTION
  seeming = seemingAngle(motion.shift, motion.turn, nearest);
  nearest = max(nearest - motion.shift, 0.0);
  if (seeming > 1.0) return (CULLING & kCullRange) != 0 && nearest > frame.rangeMax;
#endif
  if ((CULLING & kCullRange) != 0 && nearest > frame.rangeMax) return true;
  float keyMin, keyMax;
  coverKeys(low, high, 0.0, keyMin, keyMax);
  Window window;
  rowsBetween(keyMin, keyMax, window.first, window.end);
  if ((CULLING & kCullRows) != 0 && window.first >= window.end) return true;
  if ((CULLING & (kCullColumns | kCullOccluded)) == 0) return false;
  coverAzimuths(low, high, keyMin, keyMax, window);
  if ((CULLING & kCullColumns) != 0 && !AZIMUTH_OFFSETS && ceil(window.from) > floor(window.to)) return true;
  return (CULLING & kCullOccluded) != 0 && pass.occluders != 0 && window.first < window.end &&
         occluded(window, nearest);
}
