// SPDX-License-Identifier: Apache-2.0
// Stateless random numbers: Philox4x32-10 of Salmon et al., "Parallel random numbers: as easy as 1, 2, 3" (SC 2011).
#ifndef GNOSPHERE_EFFECTS_RANDOM_H
#define GNOSPHERE_EFFECTS_RANDOM_H

#include "parameters.h"

#ifdef __cplusplus
namespace gnosphere::gpu {
#endif

// The echo number under which the medium's echo draws random numbers.
GNO_CONST uint kScatterDraw = 100;

// Returns four pseudo-random words for a counter and a key.
GNO_INLINE uvec4 philox(uvec4 counter, uint keyLow, uint keyHigh) {
  uvec4 state = counter;
  for (uint round = 0u; round < 10u; ++round) {
    uint highX = productHigh(0xd2511f53u, state.x), lowX = 0xd2511f53u * state.x;
    uint highZ = productHigh(0xcd9e8d57u, state.z), lowZ = 0xcd9e8d57u * state.z;
    state.x = highZ ^ state.y ^ (keyLow + round * 0x9e3779b9u);
    state.z = highX ^ state.w ^ (keyHigh + round * 0xbb67ae85u);
    state.y = lowZ;
    state.w = lowX;
  }
  return state;
}

// Returns the random words for (seed, sensor, frame, beam, sub-ray, effect). Every effect has its own words, so no
// effect can change the draws of another. `effect` is its bit of bits.h: the first 17 effects have one of the lower 17
// bits of the counter, and each later one bit 0 and another, so that a new effect changes the draws of none. An effect
// that draws per echo, or several times, counts its draws in `subRay`, up to 32767.
GNO_INLINE uvec4 draw(EffectParameters p, uint beam, uint subRay, uint effect) {
  uvec4 counter;
  counter.x = beam;
  counter.y = subRay << 17 | (effect < 1u << 17 ? effect : effect >> 16 | 1u);
  counter.z = p.frame;
  counter.w = p.sensor;
  return philox(counter, p.seedLow, p.seedHigh);
}

// A uniform number with 0 <= u < 1, a multiple of 2^-24.
GNO_INLINE float uniform01(uint word) {
  GNO_PRECISE float result = float(word >> 8) * 5.9604644775390625e-8f;
  return result;
}

// A uniform number with 0 < u <= 1, so that its logarithm is finite.
GNO_INLINE float uniformAboveZero(uint word) {
  GNO_PRECISE float result = float((word >> 8) + 1u) * 5.9604644775390625e-8f;
  return result;
}

// Four independent normal variables with mean 0 and variance 1, at most 5.8 in magnitude: Box and Muller (1958).
GNO_INLINE vec4 gaussians(uvec4 words) {
  GNO_PRECISE float radius0 = squareRoot(-2.0f * naturalLog(uniformAboveZero(words.x)));
  GNO_PRECISE float radius1 = squareRoot(-2.0f * naturalLog(uniformAboveZero(words.z)));
  vec2 turn0 = cosSinOfTurn(uniform01(words.y));
  vec2 turn1 = cosSinOfTurn(uniform01(words.w));
  GNO_PRECISE vec4 result;
  result.x = radius0 * turn0.x;
  result.y = radius0 * turn0.y;
  result.z = radius1 * turn1.x;
  result.w = radius1 * turn1.y;
  return result;
}

#ifdef __cplusplus
}  // namespace gnosphere::gpu
#endif
#endif
