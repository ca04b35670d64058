// SPDX-License-Identifier: Apache-2.0
// Not a stage: calls every formula of the effects, so that the build and the tests have each of them as SPIR-V. One
// invocation per beam.
#version 460
#extension GL_GOOGLE_include_directive : require

#include "common/effects/doppler.h"
#include "common/effects/parameters.h"

#define RETURNS parameters.returnsPerBeam
#define MOST_ECHOES kFewEchoes

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint EFFECTS = 0xffffffffu;

layout(std430, binding = 0) readonly buffer ParametersBlock { EffectParameters parameters; };
layout(std430, binding = 1) readonly buffer EchoesBlock { Echo echoes[]; };
layout(std430, binding = 2) readonly buffer VolumesBlock { VolumeBox volumes[]; };
layout(std430, binding = 3) readonly buffer OpticsBlock { Optics4 optics[]; };
layout(std430, binding = 4) writeonly buffer ReturnsBlock { Return returns[]; };
layout(std430, binding = 5) writeonly buffer CausesBlock { uint causes[]; };
layout(std430, binding = 6) writeonly buffer SumsBlock { float sums[]; };

Echo loadEcho(uint k) {
  return echoes[gl_GlobalInvocationID.x * kFewEchoes + k];
}
void storeReturn(uint j, Return value) {
  returns[gl_GlobalInvocationID.x * parameters.returnsPerBeam + j] = value;
}
VolumeBox loadVolume(uint i) {
  return volumes[i];
}
bool isDead(uint beam) {
  return beam == 1u;
}

#include "common/effects/signal.h"

void main() {
  uint beam = gl_GlobalInvocationID.x;
  vec3 direction = astray(vec3(1.0f, 0.0f, 0.0f), angleError(parameters, beam));
  uint count;
  causes[beam] = signalsOf(parameters, beam, direction, kFewEchoes, count);
  GNO_PRECISE float sum = radialSpeed(direction, vec3(1.0f), vec3(0.0f)) + float(count);
  sum = sum + echoWidth(reflected(optics[0], 0.5f), transmitted(optics[0]));
  sums[beam] = sum;
}
