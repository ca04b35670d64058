// SPDX-License-Identifier: Apache-2.0
// Sums over a block of kPrefixBlock entries, of which each lane of a workgroup has kPerLane.
const uint kLanes = gl_WorkGroupSize.x;
const uint kPerLane = kPrefixBlock / kLanes;
// The array has one entry more than there are lanes, because glslang gives arrays of equal size one type, and that of
// Shells::clusters has a stride. Only arrays in buffers may have a stride.
shared uint laneSums[kLanes + 1];

// A sum that overflows stays at the largest number, which tells the host that there are too many candidates.
uint plus(uint a, uint b) { return a + b < a ? kNone : a + b; }

// Returns the sum over the lanes before this one. All lanes of the workgroup must call this.
uint sumBefore(uint value, out uint total) {
  uint lane = gl_LocalInvocationID.x;
  laneSums[lane] = value;
  barrier();
  uint before = 0;
  total = 0;
  for (uint k = 0; k < kLanes; ++k) {
    if (k < lane) before = plus(before, laneSums[k]);
    total = plus(total, laneSums[k]);
  }
  barrier();
  return before;
}
