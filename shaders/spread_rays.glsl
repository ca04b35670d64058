// SPDX-License-Identifier: Apache-2.0
// Sub-rays of one beam that the lanes of a subgroup share. Lane i has the sub-rays i, i + gl_SubgroupSize, ... of
// SPREAD_RAYS, at RAYS places; a place without a sub-ray has one that carries no energy. All lanes look at the same
// candidate, so they take the same branches. If SPREAD_RAYS is 0, each invocation has all sub-rays of a beam of its own,
// and leastOfBeam(), mostOfBeam() and anyOfBeam() return their argument.

// Returns the number of the sub-ray at a place of this lane; SPREAD_RAYS or more if the place has no sub-ray.
uint numberOfRay(uint place) {
  return SPREAD_RAYS > 0 ? place * gl_SubgroupSize + gl_SubgroupInvocationID : place;
}

// Returns the number of lanes that have a sub-ray at a place.
uint lanesWithRay(uint place) { return min(SPREAD_RAYS - min(place * gl_SubgroupSize, SPREAD_RAYS), gl_SubgroupSize); }

// True for the lane that stores what all lanes of the beam have found.
bool speaksForBeam() { return SPREAD_RAYS == 0 || gl_SubgroupInvocationID == 0; }

float leastOfBeam(float value) {
  if (SPREAD_RAYS > 0) return subgroupMin(value);
  return value;
}

float mostOfBeam(float value) {
  if (SPREAD_RAYS > 0) return subgroupMax(value);
  return value;
}

bool anyOfBeam(bool value) {
  if (SPREAD_RAYS > 0) return subgroupAny(value);
  return value;
}
