// SPDX-License-Identifier: Apache-2.0
// Stage project, last pass. One subgroup per visible cluster, one invocation per triangle: to the sensor's frame,
// cull, exact angular bounds. Writes every triangle that a beam may meet, with a box that contains all such beams.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_vote : require
#extension GL_EXT_scalar_block_layout : require
#include "shared.h"
#include "options.glsl"
#include "bindings.glsl"
#if defined(FOOTPRINT) || defined(MOTION)
#include "effects/arithmetic.h"
#include "effects/parameters.h"
#include "effects_bindings.glsl"
#endif
#ifdef MOTION
#include "motion.glsl"
#endif
#include "sphere.glsl"
#include "bounds.glsl"
#include "lattice.glsl"
#include "lanes.glsl"
#include "place.glsl"

layout(local_size_x = 64) in;

// A moving sensor sees what is at the seam of its columns twice: at the scan's start and at its end.
#ifdef MOTION
const uint kSides = 2;
#else
const uint kSides = 1;
#endif
const uint kKeep = 0, kNonFinite = 1, kRange = 2, kFace = 3, kBetween = 4, kNoTriangle = 5;

// As stored, see bindings.glsl.
struct Projected {
  vec4 a, b, c;
#ifdef FOOTPRINT
  vec2 uvA, uvB, uvC;
#endif
#ifdef MOTION
  mat3 velocities;  // of the corners
#endif
};

// Where a cluster is: its instance and itself, loaded by one lane for all of them.
struct Place {
  Instance instance;
  uint vertexFirst, triangleFirst, triangleCount;
  bool doubleSided;
  uint material;  // only with a footprint
  uint number;  // its number; only with motion
};

Place placeOf(uint i) {
  Place place;
  place.material = 0;
  float vertexFirst, packed;
  if (subgroupElect()) {
    uvec2 pair = visible[i];
    place.instance = instances[pair.x];
    place.number = pair.x;
    vertexFirst = clusters[pair.y].low.w;
    packed = clusters[pair.y].high.w;
#ifdef FOOTPRINT
    place.material = clusterMaterials[pair.y];
#endif
  }
  place.material = subgroupBroadcastFirst(place.material);
  place.number = subgroupBroadcastFirst(place.number);
  place.instance = fromFirstLane(place.instance);
  place.vertexFirst = floatBitsToUint(subgroupBroadcastFirst(vertexFirst));
  uint word = floatBitsToUint(subgroupBroadcastFirst(packed));
  place.triangleFirst = word & (kChunkTriangles - 1);
  place.triangleCount = word >> 24 & 127;
  place.doubleSided = (word >> 31) != 0;
  return place;
}

vec3 toSensor(Place place, uint vertex) { return toSensor(place.instance, positions[place.vertexFirst + vertex]); }

// By bits: the compiler may assume that NaN does not occur.
bool inLimits(vec3 p) {
  uvec3 magnitude = floatBitsToUint(p) & 0x7fffffffu;
  return all(lessThanEqual(magnitude, uvec3(floatBitsToUint(kCoordinateLimit))));
}

// Only where rounding cannot have changed the side; the inside test decides the rest beam by beam.
bool facesAway(vec3 a, vec3 b, vec3 c) {
  vec3 u = b - a, v = c - a;
  float side = dot(cross(u, v), a);
  float bound = 2e-6 * length(a) * length(u) * length(v);
  return side > bound;
}

bool outOfRange(vec3 a, float rangeMin) {
  return CULL == kCullFirstCorner ? !(length(a) <= frame.rangeMax) : rangeMin > frame.rangeMax;
}

uint boundedBox(vec3 a, vec3 b, vec3 c, bool oneSided, out Box box, out float rangeMin) {
  rangeMin = nearestPoint(min(min(a, b), c), max(max(a, b), c));
  if (outOfRange(a, rangeMin)) return kRange;
  if (oneSided && facesAway(a, b, c)) return kFace;
  Outline outline = outlineOf(a, b, c);
  return coverRows(outline, box) && coverColumns(a, b, c, outline, box) ? kKeep : kBetween;
}

#ifdef MOTION
#include "project_motion.glsl"
#endif

// Section 3 of the paper: n . v0 < 0 for faces of one side, the floor of the corners' angles.
uint paperBox(vec3 a, vec3 b, vec3 c, bool oneSided, out Box box, out float rangeMin) {
  rangeMin = abs(dot(normalize(cross(b - a, c - a)), a));
  if (outOfRange(a, rangeMin)) return kRange;
  if (oneSided && dot(cross(b - a, c - a), a) >= 0.0) return kFace;
  vec3 elevation = vec3(asin(a.z / length(a)), asin(b.z / length(b)), asin(c.z / length(c)));
  vec3 azimuth = vec3(atan(a.y, a.x), atan(b.y, b.x), atan(c.y, c.x));
  float low = min(min(elevation.x, elevation.y), elevation.z), high = max(max(elevation.x, elevation.y), elevation.z);
  float first = floor((low - frame.paperFirstElevation) * frame.paperRowsPerRadian);
  float last = floor((high - frame.paperFirstElevation) * frame.paperRowsPerRadian);
  if (!(last >= 0.0 && first < float(frame.rows))) return kBetween;
  box.rowFirst = uint(max(first, 0.0));
  box.rowLast = uint(min(last, float(frame.rows - 1)));
  box.columnMin = floor((min(min(azimuth.x, azimuth.y), azimuth.z) + kPi) * frame.columnsPerRadian);
  box.columnMax = floor((max(max(azimuth.x, azimuth.y), azimuth.z) + kPi) * frame.columnsPerRadian);
  return kKeep;
}

// The k-th triangle of a cluster, with the corners of a mirroring instance swapped back to their winding.
uint projectOne(Place place, uint k, uint side, out Projected projected, out Box box) {
  uvec2 triangle = triangleCorners[place.triangleFirst + k];
  bool mirrored = mirrors(place.instance);
  vec3 a = toSensor(place, triangle.x & 0xff);
  vec3 b = toSensor(place, triangle.x >> (mirrored ? 16 : 8) & 0xff);
  vec3 c = toSensor(place, triangle.x >> (mirrored ? 8 : 16) & 0xff);
#ifdef FOOTPRINT
  if ((EFFECTS & kCutOuts) != 0) {
    projected.uvA = textureCoordinates[place.vertexFirst + (triangle.x & 0xff)];
    projected.uvB = textureCoordinates[place.vertexFirst + (triangle.x >> (mirrored ? 16 : 8) & 0xff)];
    projected.uvC = textureCoordinates[place.vertexFirst + (triangle.x >> (mirrored ? 8 : 16) & 0xff)];
  }
#endif
  if (INSIDE == kInsideExact) {
    a = snapToLattice(a);
    b = snapToLattice(b);
    c = snapToLattice(c);
  }
  bool oneSided = FACES == kFacesFront || (FACES == kFacesMaterial && !place.doubleSided);
  uint id = placedFirstOf(place.instance) + triangle.y | (oneSided ? 1u << 31 : 0u);
  if (!(inLimits(a) && inLimits(b) && inLimits(c))) return kNonFinite;
  float rangeMin;
#ifdef MOTION
  projected.velocities = mat3(0.0);
  if (motion.instances != 0) {
    InstanceMotion moving = instanceMotions[place.number];
    projected.velocities = mat3(velocityOf(moving, a), velocityOf(moving, b), velocityOf(moving, c));
  }
  uint fate = movingBox(mat3(a, b, c), projected.velocities, side, box, rangeMin);
#else
  uint fate = BOUNDS == kBoundsPaper ? paperBox(a, b, c, oneSided, box, rangeMin)
                                     : boundedBox(a, b, c, oneSided, box, rangeMin);
#endif
  projected.a = vec4(a, uintBitsToFloat(id));
  projected.b = vec4(b, rangeMin);
  projected.c = vec4(c, uintBitsToFloat(box.rowFirst | box.rowLast << 16));
  return fate;
}

void store(uint slot, Projected projected, Box box, uint material) {
  projectedA[slot] = projected.a;
  projectedB[slot] = projected.b;
  projectedC[slot] = projected.c;
  projectedColumns[slot] = vec2(box.columnMin, box.columnMax);
#ifdef FOOTPRINT
  projectedMaterials[slot] = material;
  if ((EFFECTS & kCutOuts) != 0) {
    projectedTexture[2 * slot] = vec4(projected.uvA, projected.uvB);
    projectedTexture[2 * slot + 1] = vec4(projected.uvC, 0.0, 0.0);
  }
#endif
#ifdef MOTION
  if (motion.instances != 0)
    for (uint k = 0; k < 3; ++k) projectedMotions[3 * slot + k] = vec4(projected.velocities[k], 0.0);
#endif
}

// A large box is cut into tiles.
void storeTiles(uint slot, Box box) {
  uint columnsPerTile = max(kTileBeams / boxRowCount(box), 1);
  uint columnCount = boxColumnCount(box);
  uint count = (columnCount + columnsPerTile - 1) / columnsPerTile;
  uint first = atomicAdd(counters.tiles, count);
  for (uint k = 0; k < count && first + k < frame.tileCapacity; ++k)
    tiles[first + k] = uvec4(slot, k * columnsPerTile, columnsPerTile, 0);
}

void storeKept(bool keep, Projected projected, Box box, uint material) {
  bool small = boxColumnCount(box) * boxRowCount(box) <= kSmallBoxBeams;
  uvec4 smallOnes = subgroupBallot(keep && small), largeOnes = subgroupBallot(keep && !small);
  uint base = 0;
  if (subgroupElect()) base = atomicAdd(counters.projectedSmall, subgroupBallotBitCount(smallOnes));
  uint slot = slotAfter(base, smallOnes);
  if (subgroupElect()) base = atomicAdd(counters.projectedLarge, subgroupBallotBitCount(largeOnes));
  uint largeSlot = frame.projectedCapacity - 1 - slotAfter(base, largeOnes);
  if (!small) slot = largeSlot;
  if (keep && slot < frame.projectedCapacity) {
    store(slot, projected, box, material);
    if (!small) storeTiles(slot, box);
  }
}

void main() {
  uvec4 culled = uvec4(0);  // non-finite, range, face, between beams
  uint clusterCount = counters.visible, triangleCount = 0;
  uint stride = gl_NumWorkGroups.x * gl_NumSubgroups;
  for (uint i = gl_WorkGroupID.x * gl_NumSubgroups + gl_SubgroupID; i < clusterCount; i += stride) {
    Place place = placeOf(i);
    triangleCount += place.triangleCount;
    for (uint first = 0; first < kSides * place.triangleCount; first += gl_SubgroupSize) {
      uint number = first + gl_SubgroupInvocationID;
      uint fate = kNoTriangle;
      Projected projected;
      Box box;
      if (number < kSides * place.triangleCount) {
        fate = projectOne(place, number / kSides, number % kSides, projected, box);
        culled += uvec4(equal(uvec4(fate), uvec4(kNonFinite, kRange, kFace, kBetween)));
      }
      if (subgroupAny(fate == kKeep)) storeKept(fate == kKeep, projected, box, place.material);
    }
  }
  culled = subgroupAdd(culled);
  if (subgroupElect()) {
    if (triangleCount > 0) atomicAdd(counters.triangles, triangleCount);
    if (culled.x > 0) atomicAdd(counters.nonFinite, culled.x);
    if (culled.y > 0) atomicAdd(counters.culledByRange, culled.y);
    if (culled.z > 0) atomicAdd(counters.culledByFace, culled.z);
    if (culled.w > 0) atomicAdd(counters.culledBetweenBeams, culled.w);
  }
}
