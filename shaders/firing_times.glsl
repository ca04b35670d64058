// SPDX-License-Identifier: Apache-2.0
// The times at which beams fire, as places in the table of the sensor's poses.

// Returns one bit for each slice of time in which the beams of cells fire: those of rows first..end - 1, and of `count`
// columns from `column` on, which may wrap.
uint slicesWithin(uint first, uint end, uint column, uint count) {
  uint perRow = (frame.columns - 1) / kSliceColumns + 1, y = first / kSliceRows, yEnd = (end - 1) / kSliceRows + 1;
  if ((count / kSliceColumns + 2) * (yEnd - y) > kMostSliceMasks) return 0xffffffffu;
  uint slices = 0, table = firstOfTable(perRow * ((frame.rows - 1) / kSliceRows + 1));
  for (uint k = 0; k < count;) {
    for (uint row = y; row < yEnd; ++row) slices |= sliceMasks.at[table + row * perRow + column / kSliceColumns];
    uint run = min(kSliceColumns - column % kSliceColumns, frame.columns - column);
    k += run;
    column = column + run == frame.columns ? 0 : column + run;
  }
  return slices;
}

// Returns the first and the last slice whose bit is set; one must be.
uvec2 runOfSlices(uint slices) { return uvec2(findMSB(slices & (~slices + 1)), findMSB(slices)); }

// Returns the least and the largest place in the table of the sensor's poses among all beams in columns or slices
// from..to.
vec2 placesOf(uint from, uint to) {
  if (LISTED) return vec2(float(from), float(to + 1)) * float(kSliceIntervals);
  bool whole = to - from + 1 == frame.columns;
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

// The number of columns of the scan, or of moments (entries of columnMotions) where rows have shifts, or of slices of
// time of a list.
uint intervalsEnd() {
  if (LISTED) return kTimeSlices;
  return STAGGERED ? frame.momentsBefore + frame.columns + frame.momentsAfter : frame.columns;
}

bool isWholeScan(uvec2 times) { return times.x == 0 && times.y + 1 == intervalsEnd(); }
