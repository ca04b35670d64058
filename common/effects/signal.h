// SPDX-License-Identifier: Apache-2.0
// Turns the echoes of one beam into its returns: medium, material, detection and drop-out, choice of returns, noise.
//
// The including file must define EFFECTS, the planned effects as bits of bits.h; RETURNS, the number of returns per
// beam; MOST_ECHOES, the largest number of echoes from surfaces; and these functions:
//   Echo loadEcho(uint k)                  k < echoCount, in order of range, none farther than p.rangeMax
//   void storeReturn(uint j, Return value) is called once for each j < RETURNS
//   VolumeBox loadVolume(uint i)           i < p.volumeCount
//   bool isDead(uint beam)                 whether DropOut::deadBeams has the beam; called only if p.deadBeams > 0
// In C++ this file is included within a struct that has these as members (tests/effects/beam_signal.hpp).
#include "detection.h"
#include "intensity.h"
#include "noise.h"
#include "parameters.h"
#include "random.h"
#include "returns.h"
#include "weather.h"

#define PLANNED(bits) ((EFFECTS & (bits)) != 0u)

// If a medium attenuates the light, returns must exceed the threshold even if `detection` is not planned.
#define HAS_THRESHOLD PLANNED(kDetection | kMediumEffects)

// Optical depth of the medium up to a range.
GNO_INLINE float depthOf(EffectParameters p, vec3 direction, float range) {
  GNO_PRECISE float depth = 0.0f;
  if (PLANNED(kUniformMedia)) depth = p.extinction * range;
  if (PLANNED(kVolumes))
    for (uint i = 0u; i < p.volumeCount; ++i) {
      VolumeBox box = loadVolume(i);
      vec2 span = withinBox(box, direction, range);
      depth = depth + box.extinction * max(span.y - span.x, 0.0f);
    }
  return depth;
}

// Returns the share of the beam's light that surfaces nearer than `range` leave. `count` is the number of echoes from
// surfaces.
GNO_INLINE float lightAt(float range, uint count) {
  float light = 1.0f;
  if (MOST_ECHOES > 1u)
    for (uint k = 0u; k < MOST_ECHOES; ++k)
      if (k < count) {
        Echo surface = loadEcho(k);
        if (surface.range <= range) light = surface.light;
      }
  return light;
}

// Leaves an echo of the medium the share of its energy that surfaces leave, and returns its power at the receiver.
GNO_INLINE float weaken(EffectParameters p, vec3 direction, uint count, GNO_INOUT(Echo) echo) {
  if (echo.range >= kNever) return 0.0f;
  GNO_PRECISE float energy = echo.energy * lightAt(echo.range, count);
  echo.energy = energy;
  return received(echo.energy, echo.range, depthOf(p, direction, echo.range));
}

// Replaces `echo` and its power by a further echo of the medium if that one is stronger. Returns true if it is.
GNO_INLINE bool keepStronger(Echo further, float furtherPower, GNO_INOUT(Echo) echo, GNO_INOUT(float) power) {
  if (further.range >= kNever || furtherPower <= power) return false;
  echo = further;
  power = furtherPower;
  return true;
}

// Replaces `echo` and its power by those of the nearest drop or flake that is detected, if that one is stronger. The
// table of particles has those that are strong enough in clear air, so behind glass, beside an edge and in dust the
// first one that is strong enough there counts.
GNO_INLINE bool keepParticle(EffectParameters p, uint beam, vec3 direction, Particles particles, uint effect, float far,
                             uint count, GNO_INOUT(Echo) echo, GNO_INOUT(float) power) {
  bool weakens = PLANNED(kVolumes) || MOST_ECHOES > 1u, found = false;
  Echo further = noEcho();
  float furtherPower = 0.0f, number = countBefore(p, particles);
  for (uint k = 0u; k < (weakens ? kMostParticles : 1u) && !found; ++k) {
    uvec4 words = draw(p, beam, k, effect);
    number = countUpToNext(number, words);
    further = particleEcho(p, particles, number, far, words);
    furtherPower = weaken(p, direction, count, further);
    found = !weakens || further.range >= kNever || detectionProbability(furtherPower, p.threshold, 0.0f) > 0.0f;
  }
  return found && keepStronger(further, furtherPower, echo, power);
}

// Returns the medium's strongest echo nearer than `far`, or one of range kNever. The beam has `count` echoes from
// surfaces. `ofParticle` becomes true if the echo is that of a single drop or flake.
GNO_INLINE Echo mediumEcho(EffectParameters p, uint beam, vec3 direction, float far, uint count,
                           GNO_OUT(bool) ofParticle) {
  Echo echo = noEcho();
  float power = 0.0f;
  ofParticle = false;
  if (PLANNED(kFog)) {
    echo = scatterEcho(p, p.fogExtinction, p.fogScatter, p.rangeMin, far, draw(p, beam, 0u, kFog),
                       draw(p, beam, 1u, kFog));
    power = weaken(p, direction, count, echo);
  }
  if (PLANNED(kRain) && keepParticle(p, beam, direction, p.rain, kRain, far, count, echo, power)) ofParticle = true;
  if (PLANNED(kSnow) && keepParticle(p, beam, direction, p.snow, kSnow, far, count, echo, power)) ofParticle = true;
  if (PLANNED(kVolumes))
    for (uint i = 0u; i < p.volumeCount; ++i) {
      VolumeBox box = loadVolume(i);
      vec2 span = withinBox(box, direction, far);
      Echo further = scatterEcho(p, box.extinction, box.scatter, max(span.x, p.rangeMin), span.y,
                                 draw(p, beam, 2u * i, kVolumes), draw(p, beam, 2u * i + 1u, kVolumes));
      float furtherPower = weaken(p, direction, count, further);
      if (keepStronger(further, furtherPower, echo, power)) ofParticle = false;
    }
  return echo;
}

// Echo `number` of all echoes in order of range: those of the surfaces, and the medium's echo as number `scatterAt`.
GNO_INLINE Echo echoAt(uint number, Echo scatter, uint scatterAt) {
  if (PLANNED(kMediumEffects) && number == scatterAt) return scatter;
  return loadEcho(number < scatterAt ? number : number - 1u);
}

// The number by which an echo draws random numbers. The medium's echo does not shift the numbers of the surfaces'
// echoes.
GNO_INLINE uint drawOf(uint number, uint scatterAt) {
  return number == scatterAt ? kScatterDraw : number < scatterAt ? number : number - 1u;
}

GNO_INLINE Return noReturn() {
  Return none;
  none.range = none.trueRange = none.intensity = none.width = notANumber();
  none.label = kLabelNone;
  none.echo = kNone;
  none.number = none.count = none.cause = 0u;
  return none;
}

// Computes the sensor's measurements of an echo that becomes a return.
GNO_INLINE Return measured(EffectParameters p, uint beam, vec3 direction, Echo echo, uint drawNumber) {
  Return result = noReturn();
  result.range = result.trueRange = echo.range;
  result.width = echo.width;
  result.label = echo.index == kNone ? kLabelScatter : kLabelSolid;
  result.echo = echo.index;
  if (PLANNED(kRangeNoise)) {
    float power = received(echo.energy, echo.range, depthOf(p, direction, echo.range));
    result.range = noisyRange(p, echo.range, power, gaussians(draw(p, beam, drawNumber, kRangeNoise)).x);
  }
  if (PLANNED(kIntensity)) {
    float unit = unitIntensity(p, echo.energy, echo.range, depthOf(p, direction, echo.range));
    if (PLANNED(kIntensityNoise))
      unit = noisyIntensity(p, unit, gaussians(draw(p, beam, drawNumber, kIntensityNoise)).x);
    result.intensity = scaled(p, unit, echo.range);
  }
  return result;
}

// The number that decides about an echo where detection is soft.
GNO_INLINE float detectionChance(EffectParameters p, uint beam, uint number) {
  return p.softness > 0.0f ? uniform01(draw(p, beam, number, kDetection).x) : 0.0f;
}

// True if an echo of a surface is detected by itself, also if it is dropped then.
GNO_INLINE bool isDetected(EffectParameters p, uint beam, vec3 direction, Echo echo, uint number) {
  if (p.hidesNear > 0u && echo.range < p.rangeMin) return false;
  float power = received(echo.energy, echo.range, depthOf(p, direction, echo.range));
  return detected(p, power, detectionChance(p, beam, number));
}

// True if an echo reaches the receiver and is not dropped; if it is not, `cause` becomes the reason. `number` is that
// of the echo's random draws, and `soft` tells whether detection may be soft: it is a step for the echo of a particle,
// because the table of particles has no weaker ones.
GNO_INLINE bool isReturned(EffectParameters p, uint beam, Echo echo, bool soft, uint number, float depth, float power,
                           GNO_INOUT(uint) cause) {
  if (!soft) p.softness = 0.0f;
  if (p.hidesNear > 0u && echo.range < p.rangeMin) {
    if (cause == kCauseNoSurface) cause = kCauseTooNear;
    return false;
  }
  if (HAS_THRESHOLD) {
    float chance = detectionChance(p, beam, number);
    if (!detected(p, power, chance)) {
      if (number == kScatterDraw) return false;
      bool inClearAir = PLANNED(kMediumEffects) && detected(p, received(echo.energy, echo.range, 0.0f), chance);
      if (inClearAir && (cause == kCauseNoSurface || cause == kCauseWeak)) cause = kCauseAttenuated;
      if (!inClearAir && cause == kCauseNoSurface) cause = kCauseWeak;
      return false;
    }
  }
  if (PLANNED(kDropOut) && p.dropAtZero > 0.0f) {
    float unit = unitIntensity(p, echo.energy, echo.range, depth);
    if (returnDropped(p, unit, uniform01(draw(p, beam, number + 1u, kDropOut).x))) {
      cause = kCauseDroppedOut;
      return false;
    }
  }
  return true;
}

// Most echoes of a beam, with that of the medium. Loops over them have this constant bound, so that compilers remove
// the loop where there is one.
#define MOST_OF_ALL (MOST_ECHOES + (PLANNED(kMediumEffects) ? 1u : 0u))

// Stores the returns of one beam. Sets their number and returns the beam's Cause. `direction` is the beam's unit
// vector in the sensor's frame.
GNO_INLINE uint signalsOf(EffectParameters p, uint beam, vec3 direction, uint echoCount, GNO_OUT(uint) returnCount) {
  uint cause = kCauseNoSurface;
  bool works = true;
  if (PLANNED(kDropOut)) {
    if (p.deadBeams > 0u && isDead(beam)) {
      works = false;
      cause = kCauseDead;
    } else if (beamDropped(p, uniform01(draw(p, beam, 0u, kDropOut).x))) {
      works = false;
      cause = echoCount > 0u || PLANNED(kMediumEffects) ? kCauseDroppedOut : kCauseNoSurface;
    }
  }
  if (p.rangeMax < 0.0f) {  // the window of a masked beam is empty
    works = false;
    cause = kCauseDead;
  }

  // The medium's echo counts if light comes to it and it is separate from all surfaces that are detected by themselves;
  // a closer one is part of the surface's echo, to which it adds next to nothing. Its place is by range.
  uint count = works ? echoCount : 0u;
  uint scatterAt = kNone;
  Echo scatter = noEcho();
  bool ofParticle = false;
  if (PLANNED(kMediumEffects) && works) {
    GNO_PRECISE float far = p.rangeMax;
    if (count > 0u) {
      Echo last = loadEcho(count - 1u);
      if (!(last.light > 0.0f)) far = last.range;
    }
    scatter = mediumEcho(p, beam, direction, far, count, ofParticle);
    if (scatter.range < kNever) {
      bool separate = true;
      scatterAt = 0u;
      for (uint k = 0u; k < MOST_ECHOES; ++k)
        if (k < count) {
          Echo surface = loadEcho(k);
          GNO_PRECISE float beyond = scatter.range - surface.range;
          if (max(beyond, -beyond) <= p.separation && isDetected(p, beam, direction, surface, k)) separate = false;
          if (beyond >= 0.0f) ++scatterAt;
        }
      if (separate) {
        ++count;
      } else {
        scatter = noEcho();
        scatterAt = kNone;
      }
    }
  }

  Choice choice = noChoice();
  for (uint k = 0u; k < MOST_OF_ALL; ++k)
    if (k < count) {
      Echo echo = echoAt(k, scatter, scatterAt);
      float depth = depthOf(p, direction, echo.range);
      float power = received(echo.energy, echo.range, depth);
      bool soft = !(ofParticle && k == scatterAt);
      if (isReturned(p, beam, echo, soft, drawOf(k, scatterAt), depth, power, cause)) consider(choice, k, power);
    }

  uint mode = kModeStrongest;
  if (PLANNED(kReturns)) mode = p.returnsMode;
  uint wanted = chosen(choice, mode);
  returnCount = 0u;
  for (uint k = 0u; k < MOST_OF_ALL; ++k) returnCount += wanted >> k & 1u;
  returnCount = min(returnCount, RETURNS);
  if (choice.detected != 0u) cause = returnCount > 0u ? kCauseReturned : kCauseNotChosen;
  for (uint j = 0u; j < RETURNS; ++j) {
    Return value = noReturn();
    if (j < returnCount) {
      uint k = 0u;
      for (uint i = MOST_OF_ALL; i > 0u; --i)
        if ((wanted >> (i - 1u) & 1u) != 0u) k = i - 1u;
      wanted ^= 1u << k;
      value = measured(p, beam, direction, echoAt(k, scatter, scatterAt), drawOf(k, scatterAt));
      value.number = j + 1u;
      value.count = returnCount;
    }
    if (j == 0u) value.cause = cause;
    storeReturn(j, value);
  }
  return cause;
}
