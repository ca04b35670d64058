// SPDX-License-Identifier: Apache-2.0
// Vertices become multiples of 2^-30 m: so products of three never underflow, whatever a device does with denormals.
vec3 snapToLattice(vec3 p) {
  precise vec3 snapped = roundEven(p * 1073741824.0) * (1.0 / 1073741824.0);
  return mix(p, snapped, lessThan(abs(p), vec3(0.015625)));
}
