// SPDX-License-Identifier: Apache-2.0
// Tests points against the limit of coordinates.

// True if a point is finite and within the limit of coordinates. Tests the bits, because the compiler may assume that
// NaN does not occur.
bool inLimits(vec3 p) {
  uvec3 magnitude = floatBitsToUint(p) & 0x7fffffffu;
  return all(lessThanEqual(magnitude, uvec3(floatBitsToUint(kCoordinateLimit))));
}
