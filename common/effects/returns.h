// SPDX-License-Identifier: Apache-2.0
// Chooses which of a beam's detected echoes become returns.
#ifndef GNOSPHERE_EFFECTS_RETURNS_H
#define GNOSPHERE_EFFECTS_RETURNS_H

#include "parameters.h"

#ifdef __cplusplus
namespace gnosphere::gpu {
#endif

// The echoes that a returns mode can name, by their number in order of range; kNone if there is no such echo.
struct Choice {
  uint first, second, last, strongest, secondStrongest;
  float power, secondPower;  // of the two strongest
  uint detected;             // one bit per detected echo
};

GNO_INLINE Choice noChoice() {
  Choice choice;
  choice.first = choice.second = choice.last = choice.strongest = choice.secondStrongest = kNone;
  choice.power = choice.secondPower = 0.0f;
  choice.detected = 0u;
  return choice;
}

// Adds a detected echo to the choice. Echoes must be added in order of range; of equally strong echoes the nearer
// counts as stronger.
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

// Bits of the echoes that become returns. If a mode names two echoes and both are the same, there is one return. Mode
// kModeAll returns the bits of all detected echoes; the caller stores as many as fit, nearest first.
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
  if (mode == kModeDual) return last == strongest ? strongest | secondStrongest : last | strongest;
  return choice.detected;
}

// Full width of an echo at half maximum, in metres: the width of the pulse combined with the spread of the depths that
// it came from (standard deviation), added like variances of normal distributions; 2.354820 = 2 sqrt(2 ln 2).
GNO_INLINE float echoWidth(float pulseWidth, float depthDeviation) {
  GNO_PRECISE float spread = 2.354820f * depthDeviation;
  GNO_PRECISE float result = squareRoot(pulseWidth * pulseWidth + spread * spread);
  return result;
}

#ifdef __cplusplus
}  // namespace gnosphere::gpu
#endif
#endif
