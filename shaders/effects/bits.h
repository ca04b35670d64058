// SPDX-License-Identifier: Apache-2.0
// Which effects a pipeline holds: bits of its specialisation constant EFFECTS, in the order of effectNames().
#ifndef GNOSPHERE_EFFECTS_PLAN_H
#define GNOSPHERE_EFFECTS_PLAN_H

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
GNO_CONST uint kEffectCount = 17;

// Not an effect of its own: angle noise that sends beams astray before they meet anything.
GNO_CONST uint kStrays = 1u << 17;

// What a beam meets is not one hit of one line: candidates are gathered as lists and tried sub-ray by sub-ray.
GNO_CONST uint kFootprintEffects = kDivergence | kTransmission | kCutOuts | kStrays;
// What makes or breaks a return: judged beam by beam.
GNO_CONST uint kSignalEffects = kIntensity | kDetection | kDropOut | kRangeNoise | kAngleNoise | kIntensityNoise |
                                kFootprintEffects | kReturns | kFog | kRain | kSnow | kVolumes;
// Surfaces that one sub-ray meets, at most.
GNO_CONST uint kMaxLayers = 4;

// What fills the air.
GNO_CONST uint kMediumEffects = kFog | kRain | kSnow | kVolumes;

// What a scan holds beyond points, ranges and owners: bits of the specialisation constant FIELDS.
GNO_CONST uint kFieldSignal = 1;        // intensity, true range, width, label, cause
GNO_CONST uint kFieldSurface = 2;       // normal, incidence, material
GNO_CONST uint kFieldMotion = 4;        // velocity, radial speed
GNO_CONST uint kFieldBarycentrics = 8;  // of the hit within its triangle

// What the pass over surfaces is for: fields, and intensity, which looks at the angle and the material.
GNO_CONST uint kSurfaceFields = kFieldSurface | kFieldBarycentrics;

#ifdef __cplusplus
}  // namespace gnosphere::gpu
#endif
#endif
