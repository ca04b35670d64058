// SPDX-License-Identifier: Apache-2.0
// Inputs and outputs of the formulas of the effects: parameters of a scan, materials, volumes, echoes and returns. The
// layout rules of types.h apply to structs that are stored in buffers.
#ifndef GNOSPHERE_EFFECTS_PARAMETERS_H
#define GNOSPHERE_EFFECTS_PARAMETERS_H

#include "arithmetic.h"
#include "bits.h"

#ifdef __cplusplus
namespace gnosphere::gpu {
#endif

// These values match the enums of effects.hpp and scan.hpp.
GNO_CONST uint kModelPhysical = 0;
GNO_CONST uint kModelCarla = 1;
GNO_CONST uint kScaleRaw = 0;
GNO_CONST uint kScaleUnit = 1;
GNO_CONST uint kScaleByte = 2;
GNO_CONST uint kAngleAtBeam = 0;
GNO_CONST uint kAngleAtPoint = 1;

GNO_CONST uint kModeFirst = 0;
GNO_CONST uint kModeSecond = 1;
GNO_CONST uint kModeLast = 2;
GNO_CONST uint kModeStrongest = 3;
GNO_CONST uint kModeSecondStrongest = 4;
GNO_CONST uint kModeFirstSecond = 5;
GNO_CONST uint kModeFirstLast = 6;
GNO_CONST uint kModeFirstStrongest = 7;
GNO_CONST uint kModeLastStrongest = 8;
GNO_CONST uint kModeStrongestSecondStrongest = 9;
GNO_CONST uint kModeAll = 10;
GNO_CONST uint kModeDual = 11;

GNO_CONST uint kCauseReturned = 0;
GNO_CONST uint kCauseNoSurface = 1;
GNO_CONST uint kCauseWeak = 2;
GNO_CONST uint kCauseAttenuated = 3;
GNO_CONST uint kCauseDroppedOut = 4;
GNO_CONST uint kCauseDead = 5;
GNO_CONST uint kCauseTooNear = 6;
GNO_CONST uint kCauseNotChosen = 7;

GNO_CONST uint kLabelNone = 0;
GNO_CONST uint kLabelSolid = 1;
GNO_CONST uint kLabelScatter = 2;

// A beam with more echoes than these keeps the nearest, the farthest, and the strongest ones between them. The smaller
// number is enough for beams with few returns, as all but those of surveys have, and costs less memory.
GNO_CONST uint kFewReturns = 3;
GNO_CONST uint kFewEchoes = 6;
GNO_CONST uint kMaxEchoes = 16;

// Returns how many echoes a beam keeps that reports so many returns.
GNO_INLINE uint keptEchoes(uint returns) {
  return returns <= kFewReturns ? kFewEchoes : kMaxEchoes;
}

// Rain drops or snow flakes: how many strong enough to be detected a beam meets, and how large they are.
struct Particles {
  vec4 countsNear;             // expected number up to range rangeOf(1), (2), (3), (4): see weather.h
  vec4 countsFar;              // (5)..(8)
  vec4 startsNear, startsFar;  // density at the start of part 1, 2..8 of the table, as a multiple of the part's mean
  vec4 endsNear, endsFar;      // at its end
  float firstRange, lastRange;
  float excess;       // m: mean of the diameters beyond the least detectable one, whose distribution is exponential
  float reflectance;  // of a particle, as a Lambertian disc of its diameter
  float least;        // least detectable diameter at 1 m in clear air in focus, as a share of the beam's
  float padding0, padding1, padding2;
};

// All parameters of the effects for one sensor's scan. Units are metres, radians and 1/m; powers are relative to a
// Lambertian target of reflectance 1, square to the beam, at 1 m.
struct EffectParameters {
  Particles rain, snow;
  uint seedLow, seedHigh, sensor, frame;
  uint volumeCount, deadBeams;
  uint returnsMode, returnsPerBeam, intensityModel, intensityScale;
  uint angleNoiseAt;
  float attenuation;  // of CARLA's intensity
  float threshold;    // least relative power that is detected
  float softness;
  float dropRate, dropLimit, dropSlope, dropAtZero;  // as in CARLA; below the limit dropAtZero - dropSlope * intensity
  float rangeBias, rangeSigma, rangeSigmaPerMetre, rangeStep;
  float azimuthSigma, elevationSigma, intensitySigma;
  float extinction;  // of fog, rain and snow together
  float fogExtinction, fogScatter;
  float separation, pulseWidth;
  float cellHorizontal, cellVertical;      // tangents: half axes of the part of the footprint that a sub-ray stands for
  float spreadHorizontal, spreadVertical;  // full angles of the beam that meets drops and flakes
  float rangeMin, rangeMax;
  uint hidesNear;  // 1 if an echo nearer than rangeMin ends the beam
  float speedSigma, rangeSigmaPerSquareMetre;
  float rangeSigmaAtThreshold;
};

// Optical properties of one material.
struct Optics4 {
  vec4 reflection;  // reflectance, gloss, roughness, retro
  vec3 passage;     // transmission, alpha cut-off, factor of the texture's alpha
  uint alphaImage;  // kNone: the material has none
};

// A box of dust or spray: box frame = rows * (sensor frame, 1), and the box spans -1..1 in its frame.
struct VolumeBox {
  vec4 row0, row1, row2;
  float extinction, scatter;  // 1/m; relative power that one pulse length scatters back at 1 m
  float padding0, padding1;
};

// The light returned from one depth of a beam, before attenuation by the medium.
struct Echo {
  float range;
  float energy;  // sum over sub-rays of weight * reflected * transmitted shares; divided by range^2 it is the power
  float width;   // m
  float light;   // share of the beam's light that goes on behind it; known only if a medium is planned
  uint index;    // an index chosen by the including file; kNone: the medium
};

struct Return {
  float range;      // NaN: no return
  float trueRange;  // without noise
  float intensity;
  float width;
  uint label;
  uint echo;    // Echo::index; kNone for the medium and for no return
  uint number;  // 1 for the first return of its beam, 0 for no return
  uint count;   // number of returns of its beam
  uint cause;   // of its beam, if it is the beam's first entry
};

#ifdef __cplusplus
static_assert(sizeof(Particles) == 128 && sizeof(EffectParameters) == 416 && sizeof(Optics4) == 32 &&
              sizeof(VolumeBox) == 64);
}  // namespace gnosphere::gpu
#endif
#endif
