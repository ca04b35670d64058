// SPDX-License-Identifier: Apache-2.0
// Combines the hits of a beam's light into echoes. An echo begins with a hit, and hits that are no farther behind it
// than the separation belong to it.

const float kUnseen = -1.0;  // energy of a hit that only lets light pass and is part of no echo

float product(float a, float b) {
  precise float result = a * b;
  return result;
}

float sumOf(float a, float b) {
  precise float result = a + b;
  return result;
}

// Returns the inverse of the range of an echo's nearest hit, for the functions below. Nearer than a micrometre the ratio of
// two ranges could be too large a number.
float inverseOfFirst(float first) { return quotient(1.0, max(first, 1e-6)); }

// Adds a hit to the sums of an echo: power, power * depth, power * depth^2. The power at the receiver is energy / range^2,
// here a multiple of what the same energy would give at the nearest hit: energy / (1 + x)^2 with x = depth / first, written
// so that it is exactly the energy at depth 0.
void addPiece(inout vec3 sums, float energy, float depth, float inverseFirst) {
  precise float x = depth * inverseFirst, stretch = 1.0 + x;
  precise float power = energy - energy * quotient(x * (2.0 + x), stretch * stretch), moment = power * depth;
  precise vec3 result = sums + vec3(power, moment, moment * depth);
  sums = result;
}

// Returns range, energy and width. The energy is that of a surface at this range that gives the power of all hits.
vec3 echoOf(float first, float inverseFirst, vec3 sums) {
  if (!(sums.x > 0.0)) return vec3(first, 0.0, parameters.pulseWidth);
  precise float mean = quotient(sums.y, sums.x);
  precise float variance = quotient(sums.z, sums.x) - mean * mean;
  precise float range = first + mean;
  precise float stretch = 1.0 + mean * inverseFirst, energy = sums.x * (stretch * stretch);
  return vec3(range, energy, echoWidth(parameters.pulseWidth, squareRoot(max(variance, 0.0))));
}
