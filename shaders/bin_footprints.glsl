// SPDX-License-Identifier: Apache-2.0
// Keeps the triangles that the footprints of beams may meet. The word of a beam has a range beyond which no line of its
// footprint goes on, and the nearest triangle that stops all of them, if a single one does. All other triangles that may
// matter are in the beam's chain.

// True if beams have footprints.
#define FOOTPRINTS ((EFFECTS & kFootprint) != 0)
// True if the triangles that footprints may meet are kept in words and chains.
#define CHAINS (FOOTPRINTS && BINNING != kBinningLists)
// True if such triangles wait until every lane has one (see bin_waiting.glsl). Waiting takes a third more registers, so it is
// for CPUs, where footprints take 0.96 of the time.
#define WAITS (CHAINS && kLanesInStep)

vec2 subRayTangents[RAYS];  // of each sub-ray's angles to the left and up
uvec2 litRays;              // one bit for each sub-ray that carries energy
bool stopsLight;            // whether no light goes on where the current triangle is hit
uint paneBit;               // kPaneBit if the current triangle is a pane

void loadTangents(uint s) {
  vec4 subRay = subRays.at[s];
  subRayTangents[s] = subRay.xy;
  uint bit = subRay.z > 0.0 ? 1u << (s & 31) : 0u;
  litRays |= s < 32 ? uvec2(bit, 0) : uvec2(0, bit);
}

void loadFootprint() {
  if (!CHAINS) return;
  litRays = uvec2(0);
#define LOAD_TANGENTS(s) loadTangents(s);
  EACH_RAY(LOAD_TANGENTS)
}

// Light goes on through holes and panes.
void lookAtSurface(uint projected) {
  if (!CHAINS) return;
  stopsLight = true;
  paneBit = 0;
  if ((EFFECTS & kCutOuts) != 0) stopsLight = optics.at[projectedMaterials.at[projected]].passage.y <= 0.0;
  if (LAYERS > 1 && isPane(projected)) {
    stopsLight = false;
    paneBit = kPaneBit;
  }
}

// True if a line within the footprint of a beam may meet a triangle.
bool footprintMayMeet(Triangle triangle, Prepared prepared, Turned turned, Beam beam) {
  return mayMeet(triangle, prepared, watertightSides(turned, beam.cosElevation, beam.sinElevation));
}

// How the lines within the footprint of a beam meet a triangle.
struct Stop {
  bool whole;             // all of them hit it clearly within its edges, and no light goes on behind it
  uvec2 rays;             // otherwise the sub-rays that do, one bit each
  float least, farthest;  // bounds of the ranges of the hits
};

// Returns the sub-rays that clearly hit a triangle, of which the beam's own sides are given, negative within it. The side
// of a sub-ray with the tangents u and v is side + u * second + v * third; the margin is far more than the rounding
// errors.
uvec2 raysWithin(Turned turned, Beam beam, vec3 depth, vec3 side, bool averted, uint index) {
  vec3 above = aboveBeam(turned, beam.cosElevation, beam.sinElevation), left = turned.q;
  vec3 second = above.yzx * depth.zxy - depth.yzx * above.zxy, third = depth.yzx * left.zxy - left.yzx * depth.zxy;
  vec3 margin = 4e-6 * (abs(side) + abs(second) + abs(third));
  if (averted) {
    side = -side;
    second = -second;
    third = -third;
  }
  vec2 stray = (EFFECTS & kStrays) != 0 ? strays.at[beamEntry(index)] : vec2(0.0);
  side += stray.x * second + stray.y * third + margin;
  uvec2 rays = uvec2(0);
  vec3 sides;
#define WITHIN(s)                                                                \
  sides = side + subRayTangents[s].x * second + subRayTangents[s].y * third;     \
  if (s < 32)                                                                    \
    rays.x |= max(max(sides.x, sides.y), sides.z) < 0.0 ? 1u << (s & 31) : 0u;   \
  else                                                                           \
    rays.y |= max(max(sides.x, sides.y), sides.z) < 0.0 ? 1u << (s & 31) : 0u;
  EACH_RAY(WITHIN)
  return rays & litRays;
}

// The range of a line that deviates by up to `spread` from the axis is that of the axis, divided by at most the change of
// the cosine to the normal; the other terms are far more than the rounding errors. `stopped` has the bits of the range at
// which the beam ends by now: sub-rays that a triangle stops farther away do not count.
Stop stopOf(Triangle triangle, Prepared prepared, Turned turned, Beam beam, vec3 side, uint index, uint stopped) {
  vec3 reach = 1.02 * prepared.reach;
  bool inside = all(lessThan(side, -reach)) || (all(greaterThan(side, reach)) && !triangle.oneSided);
  vec3 depth = cornerDepths(turned, beam.cosElevation, beam.sinElevation);
  float along = side.x + side.y + side.z, sum = abs(along), spread = 1.02 * frame.footprint;
  float change = spread * prepared.area, slope = prepared.area / max(sum - change, 1e-30);
  float range = dot(side, depth) / along;  // less than 0 if the triangle lies behind the beam
  bool clear = range > 0.0 && sum > change && frame.footprint < 0.2;
  // The last term is the error of the corners' weights, which matters for slivers.
  float deep = max(max(depth.x, depth.y), depth.z) - min(min(depth.x, depth.y), depth.z);
  float error = range * (1e-5 + 1e-6 * slope) + 4e-6 * deep * prepared.longest / max(sum, 1e-30);
  vec2 window = windowOf(prepared, index);
  bool ends = stopsLight && clear && triangle.rangeMin >= window.x;
  Stop stop;
  stop.least = clear ? max(range * (sum / (sum + change)) - error, triangle.rangeMin) : triangle.rangeMin;
  stop.farthest = max(range * (1.0 + spread * slope) * (1.0 + spread * spread) + error, triangle.rangeMin);
  stop.whole = ends && inside && stop.farthest <= window.y;
  stop.rays = uvec2(0);
  if (stop.whole) return stop;
  stop.farthest = min(stop.farthest, prepared.farthest);
  bool facing = along < 0.0;
  bool nearer = floatBitsToUint(stop.farthest) < stopped;
  if (ends && nearer && stop.farthest <= window.y && (facing || !triangle.oneSided))
    stop.rays = raysWithin(turned, beam, depth, side, !facing, index);
  return stop;
}

#if defined(VULKAN) && defined(INT64_ATOMICS)
layout(buffer_reference, scalar, buffer_reference_align = 8) coherent buffer Covers64 { uint64_t at[]; };
Covers64 covers64 = Covers64(covers);
#endif

// Adds sub-rays to those of a beam that are stopped. When that is true of all of them, returns the largest range at
// which, and kNone before. CPUs have no instructions for the maximum or the union with the value before, but exchange
// both values in one operation.
uint rangeOfAll(uint index, uvec2 rays, float farthest) {
#if defined(VULKAN) && defined(INT64_ATOMICS)
  if (kLanesInStep && RAYS <= 32) {
    uint64_t expected = covers64.at[2 * beamEntry(index)];
    while (true) {
      uvec2 cover = unpackUint2x32(expected);
      cover = uvec2(max(cover.x, floatBitsToUint(farthest)), cover.y | rays.x);
      uint64_t found = atomicCompSwap(covers64.at[2 * beamEntry(index)], expected, packUint2x32(cover));
      if (found == expected) return cover.y == litRays.x ? cover.x : kNone;
      expected = found;
    }
  }
#endif
  atomicMax(covers.at[beamEntry(index)].farthest, floatBitsToUint(farthest));
  memoryBarrierBuffer();  // whoever sees the bits also sees the range
  rays.x |= atomicOr(covers.at[beamEntry(index)].lowRays, rays.x);
  if (RAYS > 32) {
    memoryBarrierBuffer();  // whoever sees the upper bits also sees the lower ones
    rays.y |= atomicOr(covers.at[beamEntry(index)].highRays, rays.y);
  }
  memoryBarrierBuffer();
  // Two lanes that add the last bits at once may each have found the lower bits incomplete.
  if (RAYS > 32) rays.x = covers.at[beamEntry(index)].lowRays;
  return rays == litRays ? covers.at[beamEntry(index)].farthest : kNone;
}

uint ownLinkCount = 0;  // links that this invocation has made at their beams' own places

// Adds a candidate to the chain of a beam. Its first links lie side by side at places of its own; following a pointer
// from link to link takes longer.
void linkFootprint(uint beam, uint projected, uint rangeBits) {
  uint number = atomicAdd(covers.at[beamEntry(beam)].links, 1);
  if (number < kOwnLinks) {
    ownLinks.at[kOwnLinks * beamEntry(beam) + number] = uvec2(projected, rangeBits);
    ++ownLinkCount;
  } else {
    link(beam, projected, rangeBits);
  }
}

// Keeps a triangle that a line within the beam's footprint may hit, and the triangle that it drives out of the word.
void offerFootprint(Triangle triangle, Prepared prepared, Turned turned, Beam beam, vec3 side, uint index,
                    uint projected) {
#ifdef INT64_ATOMICS
  uint stopped = words.at[beamEntry(index)].y;
  if (floatBitsToUint(triangle.rangeMin) > stopped) return;
  Stop stop = stopOf(triangle, prepared, turned, beam, side, index, stopped);
  uint nearest = floatBitsToUint(stop.least), farthest = floatBitsToUint(stop.farthest), driven = kNone;
  if (nearest > stopped) return;
  if (!stop.whole) {
    // Sub-rays that are all stopped already would only move the range at which they are stopped farther away.
    uvec2 covered = uvec2(covers.at[beamEntry(index)].lowRays, RAYS > 32 ? covers.at[beamEntry(index)].highRays : 0);
    farthest = (stop.rays & covered) != stop.rays ? rangeOfAll(index, stop.rays, stop.farthest) : kNone;
  }
  if (farthest <= stopped && farthest != kNone) {
    uvec2 word = uvec2(stop.whole ? projected : kNone, farthest);
    uint64_t had = atomicMin(words64.at[beamEntry(index)], packUint2x32(word));
    uvec2 before = uvec2(uint(had), uint(had >> 32));
    bool stays = before.y < word.y || (before.y == word.y && before.x < word.x);
    stopped = min(before.y, word.y);
    driven = stays ? kNone : before.x;
    if (stop.whole && !stays) projected = kNone;
  }
  if (projected != kNone && nearest <= stopped) linkFootprint(index, projected | paneBit, nearest);
  // The triangle that was in the word, which is no pane, may still matter.
  if (driven != kNone && floatBitsToUint(rangeMinOf(driven)) <= stopped)
    linkFootprint(index, driven, floatBitsToUint(rangeMinOf(driven)));
#endif
}
