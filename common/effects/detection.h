// SPDX-License-Identifier: Apache-2.0
// Decides whether a return is strong enough, and whether it is lost at random.
#ifndef GNOSPHERE_EFFECTS_DETECTION_H
#define GNOSPHERE_EFFECTS_DETECTION_H

#include "parameters.h"

#ifdef __cplusplus
namespace gnosphere::gpu {
#endif

// Probability that `power` is detected: a step at the threshold or, with softness s, the logistic function of ln(power
// / threshold) / s, which is 1/2 at the threshold. The step tolerates rounding errors of 1e-6, so that a target
// exactly at the limit is detected.
GNO_INLINE float detectionProbability(float power, float threshold, float softness) {
  if (!(power > 1e-37f)) return threshold > 0.0f ? 0.0f : 1.0f;
  GNO_PRECISE float limit = threshold * 0.999999f;
  if (!(softness > 0.0f)) return power >= limit ? 1.0f : 0.0f;
  GNO_PRECISE float steps = quotient(naturalLog(power) - naturalLog(threshold), softness);
  GNO_PRECISE float result = quotient(1.0f, 1.0f + exponential(-max(steps, -80.0f)));
  return result;
}

GNO_INLINE bool detected(EffectParameters p, float power, float chance) {
  return chance < detectionProbability(power, p.threshold, p.softness);
}

// Drop-out as CARLA's dropoff_* (RayCastLidar.cpp of CARLA 0.9). A whole beam is lost with a fixed probability.
GNO_INLINE bool beamDropped(EffectParameters p, float chance) {
  return chance < p.dropRate;
}

// A return whose unit intensity is below the limit is lost with a probability that falls from dropAtZero to 0 at the
// limit.
GNO_INLINE bool returnDropped(EffectParameters p, float unit, float chance) {
  GNO_PRECISE float probability = p.dropAtZero - p.dropSlope * unit;
  return unit < p.dropLimit && chance < probability;
}

#ifdef __cplusplus
}  // namespace gnosphere::gpu
#endif
#endif
