// SPDX-License-Identifier: Apache-2.0
// Stage project, second pass. One workgroup per visible cluster, one invocation per triangle: to the sensor's frame,
// cull, exact angular bounds. Writes every triangle that a beam may meet, with a box that contains all such beams.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#include "shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "sphere.glsl"
#include "bounds.glsl"
#include "lattice.glsl"

layout(local_size_x = 64) in;

const uint kKeep = 0, kNonFinite = 1, kRange = 2, kFace = 3, kBetween = 4;

vec3 toSensor(Instance instance, uint vertex) {
  precise vec3 d = vec3(positions[3 * vertex], positions[3 * vertex + 1], positions[3 * vertex + 2]) -
                   vec3(instance.row0.w, instance.row1.w, instance.row2.w);
  precise vec3 p =
      vec3(instance.row0.x * d.x + instance.row0.y * d.y + instance.row0.z * d.z + instance.offsetX,
           instance.row1.x * d.x + instance.row1.y * d.y + instance.row1.z * d.z + instance.offsetY,
           instance.row2.x * d.x + instance.row2.y * d.y + instance.row2.z * d.z + instance.offsetZ);
  return p;
}

// By bits: the compiler may assume that NaN does not occur.
bool inLimits(vec3 p) {
  uvec3 magnitude = floatBitsToUint(p) & 0x7fffffffu;
  return all(lessThanEqual(magnitude, uvec3(floatBitsToUint(kCoordinateLimit))));
}

// A lower bound of the distance to the triangle: the distance to its box.
float nearestDistance(vec3 a, vec3 b, vec3 c) {
  vec3 nearest = max(max(min(min(a, b), c), -max(max(a, b), c)), vec3(0.0));
  return length(nearest) * 0.999999;
}

// Only where rounding cannot have changed the side; the inside test decides the rest beam by beam.
bool facesAway(vec3 a, vec3 b, vec3 c) {
  vec3 u = b - a, v = c - a;
  float side = dot(cross(u, v), a);
  float bound = 2e-6 * length(a) * length(u) * length(v);
  return side > bound;
}

bool outOfRange(vec3 a, Box box) {
  return CULL == kCullFirstCorner ? !(length(a) <= frame.rangeMax) : box.rangeMin > frame.rangeMax;
}

uint boundedBox(vec3 a, vec3 b, vec3 c, bool oneSided, out Box box) {
  box.rangeMin = nearestDistance(a, b, c);
  if (outOfRange(a, box)) return kRange;
  if (oneSided && facesAway(a, b, c)) return kFace;
  Outline outline = outlineOf(a, b, c);
  return coverRows(outline, box) && coverColumns(a, b, c, outline, box) ? kKeep : kBetween;
}

// Section 3 of the paper: n . v0 < 0 for faces of one side, the floor of the corners' angles.
uint paperBox(vec3 a, vec3 b, vec3 c, bool oneSided, out Box box) {
  box.rangeMin = abs(dot(normalize(cross(b - a, c - a)), a));
  if (outOfRange(a, box)) return kRange;
  if (oneSided && dot(cross(b - a, c - a), a) >= 0.0) return kFace;
  vec3 elevation = vec3(asin(a.z / length(a)), asin(b.z / length(b)), asin(c.z / length(c)));
  vec3 azimuth = vec3(atan(a.y, a.x), atan(b.y, b.x), atan(c.y, c.x));
  float low = min(min(elevation.x, elevation.y), elevation.z), high = max(max(elevation.x, elevation.y), elevation.z);
  float first = floor((low - frame.paperFirstElevation) * frame.paperRowsPerRadian);
  float last = floor((high - frame.paperFirstElevation) * frame.paperRowsPerRadian);
  if (!(last >= 0.0 && first < float(frame.rows))) return kBetween;
  box.rows = uint(max(first, 0.0)) | uint(min(last, float(frame.rows - 1))) << 16;
  box.columnMin = floor((min(min(azimuth.x, azimuth.y), azimuth.z) + kPi) * frame.columnsPerRadian);
  box.columnMax = floor((max(max(azimuth.x, azimuth.y), azimuth.z) + kPi) * frame.columnsPerRadian);
  return kKeep;
}

// Loads one triangle of a visible cluster, with the corners of a mirroring instance swapped back to their winding.
uint projectOne(uvec2 pair, uint k, out vec3 a, out vec3 b, out vec3 c, out uint id, out Box box) {
  Instance instance = instances[pair.x];
  Cluster cluster = clusters[pair.y];
  uint packed = corners[cluster.firstTriangle + k];
  bool mirrored = (instance.firstTriangle >> 31) != 0;
  a = toSensor(instance, cluster.firstVertex + (packed & 0xff));
  b = toSensor(instance, cluster.firstVertex + (packed >> (mirrored ? 16 : 8) & 0xff));
  c = toSensor(instance, cluster.firstVertex + (packed >> (mirrored ? 8 : 16) & 0xff));
  if (INSIDE == kInsideExact) {
    a = snapToLattice(a);
    b = snapToLattice(b);
    c = snapToLattice(c);
  }
  bool oneSided = FACES == kFacesFront || (FACES == kFacesMaterial && cluster.doubleSided == 0);
  id = (instance.firstTriangle & 0x7fffffffu) + triangleIds[cluster.firstTriangle + k] | (oneSided ? 1u << 31 : 0u);
  if (!(inLimits(a) && inLimits(b) && inLimits(c))) return kNonFinite;
  return BOUNDS == kBoundsPaper ? paperBox(a, b, c, oneSided, box) : boundedBox(a, b, c, oneSided, box);
}

void store(uint slot, vec3 a, vec3 b, vec3 c, uint id, Box box) {
  for (uint k = 0; k < 3; ++k) {
    projectedA[3 * slot + k] = a[k];
    projectedB[3 * slot + k] = b[k];
    projectedC[3 * slot + k] = c[k];
  }
  projectedBoxes[slot] = box;
  projectedIds[slot] = id;
}

// A box too large for one invocation is cut into tiles that subgroups share.
void storeTiles(uint slot, Box box) {
  uint rowCount = (box.rows >> 16) - (box.rows & 0xffff) + 1;
  uint columnCount = boxColumnCount(box);
  if (rowCount * columnCount <= kSmallBoxBeams) return;
  uint columnsPerTile = max(kTileBeams / rowCount, 1);
  uint count = (columnCount + columnsPerTile - 1) / columnsPerTile;
  uint first = atomicAdd(counters.tiles, count);
  for (uint k = 0; k < count && first + k < frame.tileCapacity; ++k)
    tiles[first + k] = Tile(slot, k * columnsPerTile, columnsPerTile, 0);
}

void main() {
  uvec4 culled = uvec4(0);  // non-finite, range, face, between beams
  uint clusterCount = counters.visible;
  for (uint i = gl_WorkGroupID.x; i < clusterCount; i += gl_NumWorkGroups.x) {
    uvec2 pair = visible[i];
    uint fate = kNonFinite;
    vec3 a, b, c;
    uint id;
    Box box;
    bool exists = gl_LocalInvocationID.x < clusters[pair.y].triangleCount;
    if (exists) {
      fate = projectOne(pair, gl_LocalInvocationID.x, a, b, c, id, box);
      culled += uvec4(equal(uvec4(fate), uvec4(kNonFinite, kRange, kFace, kBetween)));
    }
    bool keep = exists && fate == kKeep;
    uvec4 ballot = subgroupBallot(keep);
    uint slot = 0;
    if (subgroupElect()) slot = atomicAdd(counters.projected, subgroupBallotBitCount(ballot));
    slot = subgroupBroadcastFirst(slot) + subgroupBallotExclusiveBitCount(ballot);
    if (keep && slot < frame.projectedCapacity) {
      store(slot, a, b, c, id, box);
      storeTiles(slot, box);
    }
  }
  culled = subgroupAdd(culled);
  if (subgroupElect()) {
    if (culled.x > 0) atomicAdd(counters.nonFinite, culled.x);
    if (culled.y > 0) atomicAdd(counters.culledByRange, culled.y);
    if (culled.z > 0) atomicAdd(counters.culledByFace, culled.z);
    if (culled.w > 0) atomicAdd(counters.culledBetweenBeams, culled.w);
  }
}
