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
// Most drops or flakes that are drawn for a beam. If none of them is strong enough, the beam has no echo of one.
GNO_CONST uint kMostParticles = 16;

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
// depth is that of a returning photon, whose probability falls as exp(-2 extinction depth). If this depth lies behind
// `far`, there is no echo, so what ends the medium changes no echo before it. The energy is `scatter`, the share of one
// pulse length at 1 m, times a gamma-distributed factor of shape 4 and mean 1 (speckle and patchiness).
GNO_INLINE Echo scatterEcho(EffectParameters p, float extinction, float scatter, float near, float far, uvec4 words,
                            uvec4 more) {
  Echo echo = noEcho();
  if (!(far > near) || !(extinction > 0.0f)) return echo;
  GNO_PRECISE float depth = quotient(-naturalLog(1.0f - uniform01(words.x)), 2.0f * extinction);
  GNO_PRECISE float range = near + depth;
  if (!(range < far)) return echo;
  echo.range = range;
  GNO_PRECISE float product = uniformAboveZero(more.x) * uniformAboveZero(more.y);
  GNO_PRECISE float other = uniformAboveZero(more.z) * uniformAboveZero(more.w);
  GNO_PRECISE float unevenness = -0.25f * (naturalLog(product) + naturalLog(other));
  GNO_PRECISE float energy = scatter * unevenness * focus(range);
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

// Returns entry i, 1..8, of a table.
GNO_INLINE float entryOf(vec4 near, vec4 far, uint i) {
  vec4 values = i > 4u ? far : near;
  uint j = (i - 1u) & 3u;
  return j == 0u ? values.x : j == 1u ? values.y : j == 2u ? values.z : values.w;
}

GNO_INLINE float countAt(Particles particles, uint i) {
  return i == 0u ? 0.0f : entryOf(particles.countsNear, particles.countsFar, i);
}

// Part i of a table of particles, between its ranges i - 1 and i. The expected number is an increasing rational
// function of the range there, with the numbers and the densities at both ends (Gregory and Delbourgo 1982, IMA Journal
// of Numerical Analysis, volume 2).
struct ParticlePart {
  float start, metres;   // m
  float before, count;   // particles before the start, and from there to the end
  float atStart, atEnd;  // densities, as multiples of count / metres
};

GNO_INLINE ParticlePart partOf(Particles particles, uint i) {
  ParticlePart part;
  part.start = rangeOf(particles, i - 1u);
  part.before = countAt(particles, i - 1u);
  GNO_PRECISE float metres = max(rangeOf(particles, i) - part.start, 1e-30f);
  GNO_PRECISE float count = max(countAt(particles, i) - part.before, 1e-30f);
  part.metres = metres;
  part.count = count;
  part.atStart = entryOf(particles.startsNear, particles.startsFar, i);
  part.atEnd = entryOf(particles.endsNear, particles.endsFar, i);
  return part;
}

// Returns the expected number of particles up to a range.
GNO_INLINE float countUpTo(Particles particles, float range) {
  uint i = 1u;
  for (uint k = 1u; k < kParticleRanges; ++k)
    if (rangeOf(particles, k) < range) i = k + 1u;
  ParticlePart part = partOf(particles, i);
  GNO_PRECISE float x = min(max(quotient(range - part.start, part.metres), 0.0f), 1.0f);
  GNO_PRECISE float bend = x * (1.0f - x);
  GNO_PRECISE float above = x * x + part.atStart * bend;
  GNO_PRECISE float below = 1.0f + (part.atStart + part.atEnd - 2.0f) * bend;
  GNO_PRECISE float result = part.before + part.count * quotient(above, below);
  return result;
}

// Returns the range up to which a number of particles is expected, which is less than that of the whole table.
GNO_INLINE float rangeWith(Particles particles, float count) {
  // Every entry is compared, because lanes that search end together anyway.
  uint i = 1u;
  for (uint k = 1u; k < kParticleRanges; ++k)
    if (countAt(particles, k) <= count) i = k + 1u;
  ParticlePart part = partOf(particles, i);
  GNO_PRECISE float share = quotient(count - part.before, part.count);
  GNO_PRECISE float bend = share * (part.atStart + part.atEnd - 2.0f);
  GNO_PRECISE float square = 1.0f - part.atStart + bend;
  GNO_PRECISE float linear = part.atStart - bend;
  GNO_PRECISE float root = squareRoot(max(linear * linear + 4.0f * square * share, 0.0f));
  GNO_PRECISE float x = min(quotient(2.0f * share, max(linear + root, 1e-30f)), 1.0f);
  GNO_PRECISE float result = part.start + part.metres * x;
  return result;
}

// Product of the horizontal and vertical diameter of the beam at a range, in m^2.
GNO_INLINE float beamArea(EffectParameters p, float range) {
  GNO_PRECISE float horizontal = kApertureDiameter + p.spreadHorizontal * range;
  GNO_PRECISE float vertical = kApertureDiameter + p.spreadVertical * range;
  GNO_PRECISE float area = horizontal * vertical;
  return area;
}

// Drops and flakes that are strong enough to be detected in uniform air of `p.extinction` are a Poisson process along
// the beam, which begins at `p.rangeMin`. So the expected number from there to the first one, and from one to the next,
// is exponentially distributed. Returns the expected number before the least range.
GNO_INLINE float countBefore(EffectParameters p, Particles particles) {
  return OWN_RANGES && p.rangeMin > particles.firstRange ? countUpTo(particles, p.rangeMin) : 0.0f;
}

// Returns the expected number up to the next particle, from that up to the one before or up to the least range.
GNO_INLINE float countUpToNext(float count, uvec4 words) {
  GNO_PRECISE float result = count - naturalLog(uniformAboveZero(words.x));
  return result;
}

// The echo of the drop or flake up to which `count` particles are expected. Its diameter beyond the least detectable
// one is exponentially distributed, too (Marshall and Palmer 1948); it determines the energy.
GNO_INLINE Echo particleEcho(EffectParameters p, Particles particles, float count, float far, uvec4 words) {
  Echo echo = noEcho();
  if (!(count < particles.countsFar.w)) return echo;
  GNO_PRECISE float range = max(rangeWith(particles, count), p.rangeMin);
  if (!(range < far)) return echo;

  // Power = reflectance * focus * (diameter / beam)^2 / range^2 * exp(-2 depth). The root of this focus is range /
  // kFocusRange or 1, so the range over the root is the larger one of range and kFocusRange.
  GNO_PRECISE float least = particles.least * max(range, kFocusRange) * exponential(p.extinction * range);
  GNO_PRECISE float larger = -naturalLog(uniformAboveZero(words.y)) * particles.excess;
  GNO_PRECISE float diameter = min(least + larger * inverseRoot(beamArea(p, range)), 1.0f);  // as a share of the beam's
  echo.range = range;
  GNO_PRECISE float energy = particles.reflectance * focus(range) * diameter * diameter;
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
