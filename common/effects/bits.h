// SPDX-License-Identifier: Apache-2.0
// The effects that a pipeline contains: bits of its specialisation constant EFFECTS, in the order of effectNames().
#ifndef GNOSPHERE_EFFECTS_BITS_H
#define GNOSPHERE_EFFECTS_BITS_H

#include "../shared.h"

#ifdef __cplusplus
namespace gnosphere::gpu {
#endif

GNO_CONST uint kIntensity = 1u << 0;
GNO_CONST uint kDetection = 1u << 1;
GNO_CONST uint kDropOut = 1u << 2;
GNO_CONST uint kRangeNoise = 1u << 3;
GNO_CONST uint kAngleNoise = 1u << 4;
GNO_CONST uint kIntensityNoise = 1u << 5;
GNO_CONST uint kDivergence = 1u << 6;
GNO_CONST uint kReturns = 1u << 7;
GNO_CONST uint kTransmission = 1u << 8;
GNO_CONST uint kCutOuts = 1u << 9;
GNO_CONST uint kSensorMotion = 1u << 10;
GNO_CONST uint kObjectMotion = 1u << 11;
GNO_CONST uint kFog = 1u << 12;
GNO_CONST uint kRain = 1u << 13;
GNO_CONST uint kSnow = 1u << 14;
GNO_CONST uint kVolumes = 1u << 15;
GNO_CONST uint kRadialSpeed = 1u << 16;

// Not an effect of its own: set if angle noise deflects beams before they meet anything.
GNO_CONST uint kStrays = 1u << 31;

// Not an effect either: set if the hits of a beam are found by tracing the sub-rays of its footprint. Otherwise the
// beam is a single line, and its nearest hit counts.
GNO_CONST uint kFootprint = 1u << 30;

// Not an effect of its own: set if radial speeds have an error.
GNO_CONST uint kSpeedNoise = 1u << 29;

// Effects of a medium that is the same everywhere.
GNO_CONST uint kUniformMedia = kFog | kRain | kSnow;
// Effects of the medium between the sensor and the surfaces.
GNO_CONST uint kMediumEffects = kUniformMedia | kVolumes;

// With one of these effects a beam's result is more than the nearest hit of its axis.
GNO_CONST uint kFootprintEffects = kDivergence | kTransmission | kCutOuts | kStrays;
// With one of these effects the returns of each beam are computed from its echoes.
GNO_CONST uint kSignalEffects = kIntensity | kDetection | kDropOut | kRangeNoise | kAngleNoise | kIntensityNoise |
                                kFootprintEffects | kReturns | kMediumEffects | kSpeedNoise;
// Most surfaces that one sub-ray can hit.
GNO_CONST uint kMaxLayers = 4;

// Outputs of a scan beyond points, ranges and owners: bits of the specialisation constant FIELDS.
GNO_CONST uint kFieldSignal = 1;        // true range, width, label, cause
GNO_CONST uint kFieldSurface = 2;       // normal, incidence, material
GNO_CONST uint kFieldMotion = 4;        // velocity, radial speed
GNO_CONST uint kFieldBarycentrics = 8;  // position of the hit within its triangle
GNO_CONST uint kFieldIntensity = 16;
// No field has this bit, which is set if points and owners are stored, because the words of the beams do not tell them.
GNO_CONST uint kFieldPoints = 32;

// Fields for which stage effects computes the surface at the hit. The intensity effect needs the surface, too, for the
// angle of incidence and the material.
GNO_CONST uint kSurfaceFields = kFieldSurface | kFieldBarycentrics;

#ifdef __cplusplus
}  // namespace gnosphere::gpu
#endif
#endif
