// SPDX-License-Identifier: Apache-2.0
// Each lane of a subgroup has found a run of entries, and the lanes share the entries of all these runs. All lanes must call
// these functions. On Mesa's lavapipe a shuffle is one instruction, and a scan goes through the lanes one by one; so sums
// are computed by shuffles.

// Returns how many entries the run of this lane and the runs of the lanes before it have together.
uint sumUpTo(uint count) {
  uint upTo = count, last = gl_SubgroupSize - 1;
  EACH_STEP(k) {
    uint before = subgroupShuffle(upTo, gl_SubgroupInvocationID - (1u << k) & last);
    upTo += gl_SubgroupInvocationID >= 1u << k ? before : 0;
  }
  return upTo;
}

// Returns the lane whose run has the entry with a number, or the last lane if the runs have fewer entries. Each lane
// passes its own result of sumUpTo().
uint ownerOf(uint upTo, uint number) {
  uint owner = 0;
  [[unroll]] for (uint half_ = 32; half_ > 0; half_ >>= 1)
    if (half_ < gl_SubgroupSize) owner += subgroupShuffle(upTo, owner + half_ - 1) <= number ? half_ : 0;
  return owner;
}
