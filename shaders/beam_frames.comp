// SPDX-License-Identifier: Apache-2.0
// Stage project, before the triangles, if something moves during the scan and the beams of a column or cell fire at
// different times. One row of workgroups per channel: computes the frame of every beam. A beam is tried on six to nine
// triangles (HDL-64E-S2 and Pandar128E3X in a town), and each try would have to compute the frame again.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_basic : require
#include "common/shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "common/beam.h"
#include "views.glsl"
#include "beams.glsl"
#include "motion.glsl"
#include "runs.glsl"

layout(local_size_x = 64) in;

void main() {
  useOwnAddresses();
  uint ownRow = rowInView(gl_WorkGroupID.y);
  BeamRow row = loadRow(ownRow);
  uvec2 run = runOfBeams();
  for (uint k = run.x + gl_SubgroupInvocationID; k < run.y; k += gl_SubgroupSize) {
    uint column = beamColumn(k), index = indexOf(ownRow, column);
    uint rowIndex = LISTED ? column : ownRow;  // as rowOf() returns it, without its division
    ColumnMotion at = columnMotionOf(rowIndex, column);
    vec2 azimuth = beamIn(row, column).azimuth;
    precise vec4 forward = at.row0 * azimuth.x + at.row1 * azimuth.y;
    precise vec4 left = at.row1 * azimuth.x - at.row0 * azimuth.y;
    vec4 up = at.row2;
    if (ORIGINS) {
      vec3 laser = laserOf(rowIndex);
      forward.w -= laser.x;
      left.w -= laser.y;
      up.w -= laser.z;
    }
    beamFrames.at[beamEntry(index)] = BeamFrame(forward, left, up);
  }
}
