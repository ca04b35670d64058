// SPDX-License-Identifier: Apache-2.0
// First pass of effects_footprint: beams whose whole footprint lies on one triangle. Such a beam has one echo, because
// light fills the gaps between sub-rays on a slope (see slopeOf()).
// Indices are written as 0 * RAYS + s, because glslang checks constant ones against the default value of RAYS.

// Adds the hits of all sub-rays on a surface to the sums of an echo.
vec3 sumsOf(float first, float inverseFirst) {
  vec3 sums = vec3(0.0);
#define ADD_HIT(s) \
  addPiece(sums, product(carried[s], reflections[s]), sumOf(ranges[0 * RAYS + s], -first), inverseFirst);
  EACH_RAY(ADD_HIT)
  return sums;
}

// Returns the place of the candidate that comes nearest to the sensor, most likely the hit; the end of the list if there
// is none.
uint bestOf() {
  uint best = listEnd;
  float bestRangeMin = kNothing;
  for (uint k = listFirst; k != listEnd; k = nextOf(k)) {
    float nearest = nearestAt(k);
    if (best == listEnd || nearest < bestRangeMin) {
      best = k;
      bestRangeMin = nearest;
    }
  }
  return best;
}

// Handles a beam whose whole footprint lies on one candidate, with no other in front of it that a sub-ray may hit.
// Returns false for any other beam.
bool findWithinOne(uint index, uint beam, Beam axis) {
  uint best = BINNING != kBinningLists && listFirst == kOfWord ? kOfWord : bestOf();
  if (best == listEnd) {
    echoCounts.at[resultOf(beam)] = 0;
    return true;
  }
  uint projected = projectedAt(best);
  Optics4 surface = optics.at[projectedMaterials.at[projected]];
  Candidate candidate = candidateOf(projected, axis);
  bool holed = (EFFECTS & kCutOuts) != 0 && surface.passage.y > 0.0, clear = LAYERS > 1 && transmitted(surface) > 0.0;
  if (holed || clear || !coversFootprint(candidate)) return false;
  Plane plane = planeOf(candidate);
  float least = kNothing, farthest = 0.0, range;
  bool met = true, lit, hit;
#define MEET(s)                                                     \
  hit = reach(candidate, plane, left[s], up[s], lengths[s], range); \
  ranges[0 * RAYS + s] = range;                                     \
  farthest = range > farthest ? range : farthest;                   \
  lit = carried[s] > 0.0;                                           \
  least = lit && range < least ? range : least;                     \
  met = met && hit;
  EACH_RAY(MEET)
  vec2 middle = (EFFECTS & kStrays) != 0 ? strays.at[beamEntry(index)] : vec2(0.0);
  for (uint k = listFirst; k != listEnd && met; k = nextOf(k))
    if (k != best && nearestAt(k) <= farthest) met = !touchesFootprint(candidateOf(projectedAt(k), axis), middle);
  if (!met) return false;
  vec3 normal = unitTowardsOrigin(plane.normal, vec3(candidate.ahead.x, candidate.left.x, candidate.up.x));
  reflectEach(surface, normal);
  float inverseLeast = inverseOfFirst(least);
  storeEcho(echoPlace(index, 0), echoOf(least, inverseLeast, sumsOf(least, inverseLeast)), 0.0, projected);
  echoCounts.at[resultOf(beam)] = 1;
  return true;
}
