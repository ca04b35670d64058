// SPDX-License-Identifier: Apache-2.0
// Stage bin with lists: computes from the number of candidates per beam where each beam's list starts. Three passes:
// reduce blocks, scan the block sums, apply. No workgroup waits for another, so the shader assumes no forward progress
// between workgroups.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_scalar_block_layout : require
#include "common/shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "views.glsl"

layout(local_size_x = 64) in;

#include "workgroup_sums.glsl"

uint blockCount() { return (beamsOfViews() + kPrefixBlock - 1) / kPrefixBlock; }

uint countsOfLane(uint block) {
  uint sum = 0;
  for (uint k = 0; k < kPerLane; ++k) {
    uint beam = block * kPrefixBlock + gl_LocalInvocationID.x * kPerLane + k;
    if (beam < beamsOfViews()) sum = plus(sum, listEnds.at[beam]);
  }
  return sum;
}

void reduceBlocks() {
  for (uint block = gl_WorkGroupID.x; block < blockCount(); block += gl_NumWorkGroups.x) {
    uint total;
    sumBefore(countsOfLane(block), total);
    if (gl_LocalInvocationID.x == 0) blockSums.at[block] = total;
  }
}

// Turns the sums of the blocks into prefix sums, in one workgroup; each lane processes a range of consecutive blocks.
void scanBlocks() {
  uint run = (blockCount() + kLanes - 1) / kLanes;
  uint first = gl_LocalInvocationID.x * run;
  uint sum = 0;
  for (uint k = first; k < min(first + run, blockCount()); ++k) sum = plus(sum, blockSums.at[k]);
  uint total;
  uint start = sumBefore(sum, total);
  for (uint k = first; k < min(first + run, blockCount()); ++k) {
    uint count = blockSums.at[k];
    blockSums.at[k] = start;
    start += count;
  }
  if (gl_LocalInvocationID.x == 0) counters.candidates = total;
}

void applyBlocks() {
  for (uint block = gl_WorkGroupID.x; block < blockCount(); block += gl_NumWorkGroups.x) {
    uint total;
    uint start = blockSums.at[block] + sumBefore(countsOfLane(block), total);
    for (uint k = 0; k < kPerLane; ++k) {
      uint beam = block * kPrefixBlock + gl_LocalInvocationID.x * kPerLane + k;
      if (beam >= beamsOfViews()) break;
      uint count = listEnds.at[beam];
      listEnds.at[beam] = start;
      start += count;
    }
  }
}

void main() {
  useOwnAddresses();
  if (PASS == kPassSumReduce) reduceBlocks();
  if (PASS == kPassSumBlocks) scanBlocks();
  if (PASS == kPassSumApply) applyBlocks();
}
