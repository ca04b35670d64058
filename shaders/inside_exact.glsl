// SPDX-License-Identifier: Apache-2.0
// The exact inside test: the side of an edge is the sign of det(a, b, beam), computed first in floating point with a
// proven error bound, then in integers. A beam that hits an edge is treated as shifted infinitesimally up, then left,
// then forward, so exactly one triangle of each layer of a closed surface owns it, whatever the winding (simulation of
// simplicity, Edelsbrunner and Muecke, ACM TOG 9(1), 1990, applied to the beam). The range is the real quotient det(a,
// b, c) / (sum of the sides), correctly rounded. No result depends on how a device rounds.

#include "bigint.glsl"

// Returns on which side of the edge from a to b the shifted beam lies; 0 only if a and b are collinear with the
// sensor.
int exactSide(vec3 a, vec3 b, vec3 beam) {
  int side = 0;
  [[dont_unroll]] for (int move = 0; move < 4 && side == 0; ++move) {
    vec3 direction = move == 0 ? beam : vec3(equal(ivec3(3, 2, 1), ivec3(move)));
    Big sum = zeroBig();
    addDeterminant(sum, a, b, direction, kDirectionScale);
    side = signOf(sum);
  }
  return side;
}

// True if the shifted beam is on the same side of all three edges; `averted` is true if the triangle's back faces the
// sensor.
bool exactInside(Triangle triangle, vec3 beam, out bool averted) {
  vec3 a = triangle.a, b = triangle.b, c = triangle.c;
  int sum = 0;
  [[dont_unroll]] for (int edge = 0; edge < 3; ++edge) {
    sum += exactSide(a, b, beam);
    vec3 first = a;
    a = b;
    b = c;
    c = first;
  }
  averted = sum > 0;
  return abs(sum) == 3;
}

// Limits of the bisection below; a hit nearer than 2^-60 m does not count.
const uint kSmallestRange = 0x21800000u;  // 2^-60
const uint kLargestRange = 0x4e800000u;   // 2^30
const int kQuotientScale = 84;

// True if volume / spread lies above the midpoint between the float with these bits and the next one, or on the
// midpoint if the next float is the even one. Both are positive; volume is scaled by 2^90, spread by 2^120.
bool roundsAbove(Big volume, Big spread, uint bits) {
  uint midpoint = ((bits & 0x7fffffu) | 0x800000u) * 2 + 1;
  int exponent = int(bits >> 23) - 151;
  int sign = signOf(difference(scaled(volume, 1, 30 + kQuotientScale), scaled(spread, midpoint, exponent + kQuotientScale)));
  return sign > 0 || (sign == 0 && (bits & 1) != 0);
}

// Finds the correctly rounded range by bisection over floats. The guess only saves steps.
bool exactRange(vec3 a, vec3 b, vec3 c, vec3 beam, float guess, out float range) {
  range = 0.0;
  Big volume = zeroBig(), spread = zeroBig();
  addDeterminant(volume, a, b, c, kCoordinateScale);
  vec3 from = a, to = b, next = c;
  [[dont_unroll]] for (int edge = 0; edge < 3; ++edge) {
    addDeterminant(spread, from, to, beam, kDirectionScale);
    vec3 first = from;
    from = to;
    to = next;
    next = first;
  }
  int sign = signOf(spread);
  if (sign == 0 || signOf(volume) != sign) return false;
  if (sign < 0) {
    volume = negated(volume);
    spread = negated(spread);
  }
  uint low = kSmallestRange, high = kLargestRange;
  bool guessed = guess > 1e-15 && guess < 1e9;
  // The first two steps test close to the guess, so that a good guess leaves only four more steps.
  [[dont_unroll]] for (int step = 0; low < high; ++step) {
    uint near = floatBitsToUint(guess), middle = (low + high) / 2;
    if (guessed && step == 0) middle = near - 8;
    if (guessed && step == 1) middle = clamp(near + 8, low, high - 1);
    if (roundsAbove(volume, spread, middle))
      low = middle + 1;
    else
      high = middle;
  }
  range = uintBitsToFloat(low);
  return low > kSmallestRange && low < kLargestRange;
}

#ifdef FLOAT64

// Double precision as a filter: it represents products of two floats exactly. kUnit is half its unit in the last
// place.
const double kUnit = 1.1102230246251565e-16lf;

struct ExactTriangle {
  dvec3 ab, bc, ca;     // cross products; each component is rounded once
  double sideBound;     // error bound of each side, for any beam
  dvec3 normal;         // (b - a) x (c - a)
  dvec3 normalBound;
  double volume, volumeBound;
};

double sumOf(dvec3 v) { return v.x + v.y + v.z; }

ExactTriangle exactTriangle(Triangle triangle) {
  dvec3 a = dvec3(triangle.a), b = dvec3(triangle.b), c = dvec3(triangle.c);
  ExactTriangle exact;
  exact.ab = cross(a, b);
  exact.bc = cross(b, c);
  exact.ca = cross(c, a);
  // A side is a sum of three products with |beam| <= 1, so any path has at most five roundings.
  exact.sideBound = 5.0lf * kUnit * max(max(sumOf(abs(exact.bc)), sumOf(abs(exact.ca))), sumOf(abs(exact.ab)));
  dvec3 u = b - a, v = c - a;
  exact.normal = cross(u, v);
  exact.normalBound = 8.0lf * kUnit * (abs(u.yzx) * abs(v.zxy) + abs(u.zxy) * abs(v.yzx));
  exact.volume = dot(exact.normal, a);
  exact.volumeBound = dot(exact.normalBound, abs(a));
  return exact;
}

// Rounds a positive double to the nearest float, ties to even, by its bits.
float roundToFloat(double value) {
  uvec2 word = unpackDouble2x32(value);
  uint bits = ((word.y >> 20) - (1023 - 127)) << 23 | (word.y & 0xfffffu) << 3 | word.x >> 29;
  uint rest = word.x & 0x1fffffffu;
  if (rest > 0x10000000u || (rest == 0x10000000u && (bits & 1) != 0)) ++bits;
  return uintBitsToFloat(bits);
}

bool meetExact(Triangle triangle, ExactTriangle exact, vec3 beam, uint index, out float range) {
  range = 0.0;
  dvec3 r = dvec3(beam);
  dvec3 side = dvec3(dot(exact.bc, r), dot(exact.ca, r), dot(exact.ab, r));
  // Floating point decides almost every case, and almost always the beam is outside.
  double low = min(min(side.x, side.y), side.z), high = max(max(side.x, side.y), side.z);
  if (low < -exact.sideBound && high > exact.sideBound) return false;
  bool someUp = low > exact.sideBound;
  if (!someUp && high >= -exact.sideBound) {
    atomicAdd(counters.integerSides, 1);
    if (!exactInside(triangle, beam, someUp)) return false;
  }
  if (triangle.oneSided && someUp) return false;
  double spread = dot(exact.normal, r), spreadBound = dot(exact.normalBound, abs(r));
  if (abs(spread) > 4.0lf * spreadBound) {
    double quotient = exact.volume / spread;
    double error = 1.5lf * (exact.volumeBound + abs(quotient) * spreadBound) / abs(spread) + 16.0lf * kUnit * abs(quotient);
    if (quotient + error < 8e-19lf) return false;  // nearer than kSmallestRange, or behind the sensor
    range = roundToFloat(max(quotient - error, 1e-19lf));
    if (range > farthestOf(index)) return false;
    if (range > 1e-18 && range == roundToFloat(quotient + error)) return true;
  }
  atomicAdd(counters.integerRanges, 1);
  return exactRange(triangle.a, triangle.b, triangle.c, beam, range, range);
}

#else

// Single precision as a filter, for devices without double precision.
struct ExactTriangle {
  vec3 ab, bc, ca;  // a x (b - a) and so on
  vec3 sideBound;
};

vec3 edgeCross(vec3 a, vec3 b, out float bound) {
  precise vec3 e = b - a;
  precise vec3 n = a.yzx * e.zxy - a.zxy * e.yzx;
  vec3 terms = abs(a.yzx) * abs(e.zxy) + abs(a.zxy) * abs(e.yzx);
  bound = 6e-7 * (terms.x + terms.y + terms.z);  // 8 roundings of 2^-24, plus the rounding of the bound itself
  return n;
}

ExactTriangle exactTriangle(Triangle triangle) {
  ExactTriangle exact;
  exact.bc = edgeCross(triangle.b, triangle.c, exact.sideBound.x);
  exact.ca = edgeCross(triangle.c, triangle.a, exact.sideBound.y);
  exact.ab = edgeCross(triangle.a, triangle.b, exact.sideBound.z);
  return exact;
}

bool meetExact(Triangle triangle, ExactTriangle exact, vec3 beam, uint index, out float range) {
  range = 0.0;
  if (triangle.rangeMin > farthestOf(index)) return false;
  precise vec3 side = vec3(dot(exact.bc, beam), dot(exact.ca, beam), dot(exact.ab, beam));
  bool someUp = any(greaterThan(side, exact.sideBound)), someDown = any(lessThan(side, -exact.sideBound));
  if (someUp && someDown) return false;
  if (any(lessThanEqual(abs(side), exact.sideBound))) {
    atomicAdd(counters.integerSides, 1);
    if (!exactInside(triangle, beam, someUp)) return false;
  }
  if (triangle.oneSided && someUp) return false;
  vec3 normal = cross(triangle.b - triangle.a, triangle.c - triangle.a);
  float guess = dot(normal, triangle.a) / dot(normal, beam);
  atomicAdd(counters.integerRanges, 1);
  return exactRange(triangle.a, triangle.b, triangle.c, beam, guess, range);
}

#endif
