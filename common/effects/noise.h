// SPDX-License-Identifier: Apache-2.0
// Measurement errors, normally distributed with mean 0.
#ifndef GNOSPHERE_EFFECTS_NOISE_H
#define GNOSPHERE_EFFECTS_NOISE_H

#include "random.h"

#ifdef __cplusplus
namespace gnosphere::gpu {
#endif

// Angle errors are cut off at this many sigmas, because beams must stay within the bounds by which triangles are
// found.
GNO_CONST float kAngleCutOff = 4.0f;

// Adds the bias and an error whose sigma grows with the range, with its square, and as the power falls, then rounds to
// whole steps. The result is never below 0.
GNO_INLINE float noisyRange(EffectParameters p, float range, float power, float gaussian) {
  GNO_PRECISE float sigma = p.rangeSigma + p.rangeSigmaPerMetre * range + p.rangeSigmaPerSquareMetre * range * range;
  if (p.rangeSigmaAtThreshold > 0.0f) {
    GNO_PRECISE float weak = p.rangeSigmaAtThreshold * quotient(p.threshold, max(power, p.threshold));
    sigma = squareRoot(sigma * sigma + weak * weak);
  }
  GNO_PRECISE float result = range + p.rangeBias + sigma * gaussian;
  if (p.rangeStep > 0.0f) result = floor(quotient(result, p.rangeStep) + 0.5f) * p.rangeStep;
  return max(result, 0.0f);
}

GNO_INLINE float noisyIntensity(EffectParameters p, float unit, float gaussian) {
  GNO_PRECISE float result = unit + p.intensitySigma * gaussian;
  return max(result, 0.0f);
}

GNO_INLINE float noisySpeed(EffectParameters p, float speed, float gaussian) {
  GNO_PRECISE float result = speed + p.speedSigma * gaussian;
  return result;
}

// Angle error of the beam with index `beam`: azimuth (x) and elevation (y) in radians.
GNO_INLINE vec2 angleError(EffectParameters p, uint beam) {
  vec4 normal = gaussians(draw(p, beam, 0u, kAngleNoise));
  GNO_PRECISE vec2 result;
  result.x = p.azimuthSigma * max(-kAngleCutOff, min(normal.x, kAngleCutOff));
  result.y = p.elevationSigma * max(-kAngleCutOff, min(normal.y, kAngleCutOff));
  return result;
}

// Rotates a unit vector about the vertical axis by error.x, and in elevation by error.y, both in radians.
GNO_INLINE vec3 astray(vec3 direction, vec2 error) {
  GNO_PRECISE float horizontal = squareRoot(direction.x * direction.x + direction.y * direction.y);
  GNO_PRECISE float cosine = 1.0f, sine = 0.0f;  // of the azimuth; at a pole any azimuth will do
  if (horizontal > 1e-12f) {
    cosine = quotient(direction.x, horizontal);
    sine = quotient(direction.y, horizontal);
  }
  vec2 azimuth = cosSinOfTurn(error.x * 0.159154943f);
  vec2 elevation = cosSinOfTurn(error.y * 0.159154943f);
  GNO_PRECISE float length_ = horizontal * elevation.x - direction.z * elevation.y;
  GNO_PRECISE vec3 result;
  result.x = length_ * (cosine * azimuth.x - sine * azimuth.y);
  result.y = length_ * (sine * azimuth.x + cosine * azimuth.y);
  result.z = direction.z * elevation.x + horizontal * elevation.y;
  return result;
}

#ifdef __cplusplus
}  // namespace gnosphere::gpu
#endif
#endif
