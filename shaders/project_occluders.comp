// SPDX-License-Identifier: Apache-2.0
// Runs between two shells. One subgroup per coarse entry of the farthest-range table, one invocation per fine entry:
// computes the largest range among the words of the entry's beams, so that the next shell can skip what lies behind. A
// workgroup per coarse entry would need barriers; on lavapipe that took three times as long as everything else.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#include "shared.h"
#include "options.glsl"
#include "bindings.glsl"

layout(local_size_x = 64) in;

// For the next shell only the rows in which it has content are computed; for the still image, all rows.
bool worthKnowing(uvec2 entry) {
  bool later = entry.y * kFineRows < counters.laterRowsUp &&
               (entry.y + 1) * kFineRows > frame.rows - counters.laterRowsDown;
  return later || pass.shellMax > kCoordinateLimit;
}

uint farthestIn(uvec2 entry) {
  uint result = 0;
  uint rowEnd = min((entry.y + 1) * kFineRows, frame.rows), first = entry.x * kFineColumns;
  uint last = min(kFineColumns, frame.columns - first) - 1;
  // A beam without a hit hides nothing, so the search stops there.
  for (uint row = entry.y * kFineRows; row < rowEnd && result != kNone; ++row)
    [[unroll]] for (uint k = 0; k < kFineColumns; ++k)
      result = max(result, words.at[row * frame.columns + first + min(k, last)].y);
  return result;
}

void main() {
  uint perRow = (frame.columns + kFineColumns - 1) / kFineColumns, fineRows = (frame.rows + kFineRows - 1) / kFineRows;
  uint coarsePerRow = (frame.columns + kCoarseColumns - 1) / kCoarseColumns,
       coarseRows = (frame.rows + kCoarseRows - 1) / kCoarseRows;
  uvec2 across = uvec2(kCoarseColumns / kFineColumns, kCoarseRows / kFineRows);
  uint stride = gl_NumWorkGroups.x * gl_NumSubgroups;
  for (uint i = gl_WorkGroupID.x * gl_NumSubgroups + gl_SubgroupID; i < coarsePerRow * coarseRows; i += stride) {
    uvec2 coarse = uvec2(i % coarsePerRow, i / coarsePerRow);
    uint largest = 0;
    for (uint k = gl_SubgroupInvocationID; k < across.x * across.y; k += gl_SubgroupSize) {
      uvec2 entry = coarse * across + uvec2(k % across.x, k / across.x);
      if (entry.x >= perRow || entry.y >= fineRows) continue;
      bool known = worthKnowing(entry);
      uint found = known ? farthestIn(entry) : kNone;
      farthest.at[entry.y * perRow + entry.x] = found;
      if (known) largest = max(largest, found);
    }
    largest = subgroupMax(largest);
    if (gl_SubgroupInvocationID == 0) farthest.at[perRow * fineRows + i] = largest > 0 ? largest : kNone;
  }
  if (gl_WorkGroupID == uvec3(0) && gl_LocalInvocationID.x == 0) {
    counters.binnedSmall = counters.projectedSmall;
    counters.binnedTiles = counters.tiles;
  }
}
