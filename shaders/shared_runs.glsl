// SPDX-License-Identifier: Apache-2.0
// The lanes of a subgroup share the entries of runs, of which each lane has one. All lanes must call these functions, which
// shuffle instead of scanning, because Mesa's lavapipe scans lane by lane.

// Returns the number of entries of this lane and of the lanes before it.
uint sumUpTo(uint count) {
  uint upTo = count, last = gl_SubgroupSize - 1;
  [[unroll]] for (uint step_ = 1; step_ < 64; step_ <<= 1)
    if (step_ < gl_SubgroupSize) {
      uint before = subgroupShuffle(upTo, gl_SubgroupInvocationID - step_ & last);
      upTo += gl_SubgroupInvocationID >= step_ ? before : 0;
    }
  return upTo;
}

// Returns the lane whose run has the entry with a number, where `upTo` is that of sumUpTo(); the last lane if there are
// fewer entries.
uint ownerOf(uint upTo, uint number) {
  uint owner = 0;
  [[unroll]] for (uint half_ = 32; half_ > 0; half_ >>= 1)
    if (half_ < gl_SubgroupSize) owner += subgroupShuffle(upTo, owner + half_ - 1) <= number ? half_ : 0;
  return owner;
}
