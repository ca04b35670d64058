// SPDX-License-Identifier: Apache-2.0
// Which of a beam's detected echoes are returned.
#ifndef GNOSPHERE_EFFECTS_RETURNS_H
#define GNOSPHERE_EFFECTS_RETURNS_H

#include "parameters.h"

#ifdef __cplusplus
namespace gnosphere::gpu {
#endif

// The echoes that a mode may name, by their number in order of range; kNone: there is no such echo.
struct Choice {
  uint first, second, last, strongest, secondStrongest;
  float power, secondPower;  // of the strongest two
  uint detected;             // bits: all of them
};

GNO_INLINE Choice noChoice() {
  Choice choice;
  choice.first = choice.second = choice.last = choice.strongest = choice.secondStrongest = kNone;
  choice.power = choice.secondPower = 0.0f;
  choice.detected = 0u;
  return choice;
}

// One more detected echo; to be called in order of range. Of equally strong ones the nearer is the stronger.
GNO_INLINE void consider(GNO_INOUT(Choice) choice, uint number, float power) {
  choice.detected |= 1u << number;
  choice.last = number;
  if (choice.first == kNone)
    choice.first = number;
  else if (choice.second == kNone)
    choice.second = number;
  if (choice.strongest == kNone || power > choice.power) {
    choice.secondStrongest = choice.strongest;
    choice.secondPower = choice.power;
    choice.strongest = number;
    choice.power = power;
  } else if (choice.secondStrongest == kNone || power > choice.secondPower) {
    choice.secondStrongest = number;
    choice.secondPower = power;
  }
}

GNO_INLINE uint bitOf(uint number) {
  return number == kNone ? 0u : 1u << number;
}

// Bits of the echoes that are returned. Where both of a pair are the same echo there is one return. `all` is all that
// fit, the nearest first: the caller counts.
GNO_INLINE uint chosen(Choice choice, uint mode) {
  uint first = bitOf(choice.first), second = bitOf(choice.second), last = bitOf(choice.last);
  uint strongest = bitOf(choice.strongest), secondStrongest = bitOf(choice.secondStrongest);
  if (mode == kModeFirst) return first;
  if (mode == kModeSecond) return second;
  if (mode == kModeLast) return last;
  if (mode == kModeStrongest) return strongest;
  if (mode == kModeSecondStrongest) return secondStrongest;
  if (mode == kModeFirstSecond) return first | second;
  if (mode == kModeFirstLast) return first | last;
  if (mode == kModeFirstStrongest) return first | strongest;
  if (mode == kModeLastStrongest) return last | strongest;
  if (mode == kModeStrongestSecondStrongest) return strongest | secondStrongest;
  return choice.detected;
}

// Width of an echo, full at half maximum: the pulse's own and that of the depths it came from (standard deviation,
// metres), as normal distributions add up; 2.354820 = 2 sqrt(2 ln 2).
GNO_INLINE float echoWidth(float pulseWidth, float depthDeviation) {
  GNO_PRECISE float spread = 2.354820f * depthDeviation;
  GNO_PRECISE float result = squareRoot(pulseWidth * pulseWidth + spread * spread);
  return result;
}

#ifdef __cplusplus
}  // namespace gnosphere::gpu
#endif
#endif
