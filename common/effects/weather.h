// SPDX-License-Identifier: Apache-2.0
// Attenuation and backscatter by fog, rain, snow and dust. src/effects/particles.cpp cites the sources of the
// coefficients.
#ifndef GNOSPHERE_EFFECTS_WEATHER_H
#define GNOSPHERE_EFFECTS_WEATHER_H

#include "random.h"

// Whether beams have range windows of their own; an including kernel that knows it defines this as a constant.
#ifndef OWN_RANGES
#define OWN_RANGES true
#endif

#ifdef __cplusplus
namespace gnosphere::gpu {
#endif

// The range of an echo that does not exist; it is farther than any real range.
GNO_CONST float kNever = 1e30f;
// Below this range, in metres, the receiver sees its beam out of focus or from the side, and gets only (range /
// this)^2 of the light that the medium scatters back. Data sheets do not state it; 1 m (Rasshofer et al. 2011) to 10 m
// and more are plausible.
GNO_CONST float kFocusRange = 5.0f;
// Diameter of the beam at the sensor's aperture, in metres.
GNO_CONST float kApertureDiameter = 0.01f;
// Number of ranges in a table of particle counts.
GNO_CONST uint kParticleRanges = 8;

GNO_INLINE float focus(float range) {
  GNO_PRECISE float share = range * (1.0f / kFocusRange);
  GNO_PRECISE float result = share * share;
  return min(result, 1.0f);
}

GNO_INLINE Echo noEcho() {
  Echo echo;
  echo.range = kNever;
  echo.energy = 0.0f;
  echo.width = 0.0f;
  echo.light = 1.0f;
  echo.index = kNone;
  return echo;
}

// The echo of a medium of given `extinction` between two ranges, by the lidar equation for single scattering. Its
// depth is that of a returning photon, whose probability falls as exp(-2 extinction depth). Its energy is `scatter`,
// the share of one pulse length at 1 m, times a gamma-distributed factor of shape 4 and mean 1 (speckle and
// patchiness).
GNO_INLINE Echo scatterEcho(EffectParameters p, float extinction, float scatter, float near, float far, uvec4 words,
                            uvec4 more) {
  Echo echo = noEcho();
  if (!(far > near) || !(extinction > 0.0f)) return echo;
  GNO_PRECISE float passed = exponential(-2.0f * extinction * (far - near));
  GNO_PRECISE float left = 1.0f - uniform01(words.x) * (1.0f - passed);
  GNO_PRECISE float depth = quotient(-naturalLog(left), 2.0f * extinction);
  echo.range = min(near + depth, far);
  GNO_PRECISE float product = uniformAboveZero(more.x) * uniformAboveZero(more.y);
  GNO_PRECISE float other = uniformAboveZero(more.z) * uniformAboveZero(more.w);
  GNO_PRECISE float unevenness = -0.25f * (naturalLog(product) + naturalLog(other));
  GNO_PRECISE float energy = scatter * unevenness * focus(echo.range);
  echo.energy = energy;
  echo.width = p.pulseWidth;
  return echo;
}

// Range of entry i of a table of particle counts; the entries are closer together at short range.
GNO_INLINE float rangeOf(Particles particles, uint i) {
  GNO_PRECISE float share = float(i) * (1.0f / float(kParticleRanges));
  GNO_PRECISE float result = particles.firstRange + (particles.lastRange - particles.firstRange) * share * share;
  return result;
}

GNO_INLINE float countAt(Particles particles, uint i) {
  vec4 counts = i > 4u ? particles.countsFar : particles.countsNear;
  uint j = (i - 1u) & 3u;
  return i == 0u ? 0.0f : j == 0u ? counts.x : j == 1u ? counts.y : j == 2u ? counts.z : counts.w;
}

// Returns the expected number of particles up to a range, by linear interpolation.
GNO_INLINE float countUpTo(Particles particles, float range) {
  GNO_PRECISE float count = 0.0f;
  for (uint k = 1u; k <= kParticleRanges; ++k) {
    GNO_PRECISE float start = rangeOf(particles, k - 1u);
    GNO_PRECISE float before = countAt(particles, k - 1u);
    GNO_PRECISE float after = countAt(particles, k);
    GNO_PRECISE float share = quotient(range - start, max(rangeOf(particles, k) - start, 1e-30f));
    if (range > start) count = before + (after - before) * min(share, 1.0f);
  }
  return count;
}

// Geometric mean of the horizontal and vertical diameter of the beam at a range, in metres.
GNO_INLINE float beamDiameter(EffectParameters p, float range) {
  GNO_PRECISE float horizontal = kApertureDiameter + p.spreadHorizontal * range;
  GNO_PRECISE float vertical = kApertureDiameter + p.spreadVertical * range;
  GNO_PRECISE float area = horizontal * vertical;
  return squareRoot(area);
}

// The echo of the nearest drop or flake from `p.rangeMin` on that is strong enough to be detected in uniform air of
// `p.extinction`. Such particles are a Poisson process along the beam, so the expected number up to the first one is
// exponentially distributed. Their diameter beyond the least detectable one is exponentially distributed as well
// (Marshall and Palmer 1948); it determines the energy.
GNO_INLINE Echo particleEcho(EffectParameters p, Particles particles, float far, uvec4 words) {
  Echo echo = noEcho();
  GNO_PRECISE float count = -naturalLog(uniformAboveZero(words.x));
  if (OWN_RANGES && p.rangeMin > particles.firstRange) count += countUpTo(particles, p.rangeMin);
  if (!(count < particles.countsFar.w)) return echo;
  // The particle lies between entries i - 1 and i. Every entry is compared, because lanes that search end together
  // anyway.
  uint i = 1u;
  GNO_PRECISE float before = 0.0f;
  GNO_PRECISE float after = countAt(particles, 1u);
  for (uint k = 1u; k < kParticleRanges; ++k)
    if (countAt(particles, k) <= count) {
      i = k + 1u;
      before = countAt(particles, k);
      after = countAt(particles, k + 1u);
    }
  GNO_PRECISE float share = quotient(count - before, max(after - before, 1e-30f));
  GNO_PRECISE float start = rangeOf(particles, i - 1u);
  GNO_PRECISE float range = max(start + (rangeOf(particles, i) - start) * min(share, 1.0f), p.rangeMin);
  if (!(range < far)) return echo;

  // Power = reflectance * focus * (diameter / beam)^2 / range^2 * exp(-2 depth).
  GNO_PRECISE float strength = particles.reflectance * focus(range);
  GNO_PRECISE float beam = beamDiameter(p, range);
  GNO_PRECISE float least = range * exponential(p.extinction * range) * squareRoot(quotient(p.threshold, strength));
  GNO_PRECISE float larger = quotient(-naturalLog(uniformAboveZero(words.y)), particles.slope);
  GNO_PRECISE float diameter = min(least + quotient(larger, beam), 1.0f);  // as a share of the beam's
  echo.range = range;
  GNO_PRECISE float energy = strength * diameter * diameter;
  echo.energy = energy;
  echo.width = p.pulseWidth;
  return echo;
}

// The part of a beam from the sensor's origin that is within a box: from x to y metres; y <= x if it misses the box.
GNO_INLINE vec2 withinBox(VolumeBox box, vec3 direction, float far) {
  vec2 span;
  span.x = 0.0f;
  span.y = far;
  for (uint axis = 0u; axis < 3u; ++axis) {
    vec4 row = axis == 0u ? box.row0 : axis == 1u ? box.row1 : box.row2;
    GNO_PRECISE float speed = row.x * direction.x + row.y * direction.y + row.z * direction.z;
    GNO_PRECISE float slow = speed < 0.0f ? min(speed, -1e-20f) : max(speed, 1e-20f);
    GNO_PRECISE float low = quotient(-1.0f - row.w, slow);
    GNO_PRECISE float high = quotient(1.0f - row.w, slow);
    span.x = max(span.x, min(low, high));
    span.y = min(span.y, max(low, high));
  }
  return span;
}

#ifdef __cplusplus
}  // namespace gnosphere::gpu
#endif
#endif
