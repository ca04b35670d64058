// SPDX-License-Identifier: Apache-2.0
// Buckets of distance: runs of floats with the same exponent and the same two leading bits of the mantissa. The last
// bucket ends beyond the range.

uint firstBucketBits() { return (floatBitsToUint(frame.rangeMax) >> kBucketShift) - (kShellBuckets - 1); }
uint bucketOf(float range) {
  uint bits = floatBitsToUint(range) >> kBucketShift, first = firstBucketBits();
  return bits > first ? min(bits - first, kShellBuckets - 1) : 0;
}
float endOfBucket(uint bucket) { return uintBitsToFloat(firstBucketBits() + bucket + 1 << kBucketShift); }
