// SPDX-License-Identifier: Apache-2.0
// Stage bin. Gives every projected triangle to the beams that meet it. Small boxes are worked off by one invocation
// each; tiles of large ones by a subgroup each, lanes along the columns. PASS says what is done with a meeting.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_KHR_shader_subgroup_basic : require
#ifdef INT64_ATOMICS
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
#endif
#include "shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "sphere.glsl"
#include "bounds.glsl"
#include "inside.glsl"

layout(local_size_x = 64) in;
#ifdef INT64_ATOMICS
layout(std430, set = 0, binding = kBindWords) coherent buffer Words64Block { uint64_t words64[]; };
#endif

// Ranges are positive, so their bits order like numbers. Reading before the atomic is safe: words only fall.
void offerNearest(uint beam, uint rangeBits, uint id) {
#ifdef INT64_ATOMICS
  if (rangeBits <= words[2 * beam + 1]) atomicMin(words64[beam], packUint2x32(uvec2(id, rangeBits)));
#endif
}

void offer(uint beam, float range, uint projected, uint id) {
  uint rangeBits = floatBitsToUint(range);
  if (PASS == kPassNearest) {
    offerNearest(beam, rangeBits, id);
  } else if (PASS == kPassRange) {
    if (rangeBits < words[2 * beam + 1]) atomicMin(words[2 * beam + 1], rangeBits);
  } else if (PASS == kPassOwner) {
    if (rangeBits == words[2 * beam + 1]) atomicMin(words[2 * beam], id);
  } else if (PASS == kPassCount) {
    atomicAdd(listEnds[beam], 1);
  } else {
    uint slot = atomicAdd(listEnds[beam], 1);
    if (slot < frame.candidateCapacity) candidates[slot] = projected;
  }
}

float farthestOf(uint index) {
  bool lists = PASS == kPassCount || PASS == kPassFill;
  return lists ? frame.rangeMax : min(uintBitsToFloat(min(words[2 * index + 1], 0x7f800000u)), frame.rangeMax);
}

// A box starts between -3/4 and 1 turns, an azimuth offset adds up to 1/2 either way, and it spans up to 1.
uint wrapColumn(int column) {
  int turnColumns = int(frame.columns);
  if (column < 0) column += turnColumns;
  if (column < 0) column += turnColumns;
  if (column >= turnColumns) column -= turnColumns;
  if (column >= turnColumns) column -= turnColumns;
  return uint(column);
}

// Tries the beams of `count` columns of a box, from its `first`-th on, every `stride`-th.
void tryColumns(uint projected, Box box, uint first, uint count, uint stride) {
  if (first >= count) return;
  Triangle triangle = loadProjected(projected);
  uint rowFirst = box.rows & 0xffff, rowLast = box.rows >> 16;
  Prepared prepared = prepare(triangle);
  // One loop over the box's beams, not two nested ones: lanes with boxes of other shapes then wait for the largest box
  // only, not for the most columns times the most rows.
  uint row = rowLast, column = 0;
  uint k = first - stride;
  Turned turned;
  while (true) {
    if (row == rowLast) {
      k += stride;
      if (k >= count) break;
      row = rowFirst;
      column = wrapColumn(int(ceil(box.columnMin)) + int(k));
      turned = turn(triangle, columns[column]);
    } else {
      ++row;
    }
    if (AZIMUTH_OFFSETS) column = wrapColumn(int(ceil(box.columnMin - rows[row].columnShift)) + int(k));
    Beam beam = beamOf(columns[column], row);
    if (AZIMUTH_OFFSETS) turned = turn(triangle, beam.azimuth);
    uint index = rows[row].channel * frame.columns + column;
    float range;
    if (meet(triangle, prepared, turned, beam, index, range))
      offer(index, range, projected, triangle.id);
  }
}

bool isSmall(Box box) {
  return boxColumnCount(box) * ((box.rows >> 16) - (box.rows & 0xffff) + 1) <= kSmallBoxBeams;
}

void main() {
  uint projectedCount = min(counters.projected, frame.projectedCapacity);
  uint stride = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
  for (uint i = gl_WorkGroupID.x * gl_WorkGroupSize.x + gl_LocalInvocationID.x; i < projectedCount; i += stride) {
    Box box = projectedBoxes[i];
    if (isSmall(box)) tryColumns(i, box, 0, boxColumnCount(box), 1);
  }
  uint tileCount = min(counters.tiles, frame.tileCapacity);
  for (uint i = gl_WorkGroupID.x * gl_NumSubgroups + gl_SubgroupID; i < tileCount;
       i += gl_NumWorkGroups.x * gl_NumSubgroups) {
    Tile tile = tiles[i];
    Box box = projectedBoxes[tile.projected];
    uint end = min(tile.columnFirst + tile.columnCount, boxColumnCount(box));
    tryColumns(tile.projected, box, tile.columnFirst + gl_SubgroupInvocationID, end, gl_SubgroupSize);
  }
}
