// SPDX-License-Identifier: Apache-2.0
// Stage effects, first passes; they replace resolve. Find the hits of the sub-rays of each beam among its candidates,
// and combine them into echoes, one invocation per beam. The first pass handles the beams whose whole footprint lies on
// one triangle, which are most of them, and lists the others for two more passes: those whose light meets no pane, and
// those whose light may have to be followed through panes, layer by layer. Otherwise simple beams would wait for complex
// ones in their subgroup, and all of them would run the code of the last pass.
// There are places for RAYS sub-rays; unused ones carry no energy. In the later passes the lanes of a subgroup may share
// the sub-rays of one beam: then RAYS is the number of places of a lane, and spread_rays.glsl combines what lanes find.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_vote : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#ifdef INT64
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#endif
#include "common/shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "lanes.glsl"
#include "common/effects/vector.h"
#include "common/effects/intensity.h"
#include "common/effects/returns.h"
#include "views.glsl"
#include "motion.glsl"
#include "beam_place.glsl"
#include "inside.glsl"
#include "seen.glsl"
#include "owner.glsl"
#include "each_ray.glsl"
#include "spread_rays.glsl"
#include "echoes.glsl"
#include "panes.glsl"
#include "runs.glsl"
#include "left_beams.glsl"

layout(local_size_x = 64) in;

bool looksAtMaterials;
const float kNothing = 3e38;

// The exact inside test requires this function; this stage does not use that test.
float farthestOf(uint index) { return frame.rangeMax; }

// The sub-rays of a beam: tangents to the left and up, length of (1, left, up) and its inverse, original energy, the
// energy that reaches this layer, and the energy that passes through it.
float left[RAYS], up[RAYS], lengths[RAYS], inverses[RAYS], weights[RAYS], carried[RAYS], passed[RAYS];
// Their hits in this layer: range (kNothing if there is none, -1 for a sub-ray without light), share of the beam's
// energy, reach in depth (see slopeOf()), candidate, and the largest range that still belongs to the layer before.
float hitRanges[RAYS], hitShares[RAYS], hitReaches[RAYS], rangesBefore[RAYS];
uint hitCandidates[RAYS];
// The share of each sub-ray's light that the surface of the current candidate reflects.
float reflections[RAYS];
// Their hits in all layers. The first pass has one layer. Until the last layer is reached, its place holds the hits that
// end the light: the nearest opaque ones, with the shares that they reflect of the light that reaches them.
const uint kPieces = RAYS * kMaxLayers;
#define HELD_LAYERS (PASS == kPassFootprintWithinOne ? 1u : LAYERS)
#define LAST_LAYER (RAYS * (LAYERS - 1))
float ranges[kPieces], energies[kPieces], reaches[kPieces];
// The light that comes to each hit, for the medium's echoes between surfaces.
#define KEEPS_LIGHT ((EFFECTS & kMediumEffects) != 0)
float lights[kPieces];
uint metCandidates[kPieces];

#include "footprint_candidates.glsl"

// The sub-rays that hit a candidate in this search, one bit each. `hitAgain` is 0 if none of them hits a second one: light
// that has passed these panes then meets no other pane.
uvec2 raysHit;
uint hitAgain;

// Keeps a sub-ray's hit if it is the nearest one of this layer so far; of equally near ones the first triangle counts.
// Panes closer to each other, relative to their range, count as one: light through a shared edge hits both of its
// triangles, but they are not two panes.
bool offer(bool met, bool first, float range, uint projected, uint s) {
  bool behind = LAYERS == 1 || range > rangesBefore[s], nearer = range < hitRanges[s];
  bool taken = met && behind && (nearer || first);
  if (LAYERS > 1) {
    uint hit = met && behind ? 1u << (s & 31) : 0u;
    if (s < 32) {
      hitAgain |= raysHit.x & hit;
      raysHit.x |= hit;
    } else {
      hitAgain |= raysHit.y & hit;
      raysHit.y |= hit;
    }
  }
  hitRanges[s] = taken ? range : hitRanges[s];
  hitCandidates[s] = taken ? projected : hitCandidates[s];
  return taken;
}

// Computes which share of each sub-ray's light a surface reflects. There is no branch between sub-rays, so that a
// processor works on several at once.
void reflectEach(Optics4 surface, vec3 normal) {
#define REFLECT_ALL(s) reflections[s] = 1.0;
#define REFLECT_GLOSSILY(s) reflections[s] = reflectedGlossily(surface, cosineOf(normal, left[s], up[s], inverses[s]));
#define REFLECT_DIFFUSELY(s) reflections[s] = reflectedDiffusely(surface, cosineOf(normal, left[s], up[s], inverses[s]));
  if (!looksAtMaterials) {
    EACH_RAY(REFLECT_ALL)
  } else if (surface.reflection.y > 0.0) {
    EACH_RAY(REFLECT_GLOSSILY)
  } else {
    EACH_RAY(REFLECT_DIFFUSELY)
  }
}

// Returns how far the part of the footprint that a sub-ray stands for reaches in front of its hit and behind it on the
// plane of the surface, divided by the square of the hit's range. The reach is range * |tilt of the plane| / cosine of the
// incidence, and the cosine is the distance of the plane divided by the range. On a slope neighbouring sub-rays may lie
// farther apart than the separation of echoes, but the light between them fills the gap. `on` is a point of the plane.
float slopeOf(vec3 normal, vec3 on) {
  precise float across = normal.y * parameters.cellHorizontal, upwards = normal.z * parameters.cellVertical;
  precise float square = across * across + upwards * upwards;
  return quotient(squareRoot(square), max(abs(dotOf(normal, on)), 1e-30));
}

// Divides the light of a sub-ray that hits a candidate into what returns and what goes on. How much light reaches an
// opaque surface is not known before the panes.
void share(bool pane, float transmission, float slope, uint projected, uint s) {
  bool mine = hitCandidates[s] == projected;
  float energy = LAYERS == 1 || pane ? product(carried[s], reflections[s]) : reflections[s];
  if (LAYERS > 1) {
    float through = product(carried[s], transmission);
    passed[s] = mine ? through : passed[s];
    energy = pane && energy == 0.0 && through > 0.0 ? kUnseen : energy;
  }
  hitShares[s] = mine ? energy : hitShares[s];
  float reach = product(product(hitRanges[s], hitRanges[s]), slope);
  hitReaches[s] = mine ? reach : hitReaches[s];
}

// Returns the largest range of the hits of this layer; 0 if no sub-ray has light.
float farthestHit() {
  float farthest = 0.0;
#define FARTHEST(s) farthest = hitRanges[s] > farthest ? hitRanges[s] : farthest;
  EACH_RAY(FARTHEST)
  return mostOfBeam(farthest);
}

// Tries a candidate on every sub-ray. Returns the range beyond which further candidates cannot matter.
float consider(Candidate candidate, uint projected, bool pane, vec2 middle) {
  bool mask = false, taken = false;
  Optics4 holed;
  if ((EFFECTS & kCutOuts) != 0) {
    holed = optics.at[projectedMaterials.at[projected]];
    mask = holed.passage.y > 0.0;
  }
  Sides sides = sidesOf(candidate, middle);
  if (mask) sides = Sides(vec3(0.0), vec3(0.0), vec3(0.0), 1.0);  // the weights of the corners tell where holes are
  Plane plane = planeOf(candidate);
  uvec2 open = uvec2(0);  // one bit for each sub-ray that comes near an edge, or has a hit at the same range
  uint near;
  float range, side;
  bool met, first;
#define OFFER(s)                                                                      \
  side = sideOf(sides, left[s], up[s]);                                               \
  met = reach(candidate, plane, left[s], up[s], lengths[s], range);                   \
  near = side <= sides.doubt && (side >= -sides.doubt || range == hitRanges[s]) ? 1u << (s & 31) : 0u; \
  if (s < 32) open.x |= near; else open.y |= near;                                    \
  met = side < -sides.doubt && met;                                                   \
  taken = offer(met, false, range, projected, s) || taken;
  EACH_RAY(OFFER)
  // Few sub-rays are undecided, and code that is seldom executed stays out of the loop above.
  if (open != uvec2(0)) {
    vec3 weights_;
#define OFFER_OPEN(s)                                                                                     \
  if (((s < 32 ? open.x : open.y) >> (s & 31) & 1u) != 0) {                                               \
    met = reach(candidate, plane, left[s], up[s], lengths[s], range);                                     \
    met = isInside(candidate, left[s], up[s], weights_) && met;                                           \
    if ((EFFECTS & kCutOuts) != 0 && met && mask) met = !isHole(holed, textureCornersOf(projected), weights_); \
    first = false;                                                                                        \
    if (met && range == hitRanges[s]) first = candidate.id < idOf(hitCandidates[s]);                      \
    taken = offer(met, first, range, projected, s) || taken;                                              \
  }
    EACH_RAY(OFFER_OPEN)
  }
  float farthest = farthestHit();
  if (taken) {
    Optics4 surface = optics.at[projectedMaterials.at[projected]];
    vec3 corner = vec3(candidate.ahead.x, candidate.left.x, candidate.up.x);
    vec3 normal = unitTowardsOrigin(plane.normal, corner);
    reflectEach(surface, normal);
    float transmission = LAYERS > 1 ? transmitted(surface) : 0.0, slope = slopeOf(normal, corner);
#define SHARE(s) share(pane, transmission, slope, projected, s);
    EACH_RAY(SHARE)
  }
  return farthest;
}

void forget() {
#define FORGET(s)                                    \
  hitRanges[s] = carried[s] > 0.0 ? kNothing : -1.0; \
  hitShares[s] = 0.0;                                \
  hitReaches[s] = 0.0;                               \
  hitCandidates[s] = kNone;                          \
  passed[s] = 0.0;
  EACH_RAY(FORGET)
}

// Keeps the hits that end the light.
void keepEnds() {
#define KEEP_END(s)                                   \
  ranges[LAST_LAYER + s] = hitRanges[s];              \
  energies[LAST_LAYER + s] = hitShares[s];            \
  reaches[LAST_LAYER + s] = hitReaches[s];            \
  metCandidates[LAST_LAYER + s] = hitCandidates[s];
  EACH_RAY(KEEP_END)
}

// Begins a layer with the hits that end the light. Where a nearer surface has ended it, the layer has no hit, and nothing
// reaches along an echo.
void beginLayer() {
#define BEGIN(s)                                                                  \
  hitRanges[s] = carried[s] > 0.0 ? ranges[LAST_LAYER + s] : -1.0;                \
  hitShares[s] = product(carried[s], energies[LAST_LAYER + s]);                   \
  hitReaches[s] = carried[s] > 0.0 ? reaches[LAST_LAYER + s] : 0.0;               \
  hitCandidates[s] = carried[s] > 0.0 ? metCandidates[LAST_LAYER + s] : kNone;    \
  passed[s] = 0.0;
  EACH_RAY(BEGIN)
}

// Chooses the pass and the class of a beam that the first pass does not finish.
uvec2 leftTo(uint index, Beam beam) {
  vec2 middle = (EFFECTS & kStrays) != 0 ? strays.at[beamEntry(index)] : vec2(0.0);
  float end = endOf(index);
  bool meetsPane = false;  // whether light may meet a pane before the triangle that stops all of it, if there is one
  uint count = 0;
  for (uint k = listFirst; k != listEnd; k = nextOf(k)) {
    if (nearestAt(k) > end) continue;
    ++count;
    if (LAYERS > 1 && !meetsPane && isPaneAt(k))
      meetsPane = touchesFootprint(candidateOf(projectedAt(k), beam), middle);
  }
  return uvec2(meetsPane ? kPassFootprintPanesToo : kPassFootprintOthers, effortOf(count));
}

// Finds the nearest hits on panes, or on all other surfaces. Skips candidates behind all hits or behind the end of the
// light. The search for the other surfaces keeps the panes that light may meet; searches for panes look at these alone.
// Each lane first searches for the next candidate that it must try, so that the lanes of a subgroup try their candidates
// together.
void findHits(uint index, Beam beam, bool panes) {
  vec2 middle = (EFFECTS & kStrays) != 0 ? strays.at[beamEntry(index)] : vec2(0.0);
  uint k = panes ? afterWord : listFirst, until = panes ? panesEnd : listEnd;
  if (!panes) panesEnd = afterWord;
  if (LAYERS > 1 && SPREAD_RAYS > 0) meetAgain();  // all lanes see the panes that one of them has kept
  raysHit = uvec2(0);
  hitAgain = 0;
  float end = endOf(index), farthest = min(farthestHit(), end);
  while (k != until) {
    uint projected = kNone;
    Candidate candidate;
    while (k != until && projected == kNone) {
      if (nearestAt(k) <= farthest) {
        candidate = candidateOf(projectedAt(k), beam);
        bool touches = panes || touchesFootprint(candidate, middle);
        if (LAYERS > 1 && !panes && isPaneAt(k)) {
          if (touches) keepPane(k);
        } else if (touches) {
          projected = projectedAt(k);
        }
      } else if (LAYERS > 1) {
        hitAgain = 1;
      }
      k = nextOf(k);
    }
    if (projected != kNone) farthest = consider(candidate, projected, panes, middle);
  }
  hitAgain = anyOfBeam(hitAgain != 0) ? 1 : 0;
}

// Keeps the hits of a layer. Arrays that are indexed by a number that a loop counts lie in memory, so each layer has
// code of its own; this is all that differs between them.
void keepLayer(uint layer) {
  [[unroll]] for (uint held = 0; held < LAYERS; ++held) {
#define KEEP_HIT(s)                                \
  ranges[held * RAYS + s] = hitRanges[s];            \
  energies[held * RAYS + s] = hitShares[s];           \
  reaches[held * RAYS + s] = hitReaches[s];           \
  if (KEEPS_LIGHT) lights[held * RAYS + s] = carried[s]; \
  metCandidates[held * RAYS + s] = hitCandidates[s];
    if (held == layer) {
      EACH_RAY(KEEP_HIT)
    }
  }
}

// Returns the largest range that is not clearly behind a pane.
float endOfPane(float range) {
  precise float end = range * (1.0 + 9.5367431640625e-7);
  return end;
}

// Passes the remaining light on to the next layer. Returns whether there is any.
bool goOn() {
  bool any = false;
#define GO_ON(s)                                         \
  rangesBefore[s] = endOfPane(hitRanges[s]);                       \
  carried[s] = hitRanges[s] < kNothing ? passed[s] : 0.0; \
  any = any || carried[s] > 0.0;
  EACH_RAY(GO_ON)
  return anyOfBeam(any);
}

#include "footprint_echoes.glsl"

// Follows the light of a beam from layer to layer, and gathers its echoes. Opaque surfaces are searched once; they end
// light, however close they are to a pane.
void follow(uint index, uint beam, Beam axis) {
#define NONE_BEFORE(s) rangesBefore[s] = 0.0;
  EACH_RAY(NONE_BEFORE)
  forget();
  bool lit = true;
  // All searches share one loop, because their code is long.
  [[dont_unroll]] for (uint search = 0; search <= LAYERS && lit; ++search) {
    if (search > 0) beginLayer();
    if (search < 2 || hitAgain != 0) findHits(index, axis, search > 0);
    if (LAYERS == 1) {
      keepLayer(0);
      lit = false;
    } else if (search == 0) {
      keepEnds();
    } else {
      keepLayer(search - 1);
      lit = goOn();
      layersMet = search;
    }
  }
  if (LAYERS > 1 && lit && speaksForBeam()) atomicAdd(counters.lostEchoes, 1);
  gatherEchoes(index, beam);
}

#include "footprint_within_one.glsl"

// Returns the tangents, the energy and the length of the sub-ray at a place. A place without one has no energy.
vec4 subRayAt(uint place) {
  vec4 subRay = vec4(0.0, 0.0, 0.0, 1.0);
  if (SPREAD_RAYS == 0 || numberOfRay(place) < SPREAD_RAYS) subRay = subRays.at[numberOfRay(place)];
  return subRay;
}

// Loads a sub-ray of the footprint, which is the same for every beam; shift() moves it if angle noise deflects the
// beam.
void loadSubRay(uint s) {
  vec4 subRay = subRayAt(s);
  left[s] = subRay.x;
  up[s] = subRay.y;
  weights[s] = subRay.z;
  lengths[s] = subRay.w;
  inverses[s] = quotient(1.0, subRay.w);
}

void shift(uint s, vec2 by) {
  vec4 subRay = subRayAt(s);
  left[s] = sumOf(subRay.x, by.x);
  up[s] = sumOf(subRay.y, by.y);
  lengths[s] = lengthOf(left[s], up[s]);
  inverses[s] = quotient(1.0, lengths[s]);
}

void aim(uint index) {
  if ((EFFECTS & kStrays) != 0) {
    vec2 stray = strays.at[beamEntry(index)];
#define SHIFT(s) shift(s, stray);
    EACH_RAY(SHIFT)
  }
#define LIGHT(s) carried[s] = weights[s];
  EACH_RAY(LIGHT)
}

// Finishes a beam, or lists it for a later pass.
void finish(uint entry) {
  uint index = enterView(entry);
  uint number = numberOf(index);
  if (number != kNone) {
    Beam axis = beamWith(index);
    vec2 window = rangesOf(index);
    rangeMin = NUMBERED && frame.hidesNear != 0 ? 0.0 : window.x;
    rangeMax = window.y;
    loadPlaceOfBeam(rowOf(index), columnOf(index), axis.azimuth);
    openList(index);
    aim(index);
    if (PASS != kPassFootprintWithinOne)
      follow(index, number, axis);
    else if (!findWithinOne(index, number, axis))
      leave(index, leftTo(index, axis));
  }
}

void main() {
  useOwnAddresses();
  loadMotion();
#define LOAD(s) loadSubRay(s);
  EACH_RAY(LOAD)
  halfAxes = vec2(1e-9);
  float beyond = 1.0;  // square of how far sub-rays reach beyond an ellipse with these axes
#define REACH(s) \
  if (weights[s] > 0.0) halfAxes = max(halfAxes, vec2(abs(left[s]), abs(up[s])));
  EACH_RAY(REACH)
  halfAxes = vec2(mostOfBeam(halfAxes.x), mostOfBeam(halfAxes.y));
#define BEYOND(s) \
  if (weights[s] > 0.0) beyond = max(beyond, dot(vec2(left[s], up[s]) / halfAxes, vec2(left[s], up[s]) / halfAxes));
  EACH_RAY(BEYOND)
  beyond = mostOfBeam(beyond);
  halfAxes *= sqrt(beyond);
  looksAtMaterials = (EFFECTS & kIntensity) != 0 && parameters.intensityModel == kModelPhysical;
  if (SPREAD_RAYS > 0) {  // the beams with the most candidates are the first of all subgroups
    uint count = leftBeams(), subgroups = pass.groups * gl_NumSubgroups;
    for (uint i = subgroupOfStep(); i < count; i += subgroups) finish(leftBeam(i));
    return;
  }
  uvec2 run = runOf(PASS == kPassFootprintWithinOne ? beamsOfViews() : leftBeams());
  for (uint first = run.x; first < run.y; first += gl_SubgroupSize) {
    uint i = first + gl_SubgroupInvocationID;
    if (i < run.y) finish(PASS == kPassFootprintWithinOne ? i : leftBeam(i));
  }
}
