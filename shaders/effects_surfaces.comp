// SPDX-License-Identifier: Apache-2.0
// Stage effects: finds the surface at every hit from the hit's owner. Neighbouring beams mostly hit the same triangle,
// so only the first of them in a subgroup loads it and shares it with the others.
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
#include "beams.glsl"
#include "motion.glsl"
#include "strays.glsl"
#include "surface_of.glsl"

layout(local_size_x = 64) in;
#include "runs.glsl"

// Returns the point that the beam meets, in the frame of its laser.
vec3 pointOf(uint index, uint at) {
  if (!MOTION && (EFFECTS & kStrays) == 0) return points.at[at].xyz;
  Beam axis = beamWith(index);
  vec3 direction = axis.direction;
  if ((EFFECTS & kStrays) != 0) direction = strayed(axis, strays.at[index]);
  return direction * points.at[at].w;
}

// True if the lane is the first of consecutive lanes with the same owner.
bool leads(uvec2 owner) {
  uint lane = gl_SubgroupInvocationID;
  return lane == 0 || owner != subgroupShuffle(owner, (lane - 1) & (gl_SubgroupSize - 1));
}

// Returns the lane itself if it is the first with its owner, otherwise the last such lane before it.
uint leaderOf(bool leading) {
  uint lane = gl_SubgroupInvocationID, leader = leading ? lane : kNone;
  for (uint step = 1; step < gl_SubgroupSize; step *= 2) {
    uint before = subgroupShuffle(leader, (lane - step) & (gl_SubgroupSize - 1));
    if (leader == kNone && lane >= step) leader = before;
  }
  return leader;
}

// Returns the leader's surface.
Surface told(Surface surface, uint leader) {
  surface.normal = subgroupShuffle(surface.normal, leader);
  surface.material = subgroupShuffle(surface.material, leader);
  if ((FIELDS & kFieldBarycentrics) != 0)
    surface.corners = Corners(subgroupShuffle(surface.corners.a, leader), subgroupShuffle(surface.corners.b, leader),
                              subgroupShuffle(surface.corners.c, leader));
  return surface;
}

void main() {
  loadMotion();
  BeamRow row = loadRow(gl_WorkGroupID.y);
  uvec2 run = runOfBeams();
  // No lane leaves the loop early, because all lanes take part in the shuffles.
  for (uint from = run.x; from < run.y; from += lanes()) {
    uint column = min(from + laneNumber(), run.y - 1);
    uint index = indexOf(gl_WorkGroupID.y, column), at = numberIn(row, index, column);
    bool there = !MAPPED || at != kNone;
    at = there ? at * RETURNS : 0;
    uvec2 owner = owners.at[at];
    // With motion each beam sees its triangle at a different time, so no lane can share.
    bool leading = MOTION || leads(owner);
    Surface surface;
    if (leading) surface = surfaceOf(index, owner);
    if (!MOTION) surface = told(surface, leaderOf(leading));
    if (from + laneNumber() >= run.y || !there) continue;
    surfaces.at[at] = SurfaceRecord(surface.normal, surface.material);
    if ((FIELDS & kFieldBarycentrics) != 0 && owner.x != kNone)
      barycentrics.at[at] = barycentricsOf(surface.corners, pointOf(index, at));
  }
}
