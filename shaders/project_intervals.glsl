// SPDX-License-Identifier: Apache-2.0
// Intervals of the scan, in which a triangle is bounded that moves fast around the sensor. The intervals of a grid whose
// columns fire one after the other are runs of columns. Where rows have shifts, they are runs of moments, which are
// entries of columnMotions; for a list they are runs of slices of time. An interval is narrowed to the columns, moments
// or slices in which beams of the triangle's box fire, and divided until the triangle's motion meanwhile adds little to
// its bounds.

// Columns are compared as floats, which are exact up to here, and half columns, too.
const uint kMostExactColumns = 1 << 23;

// An interval: those of the columns, moments or slices begin..end - 1 that may see the triangle are from..to.
struct Interval {
  uint from, to, begin, end;
};

// Returns the interval that begins with column, moment or slice `first` and has `count` of them, or fewer if the scan
// ends before.
Interval intervalAt(uint first, uint count) {
  uint end = first + min(count, intervalsEnd() - first);
  return Interval(first, end - 1, first, end);
}

Interval wholeScan() { return intervalAt(0, intervalsEnd()); }
Interval noInterval() { return intervalAt(intervalsEnd(), 0); }
bool isEmpty(Interval interval) { return interval.begin == interval.end; }
// Returns the interval after another, twice as long.
Interval intervalAfter(Interval before) { return intervalAt(before.end, 2 * (before.end - before.begin)); }

float areaOf(Outline outline, Box box) { return (box.columnMax - box.columnMin) * (outline.keyMax - outline.keyMin); }

// Returns the least and the largest place in the table of the sensor's poses at which the beams of an interval fire.
vec2 placesIn(Interval interval) {
  if (LISTED || !STAGGERED) return placesOf(interval.from, interval.to);
  return vec2(float(interval.from), float(interval.to + 1)) - float(frame.momentsBefore);
}

// Cuts a box down to the columns of an interval. The box of a whole scan may wrap.
void cutColumns(Interval interval, inout Box box) {
  float turnColumns = float(frame.columns), beside = BESIDE_COLUMNS ? 0.5 : 0.0;
  // With this lower end the box begins at the first column of the interval, or one column before it.
  float lower = BESIDE_COLUMNS ? clamp(BESIDE - 0.5, 0.0, 0.5) : 0.0;
  vec2 columns_ = vec2(float(interval.from), float(interval.to));
  if (STAGGERED) columns_ += vec2(frame.shiftMin, frame.shiftMax + 1.0) - float(frame.momentsBefore);
  float low = columns_.x + lower, high = columns_.y + beside;
  if (LISTED || high - low >= turnColumns - 1.0) return;
  float wrap = floor((high + beside - box.columnMin) / turnColumns) * turnColumns;
  vec2 span = vec2(box.columnMin, box.columnMax) + wrap;  // it begins at most one turn before the interval ends
  bool any = span.y >= columns_.x, twice = span.y - turnColumns >= columns_.x;
  box.columnMin = twice ? low : clamp(span.x, low, high);
  box.columnMax = twice ? high : any ? clamp(span.y, box.columnMin, high) : box.columnMin - 2.0;
}

// Returns one bit for each slice from..to in which beams of a box of cells may fire.
uint slicesIn(uint from, uint to, Box box) {
  uint all = 0xffffffffu >> (kTimeSlices - 1 - (to - from)) << from;
  return all & slicesWithin(box.rowFirst, box.rowLast + 1, wrapColumn(firstColumn(box)), boxColumnCount(box));
}

// True if a division repays itself for a triangle that has a much smaller box in a part of the interval.
bool repaysDivision(Interval interval, Box box) {
  uint count = interval.to - interval.from + 1;
  if (boxColumnCount(box) * boxRowCount(box) <= (LISTED ? kFewSliceBeams : kFewIntervalBeams) || count == 1) return false;
  return LISTED || (count > frame.columns / kMostIntervals && frame.columns <= kMostExactColumns);
}

// Returns the first and the last column, moment or slice of an interval in which beams of a box fire. The first may lie
// behind the last if there are none.
uvec2 firingIn(Interval interval, Box box) {
  if (LISTED) return runOfSlices(slicesIn(interval.from, interval.to, box));
  int first = firstColumn(box), last = first + int(boxColumnCount(box)) - 1, turnColumns = int(frame.columns);
  if (STAGGERED) {
    first += int(floor(float(frame.momentsBefore) - frame.shiftMax));
    last += int(ceil(float(frame.momentsBefore) - frame.shiftMin));
  }
  int from = int(interval.to), to = int(interval.from);
  for (int k = -1; k <= 1; ++k) {
    int low = max(first + k * turnColumns, int(interval.from)), high = min(last + k * turnColumns, int(interval.to));
    if (low > high) continue;
    from = min(from, low);
    to = max(to, high);
  }
  return uvec2(from, to);
}

// Narrows an interval to the columns, moments or slices in which beams of the triangle's box fire, if these are at most
// half of it. Otherwise narrows the interval to its first half.
void divide(Box box, inout Interval interval) {
  uvec2 firing = firingIn(interval, box);
  if (firing.x <= firing.y && 2 * (firing.y - firing.x + 1) <= interval.to - interval.from + 1) {
    interval.from = firing.x;
    interval.to = firing.y;
  } else {
    interval.to = interval.from + (interval.to - interval.from) / 2;
    interval.end = interval.to + 1;
  }
}
