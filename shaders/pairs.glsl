// SPDX-License-Identifier: Apache-2.0
// Numbers of about 46 bits, for devices without double precision: each is the sum of two floats, of which the second
// is at most half a unit in the last place of the first (T. J. Dekker, A floating-point technique for extending the
// available precision, 1971). All functions work on three numbers at a time.

struct Pairs {
  vec3 high, low;
};

Pairs pairs(vec3 value) { return Pairs(value, vec3(0.0)); }
// Returns three times number k.
Pairs each(Pairs a, int k) { return Pairs(vec3(a.high[k]), vec3(a.low[k])); }
Pairs negative(Pairs a) { return Pairs(-a.high, -a.low); }

// Returns the sum of floats without an error; no magnitude of `a` may be less than that of `b`.
Pairs sumOfOrdered(vec3 a, vec3 b) {
  precise vec3 high = a + b;
  precise vec3 low = b - (high - a);
  return Pairs(high, low);
}

// Returns the sum of floats without an error.
Pairs sumOf(vec3 a, vec3 b) {
  precise vec3 high = a + b, fromB = high - a;
  precise vec3 low = (a - (high - fromB)) + (b - fromB);
  return Pairs(high, low);
}

// Returns the product of floats without an error, unless it is too large or too small.
Pairs productOf(vec3 a, vec3 b) {
  precise vec3 high = a * b;
  // Halves of 12 bits each, whose products are exact.
  vec3 highA = uintBitsToFloat(floatBitsToUint(a) & 0xfffff000u);
  vec3 highB = uintBitsToFloat(floatBitsToUint(b) & 0xfffff000u);
  precise vec3 lowA = a - highA, lowB = b - highB;
  precise vec3 low = ((highA * highB - high) + highA * lowB + lowA * highB) + lowA * lowB;
  return Pairs(high, low);
}

Pairs plus(Pairs a, Pairs b) {
  Pairs sum = sumOf(a.high, b.high), rest = sumOf(a.low, b.low);
  precise vec3 low = sum.low + rest.high;
  // glslangValidator does not end if a struct is assigned what comes from it.
  Pairs closer = sumOfOrdered(sum.high, low);
  precise vec3 lowest = closer.low + rest.low;
  return sumOfOrdered(closer.high, lowest);
}

Pairs times(Pairs a, Pairs b) {
  Pairs product = productOf(a.high, b.high);
  precise vec3 low = product.low + (a.high * b.low + a.low * b.high);
  return sumOfOrdered(product.high, low);
}

Pairs over(Pairs a, Pairs b) {
  precise vec3 first = a.high / b.high;
  Pairs rest = plus(a, negative(times(b, pairs(first))));
  precise vec3 second = rest.high / b.high;
  Pairs last = plus(rest, negative(times(b, pairs(second))));
  precise vec3 third = last.high / b.high;
  return plus(sumOf(first, second), pairs(third));
}

Pairs crossOf(Pairs a, Pairs b) {
  return plus(times(Pairs(a.high.yzx, a.low.yzx), Pairs(b.high.zxy, b.low.zxy)),
              negative(times(Pairs(a.high.zxy, a.low.zxy), Pairs(b.high.yzx, b.low.yzx))));
}

// A matrix of numbers, given by its columns or by its rows.
struct PairsMatrix {
  Pairs of[3];
};

PairsMatrix matrixOf(Pairs a, Pairs b, Pairs c) {
  PairsMatrix matrix;
  matrix.of[0] = a;
  matrix.of[1] = b;
  matrix.of[2] = c;
  return matrix;
}

// Returns a matrix times the vector `a`, as the sum of the matrix's columns, each times one number of `a`; with rows in
// place of columns it is the transposed matrix that is multiplied.
Pairs combined(PairsMatrix matrix, Pairs a) {
  return plus(plus(times(matrix.of[0], each(a, 0)), times(matrix.of[1], each(a, 1))),
              times(matrix.of[2], each(a, 2)));
}

PairsMatrix transposed(PairsMatrix matrix) {
  mat3 high = transpose(mat3(matrix.of[0].high, matrix.of[1].high, matrix.of[2].high));
  mat3 low = transpose(mat3(matrix.of[0].low, matrix.of[1].low, matrix.of[2].low));
  return matrixOf(Pairs(high[0], low[0]), Pairs(high[1], low[1]), Pairs(high[2], low[2]));
}
