// SPDX-License-Identifier: Apache-2.0
// Exact angular bounds of a triangle seen from the origin. An edge is an arc of a great circle, so its highest point
// may lie between its ends. Inside the triangle, elevation has an extremum only at a pole. Derivation: with a x b = n,
// the highest point of the circle is z - (z.n)n/|n|^2, and it lies on the arc if and only if both f and g below are
// positive.

// Returns a x b, computed from the shorter of the two vectors, so that its error is relative to the distance of the
// longer one.
vec3 arcNormal(vec3 a, vec3 b) { return cross(dot(a, a) < dot(b, b) ? a : b, b - a); }

// Widens keyMin..keyMax by the extremum of the arc from a to b, if it lies inside: then (n x a).z and (b x n).z have
// the same sign.
void widenByArc(vec3 a, vec3 b, inout float keyMin, inout float keyMax) {
  vec3 n = arcNormal(a, b);
  float f = n.x * a.y - n.y * a.x;
  float g = n.y * b.x - n.x * b.y;
  float apex = elevationKey(abs(n.z), length(n.xy));
  if (f > 0.0 && g > 0.0) keyMax = max(keyMax, apex);
  if (f < 0.0 && g < 0.0) keyMin = min(keyMin, -apex);
  // If the arc is almost half a turn, the rounding of n tilts the whole circle by 1e-6 / sin(arc).
  float along = dot(a, b), squares = dot(a, a) * dot(b, b);
  if (along < 0.0 && dot(n, n) < 0.04 * squares) {
    float tilt = min(2e-6 * sqrt(squares / max(dot(n, n), 1e-12 * squares)), 2.0);
    keyMin -= tilt;
    keyMax += tilt;
  }
}

// True if the vertical axis passes through the edge from a to b, or so close to it that rounding could hide it.
bool edgeMeetsAxis(vec2 a, vec2 b) {
  float along = dot(a, b), across = a.x * b.y - a.y * b.x;
  return along <= 0.0 && abs(across) <= 1e-4 * -along;
}

bool nearAxis(vec3 v) { return dot(v.xy, v.xy) <= 1e-8 * v.z * v.z; }

// The poles inside a triangle: none, the upper one (1), the lower one (-1), or undecided (2), which counts as both.
const int kNoPole = 0, kUpperPole = 1, kLowerPole = -1, kAnyPole = 2;

int poleInside(vec3 a, vec3 b, vec3 c) {
  if (edgeMeetsAxis(a.xy, b.xy) || edgeMeetsAxis(b.xy, c.xy) || edgeMeetsAxis(c.xy, a.xy) || nearAxis(a) ||
      nearAxis(b) || nearAxis(c))
    return kAnyPole;
  vec3 turn = vec3(a.x * b.y - a.y * b.x, b.x * c.y - b.y * c.x, c.x * a.y - c.y * a.x);
  if (!(all(greaterThan(turn, vec3(0.0))) || all(lessThan(turn, vec3(0.0))))) return kNoPole;
  vec3 u = b - a, v = c - a;
  vec3 n = cross(u, v);
  float height = dot(n, a);
  // The sensor is so close to the triangle's plane that rounding could hide on which side it is.
  if (!(abs(height) > 2e-6 * length(a) * length(u) * length(v))) return kAnyPole;
  float k = height * n.z;
  return k > 0.0 ? kUpperPole : k < 0.0 ? kLowerPole : kAnyPole;
}

// True if the sensor lies on the edge from a to b: the edge then spans half a great circle.
bool edgeMeetsOrigin(vec3 a, vec3 b) {
  vec3 n = arcNormal(a, b);
  return dot(a, b) < 0.0 && dot(n, n) <= 1e-12 * dot(a, a) * dot(b, b);
}

// The span of elevation keys that a triangle covers; it ends at 1 or -1 if the triangle contains a pole.
struct Outline {
  float keyMin, keyMax;
};

vec3 keysOf(vec3 a, vec3 b, vec3 c) {
  return vec3(elevationKey(length(a.xy), a.z), elevationKey(length(b.xy), b.z), elevationKey(length(c.xy), c.z));
}

Outline outlineOf(vec3 a, vec3 b, vec3 c) {
  vec3 keys = keysOf(a, b, c);
  Outline outline;
  outline.keyMin = min(min(keys.x, keys.y), keys.z);
  outline.keyMax = max(max(keys.x, keys.y), keys.z);
  int pole = kNoPole;
  bool wide = false;
  if (BOUNDS == kBoundsExact) {
    widenByArc(a, b, outline.keyMin, outline.keyMax);
    widenByArc(b, c, outline.keyMin, outline.keyMax);
    widenByArc(c, a, outline.keyMin, outline.keyMax);
    pole = poleInside(a, b, c);
    wide = edgeMeetsOrigin(a, b) || edgeMeetsOrigin(b, c) || edgeMeetsOrigin(c, a);
  }
  if (wide || pole == kUpperPole || (pole == kAnyPole && max(max(a.z, b.z), c.z) > 0.0)) outline.keyMax = 1.0;
  if (wide || pole == kLowerPole || (pole == kAnyPole && min(min(a.z, b.z), c.z) < 0.0)) outline.keyMin = -1.0;
  outline.keyMin -= keySlack();
  outline.keyMax += keySlack();
  return outline;
}

// The beams that may hit a triangle: columns columnMin..columnMax (real numbers that may wrap) and rows, both ends
// included.
struct Box {
  float columnMin, columnMax;
  uint rowFirst, rowLast;
  uvec2 times;  // if TIMED: the first and the last slice or moment in which its beams fire
};

// Sets the rows that the outline may cover; false if it lies between two rows or outside the field of view.
bool coverRows(Outline outline, inout Box box) {
  uint end;
  rowsBetween(outline.keyMin, outline.keyMax, box.rowFirst, end);
  box.rowLast = end - 1;
  return box.rowFirst < end;
}

uint boxRowCount(Box box) { return box.rowLast - box.rowFirst + 1; }

// Returns the first column of the box, not yet wrapped. A beam may lie in the box although its column lies before it.
int firstColumn(Box box) { return whole(ceil(box.columnMin - BESIDE)); }

// Returns the number of columns that the box covers, at most all of them. Columns are counted in integers because
// floats above 2^24 cannot represent every whole number.
uint boxColumnCount(Box box) {
  return uint(min(max(whole(floor(box.columnMax)) + 1 - firstColumn(box), 0), int(frame.columns)));
}

// Returns by how many columns the beams of a row that lie in a box are behind their places, at least and at most.
vec2 behindIn(uint row, Box box) {
  if (!AZIMUTH_OFFSETS) return vec2(0.0);
  uint beam = wrapColumn(int(wrapColumn(firstColumn(box))) - loadedRow(row).first), end = beam + boxColumnCount(box);
  // A box may hold the end and the start of a row.
  bool wraps = end > frame.columns;
  return loadedRow(row).behind +
         frame.stretch * vec2(wraps ? 0.0 : float(beam), wraps ? float(frame.columns) : float(end));
}

// True if a box has so few beams that one invocation tries them all; a subgroup shares the beams of a larger box.
bool isSmall(Box box) { return boxColumnCount(box) * boxRowCount(box) <= kSmallBoxBeams; }

// Sets the columns that the triangle may cover; false if it lies between two columns. A rounding error means a larger
// error in azimuth near a pole: 1 - |key| is cos(elevation) within a factor of 1.42. So near a pole every column is
// covered. A triangle that contains no pole spans less than pi, so its azimuths are found relative to corner a.
bool coverColumns(vec3 a, vec3 b, vec3 c, Outline outline, inout Box box) {
  float turnColumns = float(frame.columns);
  box.columnMin = 0.0;
  box.columnMax = turnColumns;
  float slack = columnSlack(outline.keyMin, outline.keyMax);
  if (slack > 0.25 * turnColumns) return true;
  float start = azimuthOf(a.y, a.x);
  float toB = azimuthOf(a.x * b.y - a.y * b.x, dot(a.xy, b.xy));
  float toC = azimuthOf(a.x * c.y - a.y * c.x, dot(a.xy, c.xy));
  float low = min(min(toB, toC), 0.0), high = max(max(toB, toC), 0.0);
  // columnMin may be negative and columnMax beyond the last column; code that iterates over the columns wraps them.
  box.columnMin = columnAt(start + low) - slack;
  box.columnMax = box.columnMin + (high - low) * frame.columnsPerRadian + 2.0 * slack;
  return boxColumnCount(box) > 0;
}
