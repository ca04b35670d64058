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

// Adds a hit to the sums of an echo: energy, energy * depth, energy * depth^2.
void addPiece(inout vec3 sums, float energy, float depth) {
  precise float moment = energy * depth;
  precise vec3 result = sums + vec3(energy, moment, moment * depth);
  sums = result;
}

// Returns range, energy and width.
vec3 echoOf(float first, vec3 sums) {
  if (!(sums.x > 0.0)) return vec3(first, 0.0, parameters.pulseWidth);
  precise float mean = quotient(sums.y, sums.x);
  precise float variance = quotient(sums.z, sums.x) - mean * mean;
  precise float range = first + mean;
  return vec3(range, sums.x, echoWidth(parameters.pulseWidth, squareRoot(max(variance, 0.0))));
}
