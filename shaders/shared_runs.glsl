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

// Lets lanes join those that wait, which are the first ones. Returns how many wait then, and the lane from which this lane
// takes what it holds: in this round if it does not wait yet, in the next round if those that wait are too many.
uvec2 joinWaiting(bool joins, uint waiting) {
  uint last = gl_SubgroupSize - 1, upTo = sumUpTo(joins ? 1 : 0);
  return uvec2(waiting + subgroupShuffle(upTo, last), ownerOf(upTo, gl_SubgroupInvocationID - waiting & last));
}
