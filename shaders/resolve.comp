// SPDX-License-Identifier: Apache-2.0
// Stage resolve. One row of workgroups per channel: the nearest hit of every beam -> point, range and owner. The
// nearest way only unpacks its words; the list way visits the beam's candidates, best first, skipping by depth.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#include "shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "inside.glsl"

layout(local_size_x = 64) in;

// Range bits above, placed triangle below: the smaller pair wins.
void consider(uint candidate, vec2 azimuth, uint row, inout uint rangeBits, inout uint id) {
  Triangle triangle = loadProjected(candidate);
  float range;
  if (!meet(triangle, turn(triangle, azimuth), azimuth, row, range)) return;
  uint bits = floatBitsToUint(range);
  if (bits < rangeBits || (bits == rangeBits && triangle.id < id)) {
    rangeBits = bits;
    id = triangle.id;
  }
}

// Best first: the candidate whose triangle comes nearest to the sensor is most likely the hit, and every candidate
// that stays behind it is skipped. `rangeMin` is a true lower bound of a hit's range, so no hit is lost.
void nearestOfList(uint beam, vec2 azimuth, uint row, out uint rangeBits, out uint id) {
  rangeBits = kNone;
  id = kNone;
  uint start = beam == 0 ? 0 : listEnds[beam - 1];
  uint end = min(listEnds[beam], frame.candidateCapacity);
  uint best = kNone;
  float bestRangeMin = 0.0;
  for (uint k = start; k < end; ++k) {
    float rangeMin = projectedBoxes[candidates[k]].rangeMin;
    if (best == kNone || rangeMin < bestRangeMin) {
      best = k;
      bestRangeMin = rangeMin;
    }
  }
  if (best != kNone) consider(candidates[best], azimuth, row, rangeBits, id);
  for (uint k = start; k < end; ++k)
    if (k != best && floatBitsToUint(projectedBoxes[candidates[k]].rangeMin) <= rangeBits)
      consider(candidates[k], azimuth, row, rangeBits, id);
}

// The last instance whose first triangle is not above `id`.
uint instanceOf(uint id) {
  uint low = 0, high = frame.instanceCount;
  while (high - low > 1) {
    uint middle = (low + high) / 2;
    if ((instances[middle].firstTriangle & 0x7fffffffu) <= id)
      low = middle;
    else
      high = middle;
  }
  return low;
}

void store(uint beam, vec3 direction, uint rangeBits, uint id) {
  bool hit = rangeBits != kNone;
  float range = hit ? uintBitsToFloat(rangeBits) : uintBitsToFloat(0x7fc00000u);
  uint owner = hit ? instanceOf(id) : kNone;
  points[3 * beam] = hit ? direction.x * range : range;
  points[3 * beam + 1] = hit ? direction.y * range : range;
  points[3 * beam + 2] = hit ? direction.z * range : range;
  ranges[beam] = range;
  triangles[beam] = hit ? id - (instances[owner].firstTriangle & 0x7fffffffu) : kNone;
  owners[beam] = owner;
}

void main() {
  uint row = gl_WorkGroupID.y;
  uint hits = 0;
  for (uint column = gl_WorkGroupID.x * gl_WorkGroupSize.x + gl_LocalInvocationID.x; column < frame.columns;
       column += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
    uint beam = rows[row].channel * frame.columns + column;
    vec2 azimuth = beamAzimuth(columns[column], row);
    uint rangeBits, id;
    if (PASS == kWayLists) {
      nearestOfList(beam, azimuth, row, rangeBits, id);
    } else {
      rangeBits = words[2 * beam + 1];
      id = words[2 * beam];
    }
    float cosElevation = rows[row].cosElevation;
    store(beam, vec3(cosElevation * azimuth.x, cosElevation * azimuth.y, rows[row].sinElevation), rangeBits, id);
    hits += rangeBits != kNone ? 1 : 0;
  }
  hits = subgroupAdd(hits);
  if (subgroupElect() && hits > 0) atomicAdd(counters.hits, hits);
}
