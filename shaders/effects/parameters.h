// SPDX-License-Identifier: Apache-2.0
// What the formulas of the effects read and write: parameters of a scan, materials, volumes, echoes and returns.
// The rules of shared.h hold for what goes into buffers.
#ifndef GNOSPHERE_EFFECTS_PARAMETERS_H
#define GNOSPHERE_EFFECTS_PARAMETERS_H

#include "arithmetic.h"
#include "bits.h"

#ifdef __cplusplus
namespace gnosphere::gpu {
#endif

// As the enums of effects.hpp and scan.hpp.
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

GNO_CONST uint kCauseReturned = 0;
GNO_CONST uint kCauseNoSurface = 1;
GNO_CONST uint kCauseWeak = 2;
GNO_CONST uint kCauseAttenuated = 3;
GNO_CONST uint kCauseDroppedOut = 4;
GNO_CONST uint kCauseDead = 5;

GNO_CONST uint kLabelNone = 0;
GNO_CONST uint kLabelSolid = 1;
GNO_CONST uint kLabelScatter = 2;

// Echoes of one beam; what is farther is lost. A sensor reports 5 at most, and a sixth tells which are the strongest.
GNO_CONST uint kMaxEchoes = 6;

// Drops or flakes: how many a beam meets that are strong enough to be detected, and how large they are.
struct Particles {
  vec4 countsNear;  // expected number up to range rangeOf(1), (2), (3), (4): see weather.h
  vec4 countsFar;   // (5)..(8)
  float firstRange, lastRange;
  float slope;        // 1/m: the share larger than D falls as exp(-slope * D)
  float reflectance;  // of one, as a Lambertian disc of its diameter
};

// Everything that the effects of one sensor's scan need. Metres, radians, 1/m; powers are relative to a Lambertian
// target of reflectance 1, square to the beam, at 1 m.
struct EffectParameters {
  Particles rain, snow;
  uint seedLow, seedHigh, sensor, frame;
  uint subRays, volumeCount, deadBeams;
  uint returnsMode, returnsPerBeam, intensityModel, intensityScale;
  uint angleNoiseAt;
  float attenuation;  // of CARLA's intensity
  float threshold;    // least relative power that is detected
  float softness;
  float dropRate, dropLimit, dropSlope, dropAtZero;  // CARLA's; below the limit dropAtZero - dropSlope * intensity
  float rangeBias, rangeSigma, rangeSigmaPerMetre, rangeStep;
  float azimuthSigma, elevationSigma, intensitySigma;
  float extinction;  // of fog, rain and snow together
  float fogExtinction, fogScatter;
  float separation, pulseWidth;
  float tanHorizontal, tanVertical;        // of half the footprint's angles, as the sub-rays have it; 0: a line
  float spreadHorizontal, spreadVertical;  // full angles of the beam that drops and flakes are in
  float rangeMin, rangeMax;
  float padding0, padding1, padding2;
};

// Material and surface: what a table of them holds per material.
struct Optics4 {
  vec4 reflection;  // reflectance, gloss, roughness, retro
  vec3 passage;     // transmission, alpha cut-off, factor of the texture's alpha
  uint alphaImage;  // kNone: there is none
};

// Dust or spray: box frame = rows * (sensor frame, 1), and the box is -1..1 there.
struct VolumeBox {
  vec4 row0, row1, row2;
  float extinction, scatter;  // 1/m; relative power that its pulse length throws back at 1 m
  float padding0, padding1;
};

// What comes back from one depth of a beam, before the medium has taken its part.
struct Echo {
  float range;
  float energy;  // sum over sub-rays of weight * reflected * transmitted shares; the power is that over range^2
  float width;   // m
  float cosIncidence;
  uint index;  // whatever the includer knows it by; kNone: the medium
};

struct Return {
  float range;      // NaN: there is none
  float trueRange;  // without noise
  float intensity;
  float width;
  uint label;
  uint echo;    // Echo::index; kNone for the medium and for none
  uint number;  // 1 for the first of its beam, 0 for none
  uint count;   // of its beam
};

#ifdef __cplusplus
static_assert(sizeof(Particles) == 48 && sizeof(EffectParameters) == 256 && sizeof(Optics4) == 32 &&
              sizeof(VolumeBox) == 64);
}  // namespace gnosphere::gpu
#endif
#endif
