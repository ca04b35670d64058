// SPDX-License-Identifier: Apache-2.0
// Stage effects, first passes; they replace resolve. Find the hits of the sub-rays of each beam among its candidates,
// and combine them into echoes, one invocation per beam. The first pass handles the beams whose whole footprint lies on
// one triangle, which are most of them, and lists the others for two more passes: those whose light meets no pane, and
// those whose light may have to be followed through panes, layer by layer. Otherwise simple beams would wait for complex
// ones in their subgroup, and all of them would run the code of the last pass.
// There are places for RAYS sub-rays; unused ones carry no energy.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_ballot : require
#include "shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "effects/vector.h"
#include "effects/intensity.h"
#include "effects/returns.h"
#include "motion.glsl"
#include "inside.glsl"
#include "seen.glsl"
#include "owner.glsl"
#include "each_ray.glsl"
#include "echoes.glsl"
#include "panes.glsl"
#include "lanes.glsl"
#include "runs.glsl"

layout(local_size_x = 64) in;

bool looksAtMaterials;
const float kNothing = 3e38;

// The exact inside test requires this function; this stage does not use that test.
float farthestOf(uint index) { return frame.rangeMax; }

// The sub-rays of a beam: tangents to the left and up, length of (1, left, up), original energy, the energy that
// reaches this layer, and the energy that passes through it.
float left[RAYS], up[RAYS], lengths[RAYS], weights[RAYS], carried[RAYS], passed[RAYS];
// Their hits in this layer: range (kNothing if there is none), share of the beam's energy, placed triangle, candidate,
// and the range in the layer before.
float hitRanges[RAYS], hitShares[RAYS], rangesBefore[RAYS];
uint hitIds[RAYS], hitCandidates[RAYS];
// Their hits in all layers. The first pass has one layer.
const uint kPieces = RAYS * kMaxLayers;
#define HELD_LAYERS (PASS == kPassWithinOne ? 1u : LAYERS)
float ranges[kPieces], energies[kPieces];
uint metCandidates[kPieces];

#include "footprint_candidates.glsl"

// True if the range is clearly beyond the sub-ray's hit in the previous layer. Panes closer to each other, relative to
// their range, count as one: light through a shared edge hits both of its triangles, but they are not two panes.
bool isBehind(float range, uint s) {
  precise float end = rangesBefore[s] * (1.0 + 9.5367431640625e-7);
  return range > end;
}

// Keeps a sub-ray's hit if it is the nearest one of this layer so far. An opaque hit counts however close to a pane.
void offer(bool met, float range, uint id, uint projected, bool opaque, uint s) {
  bool lit = carried[s] > 0.0, nearer = range < hitRanges[s], even = range == hitRanges[s];
  bool first = id < hitIds[s], behind = true;
  if (LAYERS > 1) behind = opaque || isBehind(range, s);
  bool taken = met && lit && behind && (nearer || (even && first));
  hitRanges[s] = taken ? range : hitRanges[s];
  hitIds[s] = taken ? id : hitIds[s];
  hitCandidates[s] = taken ? projected : hitCandidates[s];
}

// Computes how much of a sub-ray's light a surface reflects and how much it transmits.
void share(Optics4 surface, vec3 normal, uint projected, uint s) {
  if (hitCandidates[s] != projected) return;
  float energy = carried[s];
  if (looksAtMaterials) energy = product(energy, reflected(surface, cosineOf(normal, left[s], up[s], lengths[s])));
  hitShares[s] = energy;
  if (LAYERS > 1) {
    passed[s] = product(carried[s], transmitted(surface));
    if (energy == 0.0 && passed[s] > 0.0) hitShares[s] = kUnseen;
  }
}

// Tries a candidate on every sub-ray. Returns the range beyond which further candidates cannot matter.
float consider(Candidate candidate, uint projected) {
  float farthest = 0.0;
  float range;
  bool met, mask = false;
  vec3 side;
  Optics4 holed;
  if ((EFFECTS & kCutOuts) != 0) {
    holed = optics.at[projectedMaterials.at[projected]];
    mask = holed.passage.y > 0.0;
  }
  bool opaque = LAYERS > 1 && !isPane(projected);
  // The same formula as in the first pass, so that no other candidate of the list can change a bit of the range.
  bool whole = !mask && coversFootprint(candidate);
  vec4 plane = planeOf(candidate);
#define OFFER(s)                                                                       \
  if (whole)                                                                           \
    met = meetPlane(candidate, plane, left[s], up[s], lengths[s], range);              \
  else                                                                                 \
    met = meetSubRay(candidate, left[s], up[s], lengths[s], range, side);              \
  if ((EFFECTS & kCutOuts) != 0 && met && mask) met = !isHole(holed, textureCornersOf(projected), side); \
  offer(met, range, candidate.id, projected, opaque, s);
  EACH_RAY(OFFER)
  bool taken = false, mine;
#define FARTHEST(s)                                            \
  farthest = max(farthest, carried[s] > 0.0 ? hitRanges[s] : 0.0); \
  mine = hitCandidates[s] == projected;                    \
  taken = taken || mine;
  EACH_RAY(FARTHEST)
  if (!taken) return farthest;
  Optics4 surface = optics.at[projectedMaterials.at[projected]];
  vec3 normal = unitTowardsOrigin(plane.xyz, vec3(candidate.ahead.x, candidate.left.x, candidate.up.x));
#define SHARE(s) share(surface, normal, projected, s);
  EACH_RAY(SHARE)
  return farthest;
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

void forget() {
#define FORGET(s)               \
  hitRanges[s] = kNothing;        \
  hitShares[s] = 0.0;              \
  hitIds[s] = kNone;        \
  hitCandidates[s] = kNone; \
  passed[s] = 0.0;
  EACH_RAY(FORGET)
}

// True if light of the beam may meet a pane before the triangle that stops all of it, if there is one.
bool meetsPane(uint index, Beam beam) {
  if (LAYERS == 1) return false;
  vec2 middle = (EFFECTS & kStrays) != 0 ? strays.at[index] : vec2(0.0);
  float end = endOf(index);
  bool meets = false;
  for (uint k = listFirst; k != listEnd && !meets; k = nextOf(k)) {
    uint projected = projectedAt(k);
    if (nearestAt(k) <= end && isPane(projected)) meets = touchesFootprint(candidateOf(projected, beam), middle);
  }
  return meets;
}

// Tries the nearest candidate first, as resolve does, and skips candidates behind all hits or behind
// the end of the light. Each lane first searches
// for the next candidate that it must try, so that the lanes of a subgroup try their candidates together.
void findLayer(uint index, Beam beam) {
  forget();
  vec2 middle = (EFFECTS & kStrays) != 0 ? strays.at[index] : vec2(0.0);
  uint best = bestOf(), k = best, next = listFirst;
  float farthest = endOf(index);
  while (k != listEnd) {
    uint projected = kNone;
    Candidate candidate;
    while (k != listEnd && projected == kNone) {
      if (nearestAt(k) <= farthest) {
        candidate = candidateOf(projectedAt(k), beam);
        if (touchesFootprint(candidate, middle)) projected = projectedAt(k);
      }
      k = next == best ? nextOf(next) : next;  // the best one comes first, and only once
      if (k != listEnd) next = nextOf(k);
    }
    if (projected != kNone) farthest = consider(candidate, projected);
  }
}

// Keeps the hits of a layer. Arrays that are indexed by a number that a loop counts lie in memory, so each layer has
// code of its own; this is all that differs between them.
void keepLayer(uint layer) {
  [[unroll]] for (uint held = 0; held < LAYERS; ++held) {
#define KEEP_HIT(s)                                \
  ranges[held * RAYS + s] = hitRanges[s];            \
  energies[held * RAYS + s] = hitShares[s];           \
  metCandidates[held * RAYS + s] = hitCandidates[s];
    if (held == layer) {
      EACH_RAY(KEEP_HIT)
    }
  }
}

// Passes the remaining light on to the next layer. Returns whether there is any.
bool goOn() {
  bool any = false;
#define GO_ON(s)                                         \
  rangesBefore[s] = hitRanges[s];                                \
  carried[s] = hitRanges[s] < kNothing ? passed[s] : 0.0; \
  any = any || carried[s] > 0.0;
  EACH_RAY(GO_ON)
  return any;
}

float nextRange(float after) {
  float least = kNothing;
  [[unroll]] for (uint layer = 0; layer < HELD_LAYERS; ++layer) {
#define NEXT(s) \
  if (ranges[layer * RAYS + s] > after && energies[layer * RAYS + s] >= 0.0) least = min(least, ranges[layer * RAYS + s]);
    EACH_RAY(NEXT)
  }
  return least;
}

// Returns the farthest range of the echo that starts at `first`. Hits whose ranges differ by at most the separation
// from the next belong to one echo.
float endOfEcho(float first) {
  float end = first, before, last = 0.0;
  [[unroll]] for (uint layer = 0; layer < HELD_LAYERS; ++layer) {
#define LAST(s) \
  last = max(last, ranges[layer * RAYS + s] < kNothing && energies[layer * RAYS + s] >= 0.0 ? ranges[layer * RAYS + s] : 0.0);
    EACH_RAY(LAST)
  }
  if (last <= sumOf(first, parameters.separation)) return last;
  do {
    before = end;
    float reach = sumOf(end, parameters.separation);
    [[unroll]] for (uint layer = 0; layer < HELD_LAYERS; ++layer) {
#define FOLLOW(s) \
  if (ranges[layer * RAYS + s] <= reach && energies[layer * RAYS + s] >= 0.0) end = max(end, ranges[layer * RAYS + s]);
      EACH_RAY(FOLLOW)
    }
  } while (end > before);
  return end;
}

void storeEcho(uint slot, vec3 echo, uint projected) {
  echoes.at[slot] = vec4(echo, 1.0);
  echoOwners.at[slot] = ownerOf(idOf(projected));
  if ((FIELDS & kFieldSurface) != 0) {
    Triangle triangle = triangleAt(projected);
    vec3 normal = normalOf(triangle.a, triangle.b, triangle.c);
    if (MOTION) normal = reportedDirection(beamRow, beamColumn, normal);
    echoSurfaces.at[slot] = SurfaceRecord(normal, projectedMaterials.at[projected]);
  }
}

// The owner of an echo is its strongest hit, and the first one of equally strong hits.
void addTo(inout vec3 sums, inout float most, inout uint strongest, float first, float end, uint piece) {
  bool from = ranges[piece] >= first, to = ranges[piece] <= end, counts = energies[piece] >= 0.0;
  bool taken = from && to && counts;
  vec3 more = sums;
  addPiece(more, energies[piece], sumOf(ranges[piece], -first));
  sums = taken ? more : sums;
  bool stronger = taken && energies[piece] > most;
  most = stronger ? energies[piece] : most;
  strongest = stronger ? metCandidates[piece] : strongest;
}

void gatherEchoes(uint index, uint beam) {
  uint count = 0;
  float first = nextRange(0.0);
  while (first < kNothing) {
    if (count == kMaxEchoes) {
      atomicAdd(counters.lostEchoes, 1);
      break;
    }
    float end = endOfEcho(first), most = -1.0;
    uint strongest = 0;
    vec3 sums = vec3(0.0);
    [[unroll]] for (uint layer = 0; layer < HELD_LAYERS; ++layer) {
#define ADD(s) addTo(sums, most, strongest, first, end, layer * RAYS + s);
      EACH_RAY(ADD)
    }
    storeEcho(echoPlace(index, count), echoOf(first, sums), strongest);
    ++count;
    first = nextRange(end);
  }
  echoCounts.at[beam] = count;
}

// Follows the light of a beam from layer to layer, and gathers its echoes.
void follow(uint index, uint beam, Beam axis) {
  if (LAYERS > 1) {
    [[unroll]] for (uint layer = 0; layer < LAYERS; ++layer) {
#define NO_HIT(s) ranges[layer * RAYS + s] = kNothing;
      EACH_RAY(NO_HIT)
    }
  }
#define NONE_BEFORE(s) rangesBefore[s] = 0.0;
  EACH_RAY(NONE_BEFORE)
  bool lit = true;
  [[dont_unroll]] for (uint layer = 0; layer < LAYERS && lit; ++layer) {
    findLayer(index, axis);
    keepLayer(layer);
    lit = goOn();
  }
  if (LAYERS > 1 && lit) atomicAdd(counters.lostEchoes, 1);
  gatherEchoes(index, beam);
}

#include "footprint_within_one.glsl"

// Loads a sub-ray of the footprint, which is the same for every beam; shift() moves it if angle noise deflects the
// beam.
void loadSubRay(uint s) {
  vec4 subRay = subRays.at[s];
  left[s] = subRay.x;
  up[s] = subRay.y;
  weights[s] = subRay.z;
  lengths[s] = subRay.w;
}

void shift(uint s, vec2 by) {
  vec4 subRay = subRays.at[s];
  left[s] = sumOf(subRay.x, by.x);
  up[s] = sumOf(subRay.y, by.y);
  lengths[s] = lengthOf(left[s], up[s]);
}

void aim(uint index) {
  if ((EFFECTS & kStrays) != 0) {
    vec2 stray = strays.at[index];
#define SHIFT(s) shift(s, stray);
    EACH_RAY(SHIFT)
  }
#define LIGHT(s) carried[s] = weights[s];
  EACH_RAY(LIGHT)
}

// Returns the pass in which the beam is finished.
uint finish(uint index) {
  uint number = numberOf(index);
  if (MAPPED && number == kNone) return PASS;
  beamRow = rowOf(index);
  beamColumn = columnOf(index);
  Beam axis = beamWith(index);
  vec2 window = rangesOf(index);
  rangeMin = NUMBERED && frame.hidesNear != 0 ? 0.0 : window.x;
  rangeMax = window.y;
  loadPlaceOfBeam(axis.azimuth);
  openList(index);
  aim(index);
  if (PASS != kPassWithinOne) {
    follow(index, number, axis);
    return PASS;
  }
  if (findWithinOne(index, number, axis)) return kPassWithinOne;
  return meetsPane(index, axis) ? kPassPanesToo : kPassOthers;
}

// Lists the beams of a subgroup that are left to the two passes. All lanes of the subgroup must call this.
void leave(uint index, uint toPass) {
  uvec4 others = subgroupBallot(toPass == kPassOthers), panes = subgroupBallot(toPass == kPassPanesToo);
  uint slot = 0, paneSlot = 0;
  if (subgroupElect()) {
    slot = atomicAdd(counters.hardBeams, subgroupBallotBitCount(others));
    if (LAYERS > 1) paneSlot = atomicAdd(counters.paneBeams, subgroupBallotBitCount(panes));
  }
  slot = slotAfter(slot, others);
  paneSlot = slotAfter(paneSlot, panes);
  if (toPass == kPassOthers) hardBeams.at[slot] = index;
  if (toPass == kPassPanesToo) hardBeams.at[frame.beams - 1 - paneSlot] = index;
}

void main() {
  loadMotion();
#define LOAD(s) loadSubRay(s);
  EACH_RAY(LOAD)
  halfAxes = vec2(1e-9);
  float beyond = 1.0;  // square of how far sub-rays reach beyond an ellipse with these axes
#define REACH(s) \
  if (weights[s] > 0.0) halfAxes = max(halfAxes, vec2(abs(left[s]), abs(up[s])));
  EACH_RAY(REACH)
#define BEYOND(s) \
  if (weights[s] > 0.0) beyond = max(beyond, dot(vec2(left[s], up[s]) / halfAxes, vec2(left[s], up[s]) / halfAxes));
  EACH_RAY(BEYOND)
  halfAxes *= sqrt(beyond);
  looksAtMaterials = (EFFECTS & kIntensity) != 0 && parameters.intensityModel == kModelPhysical;
  uint beams = frame.beams;
  if (PASS == kPassOthers) beams = counters.hardBeams;
  if (PASS == kPassPanesToo) beams = counters.paneBeams;
  uvec2 run = runOf(beams);
  for (uint first = run.x; first < run.y; first += gl_SubgroupSize) {
    uint i = first + gl_SubgroupInvocationID, index = i, toPass = PASS;
    if (i < run.y) {
      if (PASS == kPassOthers) index = hardBeams.at[i];
      if (PASS == kPassPanesToo) index = hardBeams.at[frame.beams - 1 - i];
      toPass = finish(index);
    }
    if (PASS != kPassWithinOne) continue;
    meetAgain();  // the lanes have walked through lists of different lengths
    leave(index, toPass);
  }
}
