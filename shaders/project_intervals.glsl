// SPDX-License-Identifier: Apache-2.0
// Intervals of the scan, in which a triangle is bounded that moves fast around the sensor. Intervals are runs of
// columns, and each fires during a part of the scan. An interval is narrowed to the columns of the triangle's box and
// divided until the triangle's motion meanwhile adds little to its bounds.

// Columns are compared as floats, which are exact up to here, and half columns, too.
const uint kMostExactColumns = 1 << 23;

// An interval: those of the columns begin..end - 1 that may see the triangle are from..to.
struct Interval {
  uint from, to, begin, end;
};

// Returns the interval of columns first..first + count - 1, or fewer if the scan ends before.
Interval intervalAt(uint first, uint count) {
  uint end = first + min(count, frame.columns - first);
  return Interval(first, end - 1, first, end);
}

Interval wholeScan() { return intervalAt(0, frame.columns); }
Interval noInterval() { return intervalAt(frame.columns, 0); }
bool isEmpty(Interval interval) { return interval.begin == interval.end; }
// Returns the interval after another, twice as long.
Interval intervalAfter(Interval before) { return intervalAt(before.end, 2 * (before.end - before.begin)); }

// Returns the least and the largest place in the table of the sensor's poses among the listed beams in a run of
// columns; the first is larger if there are none.
vec2 placesWithin(uint column, uint count) {
  uint blocks = (frame.columns - 1) / kPlaceColumns + 1, block = column / kPlaceColumns;
  vec2 places = vec2(1e9, -1.0);
  // One block more than the columns fill, because the last block of a turn may be smaller.
  for (uint k = 0; k < min((column % kPlaceColumns + count - 1) / kPlaceColumns + 2, blocks); ++k) {
    vec2 of = columnPlaces.at[block];
    places = vec2(min(places.x, of.x), max(places.y, of.y));
    block = block + 1 == blocks ? 0 : block + 1;
  }
  return places;
}

// Returns the least and the largest place in that table among all beams in columns from..to.
vec2 placesOf(uint from, uint to) {
  bool whole = to - from + 1 == frame.columns;
  if (LISTED) return whole ? vec2(0.0, 2.0 * motion.columnsToMiddle) : placesWithin(from, to - from + 1);
  vec2 places = vec2(float(from), float(to));
  if (!STAGGERED) return places;
  // A row with a shift looks at these columns earlier or later, and perhaps at the other end of the scan.
  places = vec2(places.x - frame.shiftMax, places.y - frame.shiftMin);
  bool wraps = places.x < 0.0 || places.y > float(frame.columns - 1);
  if (whole || wraps) return vec2(-float(frame.momentsBefore), float(frame.columns - 1 + frame.momentsAfter));
  return places;
}

// Returns how many places lie between the middle of two and each of them; the rest covers rounding.
float reachOf(vec2 places) {
  return 0.5 * (places.y - places.x) + (LISTED ? 0.01 : STAGGERED ? 1.0 : 0.5);
}

float areaOf(Outline outline, Box box) { return (box.columnMax - box.columnMin) * (outline.keyMax - outline.keyMin); }

// Cuts a box down to the columns of an interval. The box of a whole scan may wrap.
void cutColumns(Interval interval, inout Box box) {
  float turnColumns = float(frame.columns), beside = BESIDE_COLUMNS ? 0.5 : 0.0;
  // With this lower end the box begins at the first column of the interval, or one column before it.
  float lower = BESIDE_COLUMNS ? clamp(BESIDE - 0.5, 0.0, 0.5) : 0.0;
  if (interval.to - interval.from + 1 == frame.columns) return;
  float low = float(interval.from) + lower, high = float(interval.to) + beside;
  float wrap = floor((high + beside - box.columnMin) / turnColumns) * turnColumns;
  vec2 span = vec2(box.columnMin, box.columnMax) + wrap;  // it begins at most one turn before the interval ends
  bool any = span.y >= float(interval.from), twice = span.y - turnColumns >= float(interval.from);
  box.columnMin = twice ? low : clamp(span.x, low, high);
  box.columnMax = twice ? high : any ? clamp(span.y, box.columnMin, high) : box.columnMin - 2.0;
}

// True if the triangle has a much smaller box in a part of the interval. `reach` is that of the interval.
bool repaysDivision(Interval interval, Box box, float reach) {
  uint count = interval.to - interval.from + 1, columnCount = boxColumnCount(box);
  if (columnCount * boxRowCount(box) <= kFewIntervalBeams || count <= frame.columns / kMostIntervals || count == 1 ||
      frame.columns > kMostExactColumns)
    return false;
  if (!LISTED && !STAGGERED) return true;
  // Beams that lie side by side may fire at any time.
  uint middle = wrapColumn(firstColumn(box) + int(columnCount / 2));
  return reachOf(placesOf(middle, middle)) < 0.75 * reach;
}

// Narrows an interval to the columns of the triangle's box if these are at most half of it, or to its first half.
void divide(Box box, inout Interval interval) {
  int first = firstColumn(box), count = int(boxColumnCount(box));
  bool wraps = first < int(interval.from) || first + count > int(interval.to) + 1;
  if (!wraps && 2 * count <= int(interval.to - interval.from) + 1) {
    interval.from = uint(first);
    interval.to = uint(first + count - 1);
  } else {
    interval.to = interval.from + (interval.to - interval.from) / 2;
    interval.end = interval.to + 1;
  }
}
