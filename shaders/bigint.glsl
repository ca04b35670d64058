// SPDX-License-Identifier: Apache-2.0
// Exact sums of products of floats in integer arithmetic: no rounding, no underflow, the same result on every device.
// A number is limbs * 2^-scale in two's complement, least significant limb first. Coordinates are multiples of 2^-30 m
// below 2^30 m, directions are multiples of 2^-60 up to 1, so a product of three needs at most 183 bits.

const int kLimbs = 10;
const int kCoordinateScale = 30;
const int kDirectionScale = 60;

struct Big {
  uint limb[kLimbs];
};

Big zeroBig() {
  Big z;
  for (int i = 0; i < kLimbs; ++i) z.limb[i] = 0;
  return z;
}

// Splits a float so that |value| = mantissa * 2^(shift - scale).
void splitFloat(float value, int scale, out uint mantissa, out int shift) {
  uint bits = floatBitsToUint(value) & 0x7fffffffu;
  int exponent = int(bits >> 23);
  mantissa = exponent == 0 ? 0 : (bits & 0x7fffffu) | 0x800000u;
  shift = exponent - 150 + scale;
  if (shift < 0) {
    mantissa = shift > -24 ? mantissa >> uint(-shift) : 0;
    shift = 0;
  }
}

// Adds words * 2^shift to sum, or subtracts it if `negative`.
void addWords(inout Big sum, uvec3 words, int shift, bool negative) {
  int first = shift >> 5;
  uint s = uint(shift & 31);
  uint spill = s == 0 ? 0 : 32 - s;
  uvec4 v = uvec4(words << s, 0);
  if (s != 0) v |= uvec4(0, words >> spill);
  uint carry = negative ? 1 : 0;
  for (int i = 0; i < kLimbs; ++i) {
    int k = i - first;
    uint word = k == 0 ? v.x : k == 1 ? v.y : k == 2 ? v.z : k == 3 ? v.w : 0;
    if (negative) word = ~word;
    uint carry1, carry2;
    uint part = uaddCarry(sum.limb[i], word, carry1);
    sum.limb[i] = uaddCarry(part, carry, carry2);
    carry = carry1 + carry2;
  }
}

// Adds x y z to sum, or subtracts it if `negate`. x and y are coordinates; z has the given scale.
void addProduct(inout Big sum, float x, float y, float z, int scale, bool negate) {
  uvec3 m;
  ivec3 shift;
  splitFloat(x, kCoordinateScale, m.x, shift.x);
  splitFloat(y, kCoordinateScale, m.y, shift.y);
  splitFloat(z, scale, m.z, shift.z);
  uint high, low, highLow, lowLow, highHigh, lowHigh, carry;
  umulExtended(m.x, m.y, high, low);
  umulExtended(low, m.z, highLow, lowLow);
  umulExtended(high, m.z, highHigh, lowHigh);
  uint middle = uaddCarry(highLow, lowHigh, carry);
  bool negative = ((floatBitsToUint(x) ^ floatBitsToUint(y) ^ floatBitsToUint(z)) >> 31) != 0;
  addWords(sum, uvec3(lowLow, middle, highHigh + carry), shift.x + shift.y + shift.z, negative != negate);
}

// Adds det(a, b, c) to sum. The coordinates of c have the scale `scale`, as splitFloat() takes it; those of a and b have
// kCoordinateScale. The loop is not unrolled because this path is rare and drivers inline every call.
void addDeterminant(inout Big sum, vec3 a, vec3 b, vec3 c, int scale) {
  [[dont_unroll]] for (int i = 0; i < 6; ++i) {
    bool swapped = i >= 3;
    addProduct(sum, swapped ? a.z : a.y, swapped ? b.y : b.z, c.x, scale, swapped);
    if (i == 2 || i == 5) continue;
    a = a.yzx;
    b = b.yzx;
    c = c.yzx;
  }
}

int signOf(Big value) {
  uint any = 0;
  for (int i = 0; i < kLimbs; ++i) any |= value.limb[i];
  return any == 0 ? 0 : (value.limb[kLimbs - 1] >> 31) != 0 ? -1 : 1;
}

Big negated(Big value) {
  uint carry = 1;
  for (int i = 0; i < kLimbs; ++i) {
    uint next;
    value.limb[i] = uaddCarry(~value.limb[i], carry, next);
    carry = next;
  }
  return value;
}

Big difference(Big a, Big b) {
  uint carry = 1;
  for (int i = 0; i < kLimbs; ++i) {
    uint carry1, carry2;
    uint part = uaddCarry(a.limb[i], ~b.limb[i], carry1);
    a.limb[i] = uaddCarry(part, carry, carry2);
    carry = carry1 + carry2;
  }
  return a;
}

// Returns value * factor * 2^shift for a value that is not negative.
Big scaled(Big value, uint factor, int shift) {
  Big product;
  uint carry = 0;
  for (int i = 0; i < kLimbs; ++i) {
    uint high, low, over;
    umulExtended(value.limb[i], factor, high, low);
    product.limb[i] = uaddCarry(low, carry, over);
    carry = high + over;
  }
  Big result;
  int first = shift >> 5;
  uint s = uint(shift & 31);
  for (int i = 0; i < kLimbs; ++i) {
    uint word = i >= first ? product.limb[max(i - first, 0)] : 0;
    uint below = i > first ? product.limb[max(i - first - 1, 0)] : 0;
    result.limb[i] = s == 0 ? word : word << s | below >> (32 - s);
  }
  return result;
}
