// SPDX-License-Identifier: Apache-2.0
// Stage resolve. One row of workgroups per channel: the nearest hit of every beam -> point, range and owner. The
// nearest way only unpacks its words; the list way visits the beam's candidates, best first, skipping by depth.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#include "shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "inside.glsl"

layout(local_size_x = 64) in;

// Range bits above, placed triangle below: the smaller pair wins.
void consider(uint candidate, Beam beam, inout uint rangeBits, inout uint id) {
  Triangle triangle = loadProjected(candidate);
  float range, farthest = min(uintBitsToFloat(min(rangeBits, 0x7f800000u)), frame.rangeMax);
  if (!meet(triangle, prepare(triangle), turn(triangle, beam.azimuth), beam, farthest, range)) return;
  uint bits = floatBitsToUint(range);
  if (bits < rangeBits || (bits == rangeBits && triangle.id < id)) {
    rangeBits = bits;
    id = triangle.id;
  }
}

// Best first: the candidate whose triangle comes nearest to the sensor is most likely the hit, and every candidate
// that stays behind it is skipped. `rangeMin` is a true lower bound of a hit's range, so no hit is lost.
void nearestOfList(uint index, Beam beam, out uint rangeBits, out uint id) {
  rangeBits = kNone;
  id = kNone;
  uint start = index == 0 ? 0 : listEnds[index - 1];
  uint end = min(listEnds[index], frame.candidateCapacity);
  uint best = kNone;
  float bestRangeMin = 0.0;
  for (uint k = start; k < end; ++k) {
    float rangeMin = projectedBoxes[candidates[k]].rangeMin;
    if (best == kNone || rangeMin < bestRangeMin) {
      best = k;
      bestRangeMin = rangeMin;
    }
  }
  if (best != kNone) consider(candidates[best], beam, rangeBits, id);
  for (uint k = start; k < end; ++k)
    if (k != best && floatBitsToUint(projectedBoxes[candidates[k]].rangeMin) <= rangeBits)
      consider(candidates[k], beam, rangeBits, id);
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
    uint index = rows[row].channel * frame.columns + column;
    Beam beam = beamOf(columns[column], row);
    uint rangeBits, id;
    if (PASS == kWayLists) {
      nearestOfList(index, beam, rangeBits, id);
    } else {
      rangeBits = words[2 * index + 1];
      id = words[2 * index];
    }
    store(index, beam.direction, rangeBits, id);
    hits += rangeBits != kNone ? 1 : 0;
  }
  hits = subgroupAdd(hits);
  if (subgroupElect() && hits > 0) atomicAdd(counters.hits, hits);
}
