// SPDX-License-Identifier: Apache-2.0
// The kernel of the stage resolve. One row of workgroups per channel of each view: writes point, range and owner of
// every beam's nearest hit. Without lists it unpacks the beam's word; with lists it tries the beam's candidates,
// nearest first, and skips candidates that are farther than the best hit. If there are panes, the hit is the nearest
// opaque one; with lists it also becomes the beam's word, and the beams that meet a pane before it are listed. If stage
// effects computes the results, only the words are written.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_EXT_scalar_block_layout : require
#include "common/shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "views.glsl"
#include "motion.glsl"
#include "inside.glsl"
#include "seen.glsl"
#include "owner.glsl"
#include "runs.glsl"
#include "panes.glsl"

layout(local_size_x = 64) in;

float nearestSoFar;  // of the beam whose list is being visited
float farthestOf(uint index) { return nearestSoFar; }

// Tries a candidate: the smaller pair of range bits and placed triangle wins. Returns whether it is the new nearest.
bool consider(uint candidate, uint index, Beam beam, inout uvec2 word) {
  Triangle triangle = loadProjected(candidate);
  if (MOTION) triangle = seenFrom(triangle, candidate, columnOf(index), rowOf(index), beam.azimuth);
  nearestSoFar = min(uintBitsToFloat(min(word.y, 0x7f800000u)), frame.rangeMax);
  float range;
  Turned turned = turnedFrom(triangle, rowOf(index), index, beam.azimuth);
  if (!meet(triangle, prepare(triangle), turned, beam, index, candidate, range)) return false;
  if (!comesBefore(range, triangle.id, word)) return false;
  word = uvec2(triangle.id, floatBitsToUint(range));
  return true;
}

// The candidate whose triangle comes nearest to the sensor is tried first, because it is most likely the hit. Then
// every candidate behind that hit is skipped. `rangeMin` is a lower bound of the range, so no hit is lost.
uvec2 nearestOfList(uint index, Beam beam, uint start, uint end) {
  uvec2 word = uvec2(kNone);
  uint best = kNone;
  float bestRangeMin = 0.0;
  for (uint k = start; k < end; ++k) {
    float rangeMin = rangeMinOf(candidates.at[k]);
    if (best == kNone || rangeMin < bestRangeMin) {
      best = k;
      bestRangeMin = rangeMin;
    }
  }
  // The best candidate and then the others, in one loop, because compilers inline consider() at every call.
  for (uint n = start; n <= end && best != kNone; ++n) {
    uint k = n == start ? best : n - 1;
    if (n > start && k == best) continue;
    if (floatBitsToUint(rangeMinOf(candidates.at[k])) <= word.y && !(PANES && isPane(candidates.at[k])))
      consider(candidates.at[k], index, beam, word);
  }
  return word;
}

// Returns whether a pane of the list comes before the word.
bool meetsPane(uint index, Beam beam, uint start, uint end, uvec2 word) {
  for (uint k = start; k < end; ++k)
    if (floatBitsToUint(rangeMinOf(candidates.at[k])) <= word.y && isPane(candidates.at[k]) &&
        consider(candidates.at[k], index, beam, word))
      return true;
  return false;
}

// Returns the word of a beam that has a list.
uvec2 wordOfList(uint index, Beam beam) {
  uint entry = beamEntry(index), start = entry == 0 ? 0 : listEnds.at[entry - 1];
  uint end = min(listEnds.at[entry], frame.candidateCapacity);
  uvec2 word = nearestOfList(index, beam, start, end);
  if (PANES || PASS == kPassResolveWords) words.at[entry] = word;
  if (PANES && meetsPane(index, beam, start, end, word))
    hardBeams.at[atomicAdd(counters.hardBeams, 1)] = entry;
  return word;
}

// `at` is the entry of the beam's first return.
void store(uint index, uint at, Beam axis, uvec2 word) {
  bool hit = word.y != kNone;
  float range = hit ? uintBitsToFloat(word.y) : uintBitsToFloat(0x7fc00000u);
  uvec2 owner = uvec2(kNone);
  if (hit) owner = ownerOf(word.x);
  vec3 point = axis.direction * range;
  if (MOTION) point = reported(columnOf(index), rowOf(index), axis.azimuth, axis.direction, range);
  points.at[at] = hit ? vec4(point, range) : vec4(range);
  owners.at[at] = owner;
  for (uint j = 1; j < RETURNS; ++j) {
    points.at[at + j] = vec4(uintBitsToFloat(0x7fc00000u));
    owners.at[at + j] = uvec2(kNone);
  }
}

void main() {
  useOwnAddresses();
  loadMotion();
  uint groupRow = rowInView(gl_WorkGroupID.y);
  BeamRow row = loadRow(groupRow);
  uint hits = 0;
  uvec2 run = runOfBeams();
  for (uint k = run.x + gl_SubgroupInvocationID; k < run.y; k += gl_SubgroupSize) {
    uint column = beamColumn(k), index = indexOf(groupRow, column), number = numberIn(row, index, column);
    if (NUMBERED && number == kNone) continue;
    Beam beam = beamIn(row, column);
    uvec2 word = BINNING == kBinningLists ? wordOfList(index, beam) : words.at[beamEntry(index)];
    if (PASS == kPassResolveWords) continue;
    if (word.y != kNone && hidesItself(index, uintBitsToFloat(word.y))) word = uvec2(kNone);
    store(index, resultOf(number) * RETURNS, beam, word);
    hits += word.y != kNone ? 1 : 0;
  }
  hits = subgroupAdd(hits);
  if (subgroupElect() && hits > 0) atomicAdd(counters.hits, hits);
}
