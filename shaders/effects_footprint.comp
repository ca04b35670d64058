// SPDX-License-Identifier: Apache-2.0
// Stage effects, first pass; it replaces resolve. One invocation per beam: finds the hits of the beam's sub-rays among
// its candidates, then combines them into echoes. The first pass handles the beams whose whole footprint lies on one
// triangle, which are most of them, and lists the others for the second pass; otherwise simple beams would wait for
// complex ones in their subgroup. There are places for RAYS sub-rays; unused ones carry no energy.
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
// The hits of the sub-rays, layer by layer: range (kNothing if there is none), share of the beam's energy, placed
// triangle and candidate.
const uint kPieces = RAYS * kMaxLayers;
float ranges[kPieces], energies[kPieces];
uint metIds[kPieces], metCandidates[kPieces];

uint idOf(uint projected) { return projectedA.at[projected].tag & 0x7fffffffu; }

// A candidate in the beam's own frame: one component per corner.
struct Candidate {
  vec3 ahead, left, up;
  float rangeMin;
  uint id;
  bool oneSided;
};

uint beamRow, beamColumn;

// Returns a projected triangle in the frame of the beam's laser.
Triangle triangleAt(uint projected, vec2 azimuth) {
  Triangle triangle = loadProjected(projected);
  if (MOTION) triangle = seenFrom(triangle, projected, beamColumn, beamRow, azimuth);
  return triangle;
}

Candidate candidateOf(uint projected, Beam beam) {
  Triangle triangle = triangleAt(projected, beam.azimuth);
  Turned turned = turn(triangle, beam.azimuth);
  precise vec3 above = turned.z * beam.cosElevation - turned.p * beam.sinElevation;
  return Candidate(cornerDepths(turned, beam.cosElevation, beam.sinElevation), turned.q, above, triangle.rangeMin,
                   triangle.id, triangle.oneSided);
}

vec3 normalOf(vec3 a, vec3 b, vec3 c) {
  precise vec3 u = b - a;
  precise vec3 v = c - a;
  return unitTowardsOrigin(crossOf(u, v), a);
}

// Code that runs for every sub-ray has no branches; it combines computed booleans with && and ||.
float rangeMin, rangeMax;

// A watertight test as in inside_watertight.glsl: sub-ray (1, u, v) shears every corner by the same operations.
bool meetSubRay(Candidate candidate, float u, float v, float length_, out float range, out vec3 side) {
  precise vec3 q = candidate.left - u * candidate.ahead;
  precise vec3 w = candidate.up - v * candidate.ahead;
  precise vec3 sides = q.yzx * w.zxy - w.yzx * q.zxy;
  side = sides;
  precise float sum = side.x + side.y + side.z;
  precise float weighted = side.x * candidate.ahead.x + side.y * candidate.ahead.y + side.z * candidate.ahead.z;
  bool facing = all(lessThanEqual(side, vec3(0.0)));
  bool averted = all(greaterThanEqual(side, vec3(0.0)));
  precise float along = quotient(weighted, sum) * length_;
  range = max(along, candidate.rangeMin);
  bool bothSided = !candidate.oneSided, ahead = along > 0.0, flat_ = sum == 0.0;
  bool near = range >= rangeMin, far = range <= rangeMax;
  bool seen = facing || (averted && bothSided);
  bool around = !MOTION || surrounds(q, w);
  return seen && around && !flat_ && ahead && near && far;
}

// The supporting plane in the beam's frame: a normal that is not normalised, and the plane's distance times its
// length.
vec4 planeOf(Candidate c) {
  vec3 a = vec3(c.ahead.x, c.left.x, c.up.x), b = vec3(c.ahead.y, c.left.y, c.up.y);
  precise vec3 u = b - a;
  precise vec3 v = vec3(c.ahead.z, c.left.z, c.up.z) - a;
  vec3 normal = crossOf(u, v);
  return vec4(normal, dotOf(normal, a));
}

// True if the whole footprint lies within the triangle: the beam's axis is farther from the plane of each edge than
// the footprint reaches.
bool coversFootprint(Candidate c) {
  precise vec3 side = c.left.yzx * c.up.zxy - c.up.yzx * c.left.zxy;
  precise vec3 second = c.up.yzx * c.ahead.zxy - c.ahead.yzx * c.up.zxy;
  precise vec3 third = c.ahead.yzx * c.left.zxy - c.left.yzx * c.ahead.zxy;
  precise vec3 square = side * side;
  precise vec3 reach = (square + second * second + third * third) * (frame.footprint * frame.footprint * 1.01 + 1e-12);
  bool facing = all(lessThan(side, vec3(0.0)));
  bool averted = all(greaterThan(side, vec3(0.0)));
  return (facing || (averted && !c.oneSided)) && all(greaterThan(square, reach));
}

// Like meetSubRay(), for a triangle that contains the whole footprint: only the range is tested.
bool meetPlane(Candidate candidate, vec4 plane, float u, float v, float length_, out float range) {
  precise float along = plane.x + u * plane.y + v * plane.z;
  precise float depth = quotient(plane.w, along) * length_;
  range = max(depth, candidate.rangeMin);
  bool ahead = depth > 0.0, near = range >= rangeMin, far = range <= rangeMax;
  return ahead && near && far;
}

// Returns the cosine of a sub-ray's incidence on a surface whose normal is given as (ahead, left, up).
float cosineOf(vec3 normal, float u, float v, float length_) {
  precise float along = normal.x + u * normal.y + v * normal.z;
  return min(abs(quotient(along, length_)), 1.0);
}

// True if the range is clearly beyond the sub-ray's hit in the previous layer. Surfaces closer to each other, relative
// to their range, count as one: light through a shared edge hits both of its triangles, but they are not two panes.
bool isBehind(float range, uint piece) {
  precise float before = ranges[piece] * (1.0 + 9.5367431640625e-7);
  return range > before;
}

// Keeps a sub-ray's hit if it is the nearest one of this layer so far.
void offer(bool met, float range, uint id, uint projected, uint layer, uint s) {
  uint piece = layer * RAYS + s;
  bool lit = carried[s] > 0.0, nearer = range < ranges[piece], even = range == ranges[piece];
  bool first = id < metIds[piece], behind = true;
  if (layer > 0) behind = isBehind(range, piece - RAYS);
  bool taken = met && lit && behind && (nearer || (even && first));
  ranges[piece] = taken ? range : ranges[piece];
  metIds[piece] = taken ? id : metIds[piece];
  metCandidates[piece] = taken ? projected : metCandidates[piece];
}

// Computes how much of a sub-ray's light a surface reflects and how much it transmits.
void share(Optics4 surface, vec3 normal, uint projected, uint layer, uint s) {
  if (metCandidates[layer * RAYS + s] != projected) return;
  float energy = carried[s];
  if (looksAtMaterials) energy = product(energy, reflected(surface, cosineOf(normal, left[s], up[s], lengths[s])));
  energies[layer * RAYS + s] = energy;
  if (LAYERS > 1) {
    passed[s] = product(carried[s], transmitted(surface));
    if (energy == 0.0 && passed[s] > 0.0) energies[layer * RAYS + s] = kUnseen;
  }
}

// Tries a candidate on every sub-ray. Returns the range beyond which further candidates cannot matter.
float consider(uint projected, Beam beam, uint layer) {
  Candidate candidate = candidateOf(projected, beam);
  float farthest = 0.0;
  float range;
  bool met, mask = false;
  vec3 side;
  Optics4 holed;
  if ((EFFECTS & kCutOuts) != 0) {
    holed = optics.at[projectedMaterials.at[projected]];
    mask = holed.passage.y > 0.0;
  }
#define OFFER(s)                                                                       \
  met = meetSubRay(candidate, left[s], up[s], lengths[s], range, side);                \
  if ((EFFECTS & kCutOuts) != 0 && met && mask) met = !isHole(holed, projected, side); \
  offer(met, range, candidate.id, projected, layer, s);
  EACH_RAY(OFFER)
  bool taken = false, mine;
#define FARTHEST(s)                                                                \
  farthest = max(farthest, carried[s] > 0.0 ? ranges[layer * RAYS + s] : 0.0); \
  mine = metCandidates[layer * RAYS + s] == projected;                           \
  taken = taken || mine;
  EACH_RAY(FARTHEST)
  if (!taken) return farthest;
  Optics4 surface = optics.at[projectedMaterials.at[projected]];
  vec3 normal = unitTowardsOrigin(planeOf(candidate).xyz, vec3(candidate.ahead.x, candidate.left.x, candidate.up.x));
#define SHARE(s) share(surface, normal, projected, layer, s);
  EACH_RAY(SHARE)
  return farthest;
}

// Returns the index of the candidate that comes nearest to the sensor, most likely the hit; kNone if there is none.
uint bestOf(uint start, uint end) {
  uint best = kNone;
  float bestRangeMin = kNothing;
  for (uint k = start; k < end; ++k) {
    float nearest = rangeMinOf(candidates.at[k]);
    if (best == kNone || nearest < bestRangeMin) {
      best = k;
      bestRangeMin = nearest;
    }
  }
  return best;
}

void forget(uint layer) {
#define FORGET(s)                            \
  ranges[layer * RAYS + s] = kNothing;     \
  energies[layer * RAYS + s] = 0.0;        \
  metIds[layer * RAYS + s] = kNone;        \
  metCandidates[layer * RAYS + s] = kNone; \
  passed[s] = 0.0;
  EACH_RAY(FORGET)
}

// Tries the nearest candidate first, as resolve does, and skips candidates behind all hits. Each lane first searches
// for the next candidate that it must try, so that the lanes of a subgroup try their candidates together.
void findLayer(uint start, uint end, Beam beam, uint layer) {
  forget(layer);
  uint best = bestOf(start, end), next = best, k = start;
  while (next < end) {
    float farthest = consider(candidates.at[next], beam, layer);
    while (k < end && (k == best || rangeMinOf(candidates.at[k]) > farthest)) ++k;
    next = k++;
  }
}

// Handles a beam whose whole footprint lies on its best candidate, with no other triangle in front of it. Returns
// false for any other beam.
bool findWithinOne(uint start, uint end, Beam beam) {
  forget(0);
  uint best = bestOf(start, end);
  if (best == kNone) return true;
  uint projected = candidates.at[best];
  Optics4 surface = optics.at[projectedMaterials.at[projected]];
  Candidate candidate = candidateOf(projected, beam);
  bool holed = (EFFECTS & kCutOuts) != 0 && surface.passage.y > 0.0, clear = LAYERS > 1 && transmitted(surface) > 0.0;
  if (holed || clear || !coversFootprint(candidate)) return false;
  vec4 plane = planeOf(candidate);
  float farthest = 0.0, range;
  bool all_ = true, met;
#define MEET(s)                                                         \
  met = meetPlane(candidate, plane, left[s], up[s], lengths[s], range); \
  offer(met, range, candidate.id, projected, 0, s);                     \
  farthest = max(farthest, range);                                      \
  all_ = all_ && met;
  EACH_RAY(MEET)
  for (uint k = start; k < end && all_; ++k) all_ = k == best || rangeMinOf(candidates.at[k]) > farthest;
  if (!all_) return false;
  vec3 normal = unitTowardsOrigin(plane.xyz, vec3(candidate.ahead.x, candidate.left.x, candidate.up.x));
#define SHARE_ONE(s) share(surface, normal, projected, 0, s);
  EACH_RAY(SHARE_ONE)
  return true;
}

// Passes the remaining light on to the next layer. Returns whether there is any.
bool goOn(uint layer) {
  bool any = false;
#define GO_ON(s)                                                       \
  carried[s] = ranges[layer * RAYS + s] < kNothing ? passed[s] : 0.0; \
  any = any || carried[s] > 0.0;
  EACH_RAY(GO_ON)
  return any;
}

float nextRange(float after) {
  float least = kNothing;
  [[unroll]] for (uint layer = 0; layer < LAYERS; ++layer) {
#define NEXT(s) \
  if (ranges[layer * RAYS + s] > after && energies[layer * RAYS + s] >= 0.0) least = min(least, ranges[layer * RAYS + s]);
    EACH_RAY(NEXT)
  }
  return least;
}

// Returns the farthest range of the echo that starts at `first`. Hits whose ranges differ by at most the separation
// from the next belong to one echo.
float endOfEcho(float first) {
  float end = first, before;
  do {
    before = end;
    float reach = sumOf(end, parameters.separation);
    [[unroll]] for (uint layer = 0; layer < LAYERS; ++layer) {
#define FOLLOW(s) \
  if (ranges[layer * RAYS + s] <= reach && energies[layer * RAYS + s] >= 0.0) end = max(end, ranges[layer * RAYS + s]);
      EACH_RAY(FOLLOW)
    }
  } while (end > before);
  return end;
}

void storeEcho(uint slot, vec3 echo, uint projected, vec2 azimuth) {
  echoes.at[slot] = vec4(echo, 1.0);
  echoOwners.at[slot] = ownerOf(idOf(projected));
  if ((FIELDS & kFieldSurface) != 0) {
    Triangle triangle = triangleAt(projected, azimuth);
    vec3 normal = normalOf(triangle.a, triangle.b, triangle.c);
    if (MOTION) normal = reportedDirection(beamColumn, normal);
    echoSurfaces.at[slot] = SurfaceRecord(normal, projectedMaterials.at[projected]);
  }
}

// The owner of an echo is its strongest hit, and the first one of equally strong hits.
void addTo(inout vec3 sums, inout float most, inout uint strongest, float first, float end, uint piece) {
  if (ranges[piece] < first || ranges[piece] > end || energies[piece] < 0.0) return;
  addPiece(sums, energies[piece], sumOf(ranges[piece], -first));
  if (energies[piece] <= most) return;
  most = energies[piece];
  strongest = metCandidates[piece];
}

void gatherEchoes(uint index, uint beam, vec2 azimuth) {
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
    [[unroll]] for (uint layer = 0; layer < LAYERS; ++layer) {
#define ADD(s) addTo(sums, most, strongest, first, end, layer * RAYS + s);
      EACH_RAY(ADD)
    }
    storeEcho(echoPlace(index, count), echoOf(first, sums), strongest, azimuth);
    ++count;
    first = nextRange(end);
  }
  echoCounts.at[beam] = count;
}

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

// Returns false if the beam is left to the second pass.
bool finish(uint index) {
  uint number = numberOf(index);
  if (MAPPED && number == kNone) return true;
  beamRow = rowOf(index);
  beamColumn = columnOf(index);
  Beam axis = beamWith(index);
  vec2 window = rangesOf(index);
  rangeMin = NUMBERED && frame.hidesNear != 0 ? 0.0 : window.x;
  rangeMax = window.y;
  // If the lists were too small, they are cut off here; the host enlarges them and runs the scan again.
  uint end = min(listEnds.at[index], frame.candidateCapacity), start = index == 0 ? 0 : min(listEnds.at[index - 1], end);
  aim(index);
  if (PASS == kPassWithinOne) {
    [[unroll]] for (uint layer = 1; layer < LAYERS; ++layer) forget(layer);
    if (!findWithinOne(start, end, axis)) return false;
  } else {
    bool lit = true;
    [[unroll]] for (uint layer = 0; layer < LAYERS; ++layer) {
      findLayer(start, lit ? end : start, axis, layer);
      lit = goOn(layer);
    }
    if (LAYERS > 1 && lit) atomicAdd(counters.lostEchoes, 1);
  }
  gatherEchoes(index, number, axis.azimuth);
  return true;
}

void main() {
  loadMotion();
#define LOAD(s) loadSubRay(s);
  EACH_RAY(LOAD)
  looksAtMaterials = (EFFECTS & kIntensity) != 0 && parameters.intensityModel == kModelPhysical;
  uvec2 run = runOf(PASS == kPassWithinOne ? frame.beams : counters.hardBeams);
  for (uint first = run.x; first < run.y; first += gl_SubgroupSize) {
    uint i = first + gl_SubgroupInvocationID;
    bool hard = false;
    uint index = 0;
    if (i < run.y) {
      index = PASS == kPassWithinOne ? i : hardBeams.at[i];
      hard = !finish(index);
    }
    if (PASS != kPassWithinOne) continue;
    uvec4 ballot = subgroupBallot(hard);
    uint slot = 0;
    if (subgroupElect()) slot = atomicAdd(counters.hardBeams, subgroupBallotBitCount(ballot));
    slot = slotAfter(slot, ballot);
    if (hard) hardBeams.at[slot] = index;
  }
}
