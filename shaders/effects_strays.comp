// SPDX-License-Identifier: Apache-2.0
// Stage effects, before the beams meet anything. One row of workgroups per channel: draws the angle error of every
// beam.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_basic : require
#include "common/shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "common/effects/noise.h"
#include "common/beam.h"
#include "views.glsl"
#include "beams.glsl"
#include "runs.glsl"

layout(local_size_x = 64) in;

void main() {
  useOwnAddresses();
  uint ownRow = rowInView(gl_WorkGroupID.y);
  BeamRow row = loadRow(ownRow);
  uvec2 run = runOfBeams();
  for (uint k = run.x + gl_SubgroupInvocationID; k < run.y; k += gl_SubgroupSize) {
    uint column = beamColumn(k), index = indexOf(ownRow, column);
    vec2 error = angleError(parametersOf(view), numberIn(row, index, column));
    float cosElevation = LISTED ? beamAngles.at[tableEntry(index)].z : row.angles.x;
    precise float left = error.x * cosElevation;
    strays.at[beamEntry(index)] = vec2(left, error.y);
  }
}
