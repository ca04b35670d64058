// SPDX-License-Identifier: Apache-2.0
// Keeps the triangles that the footprints of beams may meet. The word of a beam has a range beyond which no line of its
// footprint goes on, and the nearest triangle that stops all of them, if a single one does. All other triangles that may
// matter are in the beam's chain.

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
  if ((EFFECTS & kFootprint) == 0) return;
  litRays = uvec2(0);
#define LOAD_TANGENTS(s) loadTangents(s);
  EACH_RAY(LOAD_TANGENTS)
}

// Light goes on through holes and panes.
void lookAtSurface(uint projected) {
  if ((EFFECTS & kFootprint) == 0) return;
  stopsLight = true;
  paneBit = 0;
  if ((EFFECTS & kCutOuts) != 0) stopsLight = optics.at[projectedMaterials.at[projected]].passage.y <= 0.0;
  if (LAYERS > 1 && isPane(projected)) {
    stopsLight = false;
    paneBit = kPaneBit;
  }
}

// How the lines within the footprint of a beam meet a triangle.
struct Meeting {
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
  vec2 stray = (EFFECTS & kStrays) != 0 ? strays.at[index] : vec2(0.0);
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
Meeting meetingOf(Triangle triangle, Prepared prepared, Turned turned, Beam beam, vec3 side, uint index, uint stopped) {
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
  Meeting meeting;
  meeting.least = clear ? max(range * (sum / (sum + change)) - error, triangle.rangeMin) : triangle.rangeMin;
  meeting.farthest = max(range * (1.0 + spread * slope) * (1.0 + spread * spread) + error, triangle.rangeMin);
  meeting.whole = ends && inside && meeting.farthest <= window.y;
  meeting.rays = uvec2(0);
  if (meeting.whole) return meeting;
  meeting.farthest = min(meeting.farthest, prepared.farthest);
  bool facing = along < 0.0;
  bool nearer = floatBitsToUint(meeting.farthest) < stopped;
  if (ends && nearer && meeting.farthest <= window.y && (facing || !triangle.oneSided))
    meeting.rays = raysWithin(turned, beam, depth, side, !facing, index);
  return meeting;
}

// Adds sub-rays to those of a beam that are stopped. When that is true of all of them, returns the largest range at
// which, and kNone before.
uint rangeOfAll(uint index, uvec2 rays, float farthest) {
  atomicMax(covers.at[3 * index], floatBitsToUint(farthest));
  memoryBarrierBuffer();  // whoever sees the bits also sees the range
  rays.x |= atomicOr(covers.at[3 * index + 1], rays.x);
  if (RAYS > 32) rays.y |= atomicOr(covers.at[3 * index + 2], rays.y);
  memoryBarrierBuffer();
  return rays == litRays ? covers.at[3 * index] : kNone;
}

// Keeps a triangle that a line within the beam's footprint may hit, and the triangle that it drives out of the word.
void offerFootprint(Triangle triangle, Prepared prepared, Turned turned, Beam beam, vec3 side, uint index,
                    uint projected) {
#ifdef INT64_ATOMICS
  uint stopped = words.at[index].y;
  if (floatBitsToUint(triangle.rangeMin) > stopped) return;
  Meeting meeting = meetingOf(triangle, prepared, turned, beam, side, index, stopped);
  uint nearest = floatBitsToUint(meeting.least), farthest = floatBitsToUint(meeting.farthest), driven = kNone;
  if (nearest > stopped) return;
  if (!meeting.whole) {
    farthest = meeting.rays != uvec2(0) ? rangeOfAll(index, meeting.rays, meeting.farthest) : kNone;
  }
  if (farthest <= stopped && farthest != kNone) {
    uvec2 word = uvec2(meeting.whole ? projected : kNone, farthest);
    uint64_t had = atomicMin(words64.at[index], packUint2x32(word));
    uvec2 before = uvec2(uint(had), uint(had >> 32));
    bool stays = before.y < word.y || (before.y == word.y && before.x < word.x);
    stopped = min(before.y, word.y);
    driven = stays ? kNone : before.x;
    if (meeting.whole && !stays) projected = kNone;
  }
  if (projected != kNone && nearest <= stopped) link(index, projected | paneBit, nearest);
  // The triangle that was in the word, which is no pane, may still matter.
  if (driven != kNone && floatBitsToUint(rangeMinOf(driven)) <= stopped) link(index, driven, floatBitsToUint(rangeMinOf(driven)));
#endif
}
