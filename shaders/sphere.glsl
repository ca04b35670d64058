// SPDX-License-Identifier: Apache-2.0
// Angles on the sphere around the sensor. GLSL's own trigonometry is not used, because Vulkan lets atan err by 4096
// ULP.

const float kPi = 3.14159265358979;

// A number that increases with elevation, from -1 at the lower pole to 1 at the upper; h is the distance from the
// vertical axis. Its slope lies between 1/2 and 1 per radian, so an error of the key is an error of the angle up to a
// factor of 2.
float elevationKey(float h, float z) {
  float sum = abs(z) + h;
  return sum > 0.0 ? z / sum : 0.0;
}

// atan2 with an error of 3.5e-7 rad: Chebyshev fit of atan on [0, 1], folded by octant.
float azimuthOf(float y, float x) {
  float ax = abs(x), ay = abs(y);
  float high = max(ax, ay);
  float t = high > 0.0 ? min(ax, ay) / high : 0.0;
  float s = t * t;
  float p = -0.00455979199;
  p = p * s + 0.0237805186;
  p = p * s - 0.0588297531;
  p = p * s + 0.0986886546;
  p = p * s - 0.140032902;
  p = p * s + 0.199669618;
  p = p * s - 0.333318127;
  p = p * s + 0.999999882;
  float angle = t * p;
  if (ay > ax) angle = 0.5 * kPi - angle;
  if (x < 0.0) angle = kPi - angle;
  return y < 0.0 ? -angle : angle;
}

// Returns a lower bound of the distance from the sensor to a box.
float nearestPoint(vec3 low, vec3 high) { return length(max(max(low, -high), vec3(0.0))) * 0.999999; }

// The largest angle in radians by which the object being bounded may appear to move, in any direction, across (in
// azimuth, times the cosine of the elevation) and upwards. Without motion they stay 0.
float seeming = 0.0, seemingAcross = 0.0, seemingUp = 0.0;

void setSeeming(float angle) { seeming = seemingAcross = seemingUp = angle; }

// The angles by which bounds are widened: beams may spread, deviate from their axis or start away from the sensor's
// origin.
#define SPREADS ((EFFECTS & (kFootprint | kStrays)) != 0)
float footprint() { return (SPREADS ? frame.footprint : 0.0) + seeming; }
float spreadAcross() { return (SPREADS ? frame.spreadAcross : 0.0) + seemingAcross; }
float spreadUp() { return (SPREADS ? frame.spreadUp : 0.0) + seemingUp; }

// Elevation keys are widened by this much; a key changes by at most 1 per radian.
float keySlack() { return kKeySlack + spreadUp(); }

// Towards the poles an angle is a larger azimuth, asin(angle / cos(elevation)). Up to half a radian this is at most 1.05
// times angle / cos(elevation). 1 - |key| is no larger than the cosine, so it may replace it.
float azimuthPerRadian(float key) { return 1.0 / max(1.0 - key, 1e-6); }

// Returns the largest change of azimuth of content with elevation keys keyMin..keyMax, per radian by which it appears
// displaced. Content counts only where a beam may see it: at most `up` radians above or below the steepest beam.
float azimuthPerRadianSeen(float keyMin, float keyMax, float up) {
  return azimuthPerRadian(min(max(-keyMin, keyMax), frame.steepest + up));
}

// Columns are widened by this many; beyond half a radian, every column is covered.
float columnSlack(float keyMin, float keyMax) {
  float spread = 1.05 * spreadAcross() * azimuthPerRadianSeen(keyMin, keyMax, seemingUp);
  float rounding = frame.columnSlack * azimuthPerRadian(max(-keyMin, keyMax));
  return spread > 0.5 ? float(frame.columns) : (rounding + spread * frame.columnsPerRadian);
}

// Sets the angles by which the contents of a box appear to move if seen from lasers away from the sensor's origin. A
// laser that is forward of the origin sees an object in the same azimuth, and hardly higher or lower if the object is
// near the horizon.
void seemFromLasers(vec3 low, vec3 high) {
  float distance = nearestPoint(low, high), rest = max(distance - motion.origins, 0.0);
  float steep = min(max(abs(low.z), abs(high.z)) / max(distance, 1e-6), 1.0);
  seeming = seemingAngle(motion.origins, 0.0, distance);
  seemingAcross = seemingAngle(motion.left, 0.0, rest);
  seemingUp = seemingAngle(motion.up + (motion.forward + motion.left) * steep, 0.0, rest);
}

// True if beams may lie behind the columns of their places: rows look between these, or cells hold the beams of a list.
#define BESIDE_COLUMNS (AZIMUTH_OFFSETS || LISTED)
// The most columns by which they lie behind.
#define BESIDE (BESIDE_COLUMNS ? frame.beside : 0.0)

// True if no beam lies between two columns.
bool betweenColumns(float from, float to) { return ceil(from - BESIDE) > floor(to); }

// Returns the place of an azimuth among the columns.
float columnAt(float azimuth) { return (azimuth + kPi) * frame.columnsPerRadian - frame.phase; }

// Wraps the number of a column. A box starts between -3/4 and 1 turns, an azimuth offset adds up to 1/2 either way, and
// the box spans up to 1 turn.
uint wrapColumn(int column) {
  int turnColumns = int(frame.columns);
  if (column < 0) column += turnColumns;
  if (column < 0) column += turnColumns;
  if (column >= turnColumns) column -= turnColumns;
  if (column >= turnColumns) column -= turnColumns;
  return uint(column);
}

// Returns the number of entries of a table in `rowLookup`. A small list has few, because it may have many tables.
uint lookupCells() { return LISTED ? frame.lookupCells : kRowLookupCells; }

// Returns the lookup cell of a key; any key is allowed, even NaN.
uint lookupCell(float key) {
  float cell = clamp((key + 1.0) * (0.5 * float(lookupCells())), 0.0, float(lookupCells() - 1));
  return min(smallWhole(floor(cell)), lookupCells() - 1);
}

// Returns rows first..end - 1, which contain all rows with keys in keyMin..keyMax, and possibly further rows of the
// cells at both ends.
void rowsBetween(float keyMin, float keyMax, out uint first, out uint end) {
  uint table = firstOfTable(lookupCells());
  first = rowLookup.at[table + lookupCell(keyMin)] & 0xffff;
  end = rowLookup.at[table + lookupCell(keyMax)] >> 16;
}
