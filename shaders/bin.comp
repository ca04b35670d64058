// SPDX-License-Identifier: Apache-2.0
// Stage bin. Gives every projected triangle to the beams that meet it. Small boxes are worked off by one invocation
// each; tiles of large ones by a subgroup each, its lanes side by side. PASS says what is done with a meeting.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_shuffle : require
#ifdef INT64_ATOMICS
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
#endif
#include "shared.h"
#include "options.glsl"
#include "bindings.glsl"
#ifdef MOTION
#include "effects/arithmetic.h"
#include "effects/parameters.h"
#include "effects_bindings.glsl"
#include "motion.glsl"
#endif
#include "sphere.glsl"
#include "bounds.glsl"
#include "inside.glsl"
#ifdef MOTION
#include "seen.glsl"
#endif

layout(local_size_x = 64) in;
#ifdef INT64_ATOMICS
layout(std430, set = 0, binding = kBindWords) coherent buffer Words64Block { uint64_t words64[]; };
#endif

// Ranges are positive, so their bits order like numbers. Words only fall: so reading before an atomic would be safe, but
// what is near comes first, and most that would be asked is answered with yes.
void offerNearest(uint beam, uint rangeBits, uint id) {
#ifdef INT64_ATOMICS
  atomicMin(words64[beam], packUint2x32(uvec2(id, rangeBits)));
#endif
}

void offer(uint beam, float range, uint projected, uint id) {
  uint rangeBits = floatBitsToUint(range);
  if (PASS == kPassNearest) {
    offerNearest(beam, rangeBits, id);
  } else if (PASS == kPassRange) {
    if (rangeBits >= words[beam].y) return;
    atomicMin(words[beam].y, rangeBits);
    words[beam].x = kNone;  // what a still image had there is not the nearest any more
  } else if (PASS == kPassOwner) {
    if (rangeBits == words[beam].y) atomicMin(words[beam].x, id);
  } else if (PASS == kPassCount) {
    atomicAdd(listEnds[beam], 1);
  } else {
    uint slot = atomicAdd(listEnds[beam], 1);
    if (slot < frame.candidateCapacity) candidates[slot] = projected;
  }
}

float farthestOf(uint index) {
  bool lists = PASS == kPassCount || PASS == kPassFill;
  return lists ? frame.rangeMax : min(uintBitsToFloat(min(words[index].y, 0x7f800000u)), frame.rangeMax);
}

// A box starts between -3/4 and 1 turns, an azimuth offset adds up to 1/2 either way, and it spans up to 1.
uint wrapColumn(int column) {
  int turnColumns = int(frame.columns);
  if (column < 0) column += turnColumns;
  if (column < 0) column += turnColumns;
  if (column >= turnColumns) column -= turnColumns;
  if (column >= turnColumns) column -= turnColumns;
  return uint(column);
}

void tryBeam(Triangle triangle, Prepared prepared, Turned turned, Beam beam, uint index, uint projected) {
  if ((EFFECTS & kFootprintEffects) != 0) {
    if (mayMeet(triangle, prepared, turned, beam)) offer(index, 0.0, projected, triangle.id);
    return;
  }
  float range;
  if (meet(triangle, prepared, turned, beam, index, range)) offer(index, range, projected, triangle.id);
}

#ifdef MOTION
// `seen` is the triangle when the beam's column fires.
void tryMoving(Triangle seen, Beam beam, uint index, uint slot) {
  seen = seenFrom(seen, index / frame.columns, beam.azimuth);
  tryBeam(seen, prepare(seen), turn(seen, beam.azimuth), beam, index, slot);
}
#endif

uint columnAt(Box box, uint k, float shift) { return wrapColumn(int(ceil(box.columnMin - shift)) + int(k)); }

// The beam in the k-th column of a box and in a row, and its index among the words.
Beam beamAt(Box box, uint k, uint row, out uint index) {
  vec4 angles = rows[row].angles;
  vec4 offset = AZIMUTH_OFFSETS ? rows[row].offset : vec4(0.0);
  uint column = columnAt(box, k, offset.z);
  index = row * frame.columns + column;
  return beamOf(AZIMUTH_OFFSETS ? shiftedAzimuth(columns[column], offset) : columns[column], angles.x, angles.y);
}

Box boxOf(uint i, float packedRows) {
  uint word = floatBitsToUint(packedRows);
  vec2 span = projectedColumns[i];
  return Box(span.x, span.y, word & 0xffff, word >> 16);
}

// One invocation, all beams of a box. One loop, not two nested ones: lanes with boxes of other shapes then wait for the
// largest box only, not for the most columns times the most rows.
void trySmall(uint i) {
  vec4 c = projectedC[i];
  Triangle triangle = triangleOf(projectedA[i], projectedB[i], c);
  Box box = boxOf(i, c.w);
  Prepared prepared = prepare(triangle);
  uint columnCount = boxColumnCount(box);
  uint k = 0;
  for (uint row = box.rowFirst; row <= box.rowLast;) {
    uint index;
    Beam beam = beamAt(box, k, row, index);
#ifdef MOTION
    tryMoving(seenFrom(triangle, i, index % frame.columns), beam, index, i);
#else
    tryBeam(triangle, prepared, turn(triangle, beam.azimuth), beam, index, i);
#endif
    if (++k == columnCount) {
      k = 0;
      ++row;
    }
  }
}

// By how much the side of an edge may be wrong between the columns of the first and the last of `width` lanes, were it a
// straight line there. Along a row it is a sine of the azimuth: over an angle of d it leaves the chord between both ends
// by at most d^2 / 8 of the length of the edge's normal. Rounding is 1e-6 of that, twice.
vec3 slackBetween(Triangle triangle, Prepared prepared, uint width) {
  vec3 far = vec3(length(triangle.a), length(triangle.b), length(triangle.c));
  vec3 normals = far.yzx * far.zxy;  // at most
  float angle = float(width) / frame.columnsPerRadian;
  vec3 slack = (0.126 * angle * angle + 2e-6) * normals;
  if ((EFFECTS & kFootprintEffects) != 0) slack += prepared.reach;
  return slack;
}

// May a beam between these columns meet the triangle? Every lane asks for a row of its own.
bool mayMeetBetween(Triangle triangle, Turned turned, vec3 slack, uint width, vec2 angles) {
  uint last = width - 1;
  Turned from = Turned(subgroupBroadcastFirst(turned.p), subgroupBroadcastFirst(turned.q), turned.z);
  Turned to = Turned(subgroupShuffle(turned.p, last), subgroupShuffle(turned.q, last), turned.z);
  vec3 sideFrom = watertightSides(from, angles.x, angles.y), sideTo = watertightSides(to, angles.x, angles.y);
  bool facing = all(lessThanEqual(min(sideFrom, sideTo), slack));
  bool averted = all(greaterThanEqual(max(sideFrom, sideTo), -slack)) && !triangle.oneSided;
  return facing || averted;
}

// One subgroup, one tile; one lane loads for all. Lanes stand side by side in `width` columns and, where the tile has
// fewer columns than the subgroup lanes, in several rows.
void tryTile(uint t) {
  uvec4 tile;
  vec4 a, b, c;
  Box box;
  if (subgroupElect()) {
    tile = tiles[t];
    a = projectedA[tile.x];
    b = projectedB[tile.x];
    c = projectedC[tile.x];
    box = boxOf(tile.x, c.w);
  }
  tile = subgroupBroadcastFirst(tile);
  Triangle triangle = triangleOf(subgroupBroadcastFirst(a), subgroupBroadcastFirst(b), subgroupBroadcastFirst(c));
  box.columnMin = subgroupBroadcastFirst(box.columnMin);
  box.columnMax = subgroupBroadcastFirst(box.columnMax);
  box.rowFirst = subgroupBroadcastFirst(box.rowFirst);
  box.rowLast = subgroupBroadcastFirst(box.rowLast);
  Prepared prepared = prepare(triangle);
  uint end = min(tile.y + tile.z, boxColumnCount(box));
  uint width = 1, shift = 0;
  while (width < end - tile.y && width < gl_SubgroupSize) {
    width *= 2;
    ++shift;
  }
  uint height = gl_SubgroupSize >> shift;
  uint lane = gl_SubgroupInvocationID;
  vec3 slack = slackBetween(triangle, prepared, width);
  uint perRow = frame.columns;
  // Each lane has a row at hand; of most boxes these are all.
  vec2 firstRows = rows[min(box.rowFirst + lane, box.rowLast)].angles.xy;
  bool tall = box.rowLast - box.rowFirst >= gl_SubgroupSize;
  for (uint first = tile.y; first < end; first += width) {
    uint k = first + (lane & (width - 1));
    uint column = columnAt(box, k, 0.0);
    vec2 azimuth = columns[column];
    Turned turned = turn(triangle, azimuth);
#ifdef MOTION
    Triangle seen = seenFrom(triangle, tile.x, column);
#endif
    for (uint rowBase = box.rowFirst; rowBase <= box.rowLast; rowBase += gl_SubgroupSize) {
      vec2 angles = firstRows;
      if (tall) angles = rows[min(rowBase + lane, box.rowLast)].angles.xy;
      uint rowCount = min(box.rowLast - rowBase + 1, gl_SubgroupSize);
#ifndef MOTION
      if (!AZIMUTH_OFFSETS && !mayMeetBetween(triangle, turned, slack, width, angles)) angles.x = -1.0;
#endif
      for (uint r = 0; r < rowCount; r += height) {
        uint row = r + (lane >> shift);
        vec2 mine = subgroupShuffle(angles, row & (gl_SubgroupSize - 1));
        // Not a continue: every lane must come to the next shuffle.
        bool here = k < end && row < rowCount && mine.x >= 0.0;
#ifdef MOTION
        if (here) {
          uint index;
          Beam beam = beamAt(box, k, rowBase + row, index);
          // Another row's offset may make it another column.
          tryMoving(AZIMUTH_OFFSETS ? seenFrom(triangle, tile.x, index % frame.columns) : seen, beam, index, tile.x);
        }
#else
        if (here && AZIMUTH_OFFSETS) {
          uint index;
          Beam beam = beamAt(box, k, rowBase + row, index);
          tryBeam(triangle, prepared, turn(triangle, beam.azimuth), beam, index, tile.x);
        } else if (here) {
          tryBeam(triangle, prepared, turned, beamOf(azimuth, mine.x, mine.y),
                  (rowBase + row) * perRow + column, tile.x);
        }
#endif
      }
    }
  }
}

void main() {
  // Lists that were too small: the host makes room and runs the scan again.
  if (counters.projectedSmall + counters.projectedLarge > frame.projectedCapacity ||
      counters.tiles > frame.tileCapacity)
    return;
  // Shell by shell, or everything at once.
  bool byShell = PASS == kPassNearest || PASS == kPassRange;
  uint first = byShell ? counters.binnedSmall : 0;
  uint stride = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
  for (uint i = first + gl_WorkGroupID.x * gl_WorkGroupSize.x + gl_LocalInvocationID.x; i < counters.projectedSmall;
       i += stride)
    trySmall(i);
  first = byShell ? counters.binnedTiles : 0;
  stride = gl_NumWorkGroups.x * gl_NumSubgroups;
  for (uint t = first + gl_WorkGroupID.x * gl_NumSubgroups + gl_SubgroupID; t < counters.tiles; t += stride) tryTile(t);
}
