// SPDX-License-Identifier: Apache-2.0
// Stage effects, without signals: writes the surface at every hit. With signals effects.comp does so itself.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_shuffle : require
#include "shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "effects/vector.h"
#include "to_sensor.glsl"
#include "beam.h"
#include "motion.glsl"
#include "surface.glsl"

layout(local_size_x = 64) in;

vec3 pointOf(uint row, uint column, uint at) {
  vec3 angles = rows.at[row].angles;
  return MOTION ? beamOf(azimuthAt(row, column), angles.x, angles.y).direction * points.at[at].w : points.at[at].xyz;
}

void main() {
  loadMotion();
  uint row = gl_WorkGroupID.y, channel = rows.at[row].channel;
  uint first = gl_WorkGroupID.x * kResolveColumns, end = min(first + kResolveColumns, frame.columns);
  // No lane leaves the loop early, because all lanes take part in the shuffles.
  for (uint from = first; from < end; from += gl_WorkGroupSize.x) {
    uint column = min(from + gl_LocalInvocationID.x, end - 1);
    uint at = (channel * frame.columns + column) * RETURNS;
    uvec2 owner = owners.at[at];
    Surface surface = surfaceOfHit(row, column, owner);
    if (from + gl_LocalInvocationID.x >= end) continue;
    if ((FIELDS & kFieldSurface) != 0) surfaces.at[at] = SurfaceRecord(surface.normal, surface.material);
    if ((FIELDS & kFieldBarycentrics) != 0 && owner.x != kNone)
      barycentrics.at[at] = barycentricsOf(surface.corners, pointOf(row, column, at));
  }
}
