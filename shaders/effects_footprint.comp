// SPDX-License-Identifier: Apache-2.0
// Stage effects, first pass, in place of resolve. One subgroup per beam, one lane per sub-ray: what the sub-rays meet
// among the beam's candidates, all of which they share, then what of it comes back as one echo. Sums over lanes are of
// integers, so they do not depend on how many lanes there are.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_vote : require
#include "shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "effects/parameters.h"
#include "effects/vector.h"
#include "effects/intensity.h"
#include "effects/noise.h"
#include "effects/returns.h"
#include "effects_bindings.glsl"
#include "inside.glsl"
#include "owner.glsl"

layout(local_size_x = 32) in;

// Only what exact inside tests ask for; none here.
float farthestOf(uint index) { return frame.rangeMax; }

// Surfaces that a sub-ray goes on behind, and the one that stops it.
#ifdef LAYERS
const uint kLayers = 4;
#else
const uint kLayers = 1;
#endif
const uint kMaxSubRays = 64;
const uint kMaxPieces = kLayers * kMaxSubRays;
const uint kMaxSubgroups = 8;  // of 4 lanes at least
const float kNothing = 3e38;

// What each sub-ray met in each layer: range (kNothing for nothing), energy and the candidate.
shared float pieceRanges[kMaxSubgroups * kMaxPieces];
shared float pieceEnergies[kMaxSubgroups * kMaxPieces];
shared uint pieceCandidates[kMaxSubgroups * kMaxPieces];

#define LOOKS_AT_MATERIALS ((EFFECTS & kIntensity) != 0 && parameters.intensityModel == kModelPhysical)

uint pieceBase() { return gl_SubgroupID * kMaxPieces; }

// A candidate in the beam's own frame: its corners ahead, to the left and up. One lane has loaded it for all.
struct Candidate {
  Triangle triangle;
  vec3 ahead, left, up;  // one component per corner
  uint material;
};

Candidate candidateOf(uint projected, Beam beam) {
  vec4 a, b, c;
  uint material = 0;
  if (subgroupElect()) {
    a = projectedA[projected];
    b = projectedB[projected];
    c = projectedC[projected];
    material = projectedMaterials[projected];
  }
  Candidate candidate;
  candidate.triangle = triangleOf(subgroupBroadcastFirst(a), subgroupBroadcastFirst(b), subgroupBroadcastFirst(c));
  candidate.material = subgroupBroadcastFirst(material);
  Turned turned = turn(candidate.triangle, beam.azimuth);
  candidate.ahead = cornerDepths(turned, beam.cosElevation, beam.sinElevation);
  candidate.left = turned.q;
  precise vec3 up = turned.z * beam.cosElevation - turned.p * beam.sinElevation;
  candidate.up = up;
  return candidate;
}

// What a sub-ray has met.
struct Hit {
  float range;
  uint id, candidate, material;
  float cosIncidence;
};

// Watertight as in inside_watertight.glsl: the sub-ray (1, u, v) shears every corner by the same operations.
bool meetSubRay(Candidate candidate, vec4 subRay, out float range) {
  precise vec3 q = candidate.left - subRay.x * candidate.ahead;
  precise vec3 w = candidate.up - subRay.y * candidate.ahead;
  precise vec3 side = q.yzx * w.zxy - w.yzx * q.zxy;
  precise float sum = side.x + side.y + side.z;
  precise float weighted = side.x * candidate.ahead.x + side.y * candidate.ahead.y + side.z * candidate.ahead.z;
  bool facing = all(lessThanEqual(side, vec3(0.0)));
  bool averted = all(greaterThanEqual(side, vec3(0.0)));
  bool inside = (facing || (averted && !candidate.triangle.oneSided)) && sum != 0.0;
  precise float along = quotient(weighted, sum) * subRay.w;
  range = max(along, candidate.triangle.rangeMin);
  return inside && along > 0.0 && range >= frame.rangeMin && range <= frame.rangeMax;
}

vec3 normalOf(Triangle triangle) {
  precise vec3 u = triangle.b - triangle.a;
  precise vec3 v = triangle.c - triangle.a;
  return unitTowardsOrigin(crossOf(u, v), triangle.a);
}

// The nearest hit of every lane's sub-ray behind (afterRange, afterId), in order of range, then triangle.
Hit nearestOf(uint start, uint end, Beam beam, vec4 subRay, vec3 direction, bool live, float afterRange, uint afterId) {
  Hit hit = Hit(kNothing, kNone, kNone, 0, 1.0);
  for (uint k = start; k < end; ++k) {
    uint projected = candidates[k];
    float bound = subgroupMax(live ? hit.range : 0.0);
    if (projectedB[projected].w > bound) continue;  // the same in every lane
    Candidate candidate = candidateOf(projected, beam);
    float range;
    bool met = meetSubRay(candidate, subRay, range) && live;
    bool behind = kLayers == 1 || range > afterRange || (range == afterRange && candidate.triangle.id > afterId);
    bool nearer = range < hit.range || (range == hit.range && candidate.triangle.id < hit.id);
    bool taken = met && behind && nearer;
    if (!subgroupAny(taken)) continue;
    float cosine = 1.0;
    if (LOOKS_AT_MATERIALS) cosine = min(abs(dotOf(normalOf(candidate.triangle), direction)), 1.0);
    if (taken) hit = Hit(range, candidate.triangle.id, projected, candidate.material, cosine);
  }
  return hit;
}

vec3 directionOf(Beam beam, vec4 subRay) {
  float inverse = quotient(1.0, subRay.w);
  precise float ahead = beam.cosElevation - subRay.y * beam.sinElevation;
  precise vec3 direction = vec3(ahead * beam.azimuth.x - subRay.x * beam.azimuth.y,
                                ahead * beam.azimuth.y + subRay.x * beam.azimuth.x,
                                beam.sinElevation + subRay.y * beam.cosElevation) * inverse;
  return direction;
}

// One sub-ray of a lane, through everything that lets light pass. Every lane must call.
void trace(uint start, uint end, Beam beam, vec4 subRay, uint s) {
  bool live = s < parameters.subRays;
  vec3 direction = directionOf(beam, subRay);
  float energy = subRay.z, afterRange = 0.0;
  uint afterId = 0;
  for (uint layer = 0; layer < kLayers; ++layer) {
    Hit hit = nearestOf(start, end, beam, subRay, direction, live, afterRange, afterId);
    bool met = live && hit.candidate != kNone;
    float share = energy;
    if (met && (LOOKS_AT_MATERIALS || kLayers > 1)) {
      Optics4 surface = optics[hit.material];
      if (LOOKS_AT_MATERIALS) share = energy * reflected(surface, hit.cosIncidence);
      if (kLayers > 1) energy = energy * transmitted(surface);
    }
    uint slot = pieceBase() + layer * kMaxSubRays + s;
    if (s < kMaxSubRays) {
      // What lets all light pass is no piece.
      pieceRanges[slot] = met && (share > 0.0 || kLayers == 1 || energy == 0.0) ? hit.range : kNothing;
      pieceEnergies[slot] = share;
      pieceCandidates[slot] = hit.candidate;
    }
    afterRange = hit.range;
    afterId = hit.id;
    live = met && energy > 0.0;
  }
  if (kLayers > 1 && live) atomicAdd(counters.lostEchoes, 1);
}

// Pieces of all layers in turn: number -> slot.
uint pieceCount() { return kLayers * parameters.subRays; }
uint slotOf(uint piece) {
  return pieceBase() + piece / parameters.subRays * kMaxSubRays + piece % parameters.subRays;
}

// The least range beyond `after`.
float nextRange(float after) {
  float least = kNothing;
  for (uint i = gl_SubgroupInvocationID; i < pieceCount(); i += gl_SubgroupSize) {
    float range = pieceRanges[slotOf(i)];
    if (range > after) least = min(least, range);
  }
  return subgroupMin(least);
}

// Roundings as written. In functions of their own: glslang takes exponential time to trace what is precise through
// loops.
float sumOf(float a, float b) {
  precise float result = a + b;
  return result;
}
float roundedShare(float value, float perUnit, float most) {
  precise float result = value * perUnit + 0.5;
  return min(result, most);
}

// Pieces that follow each other within the separation are one echo: its end.
float endOfEcho(float first) {
  float end = first;
  for (uint step = 0; step < kMaxPieces; ++step) {
    float reach = sumOf(end, parameters.separation);
    float farther = end;
    for (uint i = gl_SubgroupInvocationID; i < pieceCount(); i += gl_SubgroupSize) {
      float range = pieceRanges[slotOf(i)];
      if (range <= reach) farther = max(farther, range);
    }
    farther = subgroupMax(farther);
    if (farther == end) break;
    end = farther;
  }
  return end;
}

// The strongest piece of an echo, the first of equal ones.
void strongestOf(float first, float end, out float energy, out uint strongest) {
  float most = 0.0;
  for (uint i = gl_SubgroupInvocationID; i < pieceCount(); i += gl_SubgroupSize) {
    uint slot = slotOf(i);
    if (pieceRanges[slot] >= first && pieceRanges[slot] <= end) most = max(most, pieceEnergies[slot]);
  }
  energy = subgroupMax(most);
  uint least = kNone;
  for (uint i = gl_SubgroupInvocationID; i < pieceCount(); i += gl_SubgroupSize) {
    uint slot = slotOf(i);
    if (pieceRanges[slot] >= first && pieceRanges[slot] <= end && pieceEnergies[slot] == energy) least = min(least, i);
  }
  strongest = subgroupMin(least);
}

// Sums over the pieces of an echo: weights are 16-bit shares of the strongest piece's energy, and 12-bit ones where
// they meet depths; those are 13-bit shares of the echo's depth, and 10-bit ones squared.
struct Sums {
  uint fine, weights, moments, squaresLow, squaresHigh;
};

Sums sumPieces(float first, float end, float perEnergy, float perDepth) {
  Sums sums = Sums(0, 0, 0, 0, 0);
  for (uint i = gl_SubgroupInvocationID; i < pieceCount(); i += gl_SubgroupSize) {
    uint slot = slotOf(i);
    float range = pieceRanges[slot];
    if (range < first || range > end) continue;
    uint w = uint(roundedShare(pieceEnergies[slot], perEnergy, 65535.0)), coarse = w >> 4;
    uint x = uint(roundedShare(sumOf(range, -first), perDepth, 8191.0)), y = x >> 3;
    uint square = coarse * y * y;
    sums.fine += w;
    sums.weights += coarse;
    sums.moments += coarse * x;
    sums.squaresLow += square & 0xffff;
    sums.squaresHigh += square >> 16;
  }
  return Sums(subgroupAdd(sums.fine), subgroupAdd(sums.weights), subgroupAdd(sums.moments),
              subgroupAdd(sums.squaresLow), subgroupAdd(sums.squaresHigh));
}

// Range, energy and width of an echo.
vec3 echoOf(Sums sums, float first, float depth, float most) {
  precise float energy = quotient(float(sums.fine), 65535.0) * most;
  if (depth == 0.0 || sums.weights == 0) return vec3(first, energy, echoWidth(parameters.pulseWidth, 0.0));
  precise float mean = quotient(float(sums.moments), float(sums.weights) * 8191.0);
  precise float squares =
      quotient(float(sums.squaresHigh) * 65536.0 + float(sums.squaresLow), float(sums.weights) * 1046529.0);
  precise float deviation = depth * squareRoot(max(squares - mean * mean, 0.0));
  precise float range = first + depth * mean;
  return vec3(range, energy, echoWidth(parameters.pulseWidth, deviation));
}

vec3 sumEcho(float first, float end, float most) {
  float depth = sumOf(end, -first);
  float perEnergy = most > 0.0 ? quotient(65535.0, most) : 0.0;
  float perDepth = depth > 0.0 ? quotient(8191.0, depth) : 0.0;
  return echoOf(sumPieces(first, end, perEnergy, perDepth), first, depth, most);
}

void storeEcho(uint slot, vec3 echo, uint projected) {
  echoes[slot] = vec4(echo, 1.0);
  echoOwners[slot] = ownerOf(floatBitsToUint(projectedA[projected].w) & 0x7fffffffu);
  if ((FIELDS & kFieldSurface) != 0)
    echoSurfaces[slot] = vec4(normalOf(loadProjected(projected)), uintBitsToFloat(projectedMaterials[projected]));
}

void gatherEchoes(uint beam) {
  uint count = 0;
  float first = nextRange(0.0);
  while (first < kNothing) {
    float end = endOfEcho(first), most;
    uint strongest;
    strongestOf(first, end, most, strongest);
    if (count == kMaxEchoes) {
      if (subgroupElect()) atomicAdd(counters.lostEchoes, 1);
      break;
    }
    vec3 echo = sumEcho(first, end, most);
    if (subgroupElect()) storeEcho(beam * kMaxEchoes + count, echo, pieceCandidates[slotOf(strongest)]);
    ++count;
    first = nextRange(end);
  }
  if (subgroupElect()) echoCounts[beam] = count;
}

void main() {
  uint beams = frame.beams, stride = gl_NumWorkGroups.x * gl_NumSubgroups;
  for (uint index = gl_WorkGroupID.x * gl_NumSubgroups + gl_SubgroupID; index < beams; index += stride) {
    uint row = index / frame.columns, column = index % frame.columns;
    vec4 angles = rows[row].angles, offset = rows[row].offset;
    uint beam = uint(angles.w) * frame.columns + column;
    Beam axis = beamOf(AZIMUTH_OFFSETS ? shiftedAzimuth(columns[column], offset) : columns[column], angles.x, angles.y);
    uint start = index == 0 ? 0 : listEnds[index - 1], end = min(listEnds[index], frame.candidateCapacity);
    vec2 error = vec2(0.0);
    if ((EFFECTS & kStrays) != 0) {
      error = angleError(parameters, parameters.firstBeam + beam);
      error.x = error.x * axis.cosElevation;
    }
    for (uint first = 0; first < parameters.subRays; first += gl_SubgroupSize) {
      uint s = first + gl_SubgroupInvocationID;
      vec4 subRay = subRays[min(s, parameters.subRays - 1)];
      if ((EFFECTS & kStrays) != 0) {
        precise vec2 tangents = subRay.xy + error;
        precise float square = 1.0 + tangents.x * tangents.x + tangents.y * tangents.y;
        subRay = vec4(tangents, subRay.z, squareRoot(square));
      }
      trace(start, end, axis, subRay, s);
    }
    subgroupMemoryBarrierShared();
    subgroupBarrier();
    gatherEchoes(beam);
    subgroupBarrier();
  }
}
