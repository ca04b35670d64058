// SPDX-License-Identifier: Apache-2.0
// Stage effects, before the beams meet anything. One row of workgroups per channel: draws the angle error of every
// beam.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
#include "shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "effects/noise.h"

layout(local_size_x = 64) in;

void main() {
  uint row = gl_WorkGroupID.y, channel = rows.at[row].channel;
  float cosElevation = rows.at[row].angles.x;
  uint first = gl_WorkGroupID.x * kResolveColumns, end = min(first + kResolveColumns, frame.columns);
  for (uint column = first + gl_LocalInvocationID.x; column < end; column += gl_WorkGroupSize.x) {
    vec2 error = angleError(parameters, channel * frame.columns + column);
    precise float left = error.x * cosElevation;
    strays.at[row * frame.columns + column] = vec2(left, error.y);
  }
}
