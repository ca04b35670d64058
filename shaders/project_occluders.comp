// SPDX-License-Identifier: Apache-2.0
// Between two shells. One invocation per fine entry of the farthest-range table, one workgroup per coarse entry: the
// largest range among the words of its beams, so that the next shell can skip what lies behind.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#include "shared.h"
#include "options.glsl"
#include "bindings.glsl"

layout(local_size_x = 64) in;
layout(push_constant) uniform PassBlock { Pass pass; };
shared uint largest;

// For the next shell, only the rows that it has something in; for a still image, all of them.
bool worthKnowing(uvec2 entry) {
  bool later = entry.y * kFineRows < counters.laterRowsUp &&
               (entry.y + 1) * kFineRows > frame.rows - counters.laterRowsDown;
  return later || pass.shellMax > kCoordinateLimit;
}

uint farthestIn(uvec2 entry) {
  uint result = 0;
  uint rowEnd = min((entry.y + 1) * kFineRows, frame.rows), columnEnd = min((entry.x + 1) * kFineColumns, frame.columns);
  // A beam that met nothing hides nothing: no need to look further.
  for (uint row = entry.y * kFineRows; row < rowEnd && result != kNone; ++row)
    for (uint column = entry.x * kFineColumns; column < columnEnd && result != kNone; ++column)
      result = max(result, words[row * frame.columns + column].y);
  return result;
}

void main() {
  if (gl_LocalInvocationID.x == 0) largest = 0;
  barrier();
  uint perRow = (frame.columns + kFineColumns - 1) / kFineColumns, fineRows = (frame.rows + kFineRows - 1) / kFineRows;
  uvec2 across = uvec2(kCoarseColumns / kFineColumns, kCoarseRows / kFineRows);
  uint mine = 0;
  for (uint k = gl_LocalInvocationID.x; k < across.x * across.y; k += gl_WorkGroupSize.x) {
    uvec2 entry = gl_WorkGroupID.xy * across + uvec2(k % across.x, k / across.x);
    if (entry.x >= perRow || entry.y >= fineRows) continue;
    bool known = worthKnowing(entry);
    uint found = known ? farthestIn(entry) : kNone;
    farthest[entry.y * perRow + entry.x] = found;
    if (known) mine = max(mine, found);
  }
  mine = subgroupMax(mine);
  if (subgroupElect()) atomicMax(largest, mine);
  barrier();
  if (gl_LocalInvocationID.x == 0) {
    farthest[perRow * fineRows + gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x] =
        largest > 0 ? largest : kNone;
    if (gl_WorkGroupID == uvec3(0)) {
      counters.binnedSmall = counters.projectedSmall;
      counters.binnedTiles = counters.tiles;
    }
  }
}
