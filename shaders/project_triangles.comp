// SPDX-License-Identifier: Apache-2.0
// Stage project, last pass. One subgroup per visible cluster. First each invocation transforms a vertex to the
// sensor's frame, then it culls a triangle; the triangles that are left, collected from several clusters until they
// fill the subgroup, get exact angular bounds. Writes every triangle that a beam may hit, with a box that contains all
// such beams.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#extension GL_KHR_shader_subgroup_vote : require
#extension GL_EXT_scalar_block_layout : require
#include "shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "motion.glsl"
#include "sphere.glsl"
#include "bounds.glsl"
#include "beam.h"
#include "lanes.glsl"
#include "to_sensor.glsl"
#include "cull.glsl"
#include "cluster_corners.glsl"

layout(local_size_x = 64) in;

// With motion, a triangle at the seam of the columns may be seen twice: at the start and at the end of the scan.
uint sideCount() { return MOTION ? 2 : 1; }
const uint kKeep = 0, kNonFinite = 1, kRange = 2, kFace = 3, kBetween = 4, kHidden = 5, kNoTriangle = 6;

// A projected triangle as arrays.h describes it.
struct Projected {
  TaggedCorner a;
  vec4 b;
  TaggedCorner c;
  vec2 uvA, uvB, uvC;  // only with cut-outs
  mat3 velocities;     // of the corners; only with motion
};

// Tests the bits, because the compiler may assume that NaN does not occur.
bool inLimits(vec3 p) {
  uvec3 magnitude = floatBitsToUint(p) & 0x7fffffffu;
  return all(lessThanEqual(magnitude, uvec3(floatBitsToUint(kCoordinateLimit))));
}

// True only if rounding cannot have changed the side; otherwise the inside test decides for each beam.
bool facesAway(vec3 a, vec3 b, vec3 c) {
  vec3 u = b - a, v = c - a;
  float side = dot(cross(u, v), a);
  float bound = 2e-6 * length(a) * length(u) * length(v);
  return side > bound;
}

bool outOfRange(vec3 a, float rangeMin) {
  return CULL == kCullFirstCorner ? !(length(a) <= frame.rangeMax) : rangeMin > frame.rangeMax;
}

// True if in the whole box an earlier shell has nearer hits. Small boxes are not tested, because trying their beams is
// cheaper.
bool hidden(Box box, float rangeMin) {
  return (CULLING & kCullOccluded) != 0 && pass.occluders != 0 &&
         boxColumnCount(box) * boxRowCount(box) > kSmallBoxBeams &&
         occluded(Window(box.rowFirst, box.rowLast + 1, box.columnMin, box.columnMax), rangeMin);
}

// True if the triangle certainly lies between two rows, by the angles of its corners and a margin. An edge that spans
// d radians (at most its length divided by the nearest range) rises above its ends by at most d^2 / 8 times the
// tangent of its elevation, which is at most 2.4 here: for d up to 0.2 and keys up to 0.6.
bool betweenRows(vec3 a, vec3 b, vec3 c, vec3 size, float rangeMin) {
  vec3 keys = vec3(elevationKey(length(a.xy), a.z), elevationKey(length(b.xy), b.z), elevationKey(length(c.xy), c.z));
  float keyMin = min(min(keys.x, keys.y), keys.z), keyMax = max(max(keys.x, keys.y), keys.z);
  float squares = dot(size, size) / (rangeMin * rangeMin);
  float widening = 0.35 * squares + keySlack();
  uint first, end;
  rowsBetween(keyMin - widening, keyMax + widening, first, end);
  return first >= end && squares < 0.04 && max(-keyMin, keyMax) < 0.6;
}

// The culling tests that need no exact bounds. All lanes run all of them, because loads in divergent branches cost
// more.
uint culledEarly(vec3 a, vec3 b, vec3 c, bool oneSided) {
  vec3 low = min(min(a, b), c), high = max(max(a, b), c);
  float rangeMin = nearestPoint(low, high);
  uint fate = kKeep;
  // If one subgroup processes all triangles of a cluster at once, this extra test saves no time.
  if (BOUNDS == kBoundsExact && gl_SubgroupSize < kClusterTriangles)
    fate = betweenRows(a, b, c, high - low, rangeMin) ? kBetween : kKeep;
  fate = oneSided && facesAway(a, b, c) ? kFace : fate;
  return outOfRange(a, rangeMin) ? kRange : fate;
}

uint boundedBox(vec3 a, vec3 b, vec3 c, out Box box, float rangeMin) {
  Outline outline = outlineOf(a, b, c);
  if (!(coverRows(outline, box) && coverColumns(a, b, c, outline, box))) return kBetween;
  return hidden(box, rangeMin) ? kHidden : kKeep;
}

#include "project_motion.glsl"

// Section 3 of the paper: one-sided faces need n . v0 < 0; the box is the floor of the corners' angles.
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

bool isOneSided(LoadedCluster loaded) { return FACES == kFacesFront || (FACES == kFacesMaterial && loaded.doubleSided == 0); }

uint cullOne(LoadedCluster loaded, mat3 corners) {
  vec3 a = corners[0], b = corners[1], c = corners[2];
  uint fate = kKeep;
  if (!MOTION && BOUNDS != kBoundsPaper) fate = culledEarly(a, b, c, isOneSided(loaded));
  return inLimits(a) && inLimits(b) && inLimits(c) ? fate : kNonFinite;
}

// A triangle that passed the early culling; it may belong to an earlier cluster than the current one.
struct Survivor {
  mat3 corners;
  uint id;         // the top bit says one-sided
  uvec3 vertices;  // only with a footprint, as is the material
  uint material;
  uint instance;  // only with motion
};

// Returns the k-th triangle of a cluster. All lanes of the subgroup must call this.
Survivor survivorOf(LoadedCluster loaded, Vertices vertices, uint k) {
  uvec2 triangle = triangleCorners.at[loaded.triangleFirst + k];
  uvec3 numbers = numbersOf(loaded, triangle.x);
  Survivor survivor;
  survivor.corners = cornersOf(loaded, vertices, numbers);
  survivor.id = placedFirstOf(loaded.instance) + triangle.y | (isOneSided(loaded) ? 1u << 31 : 0u);
  survivor.vertices = loaded.vertexFirst + numbers;
  survivor.material = loaded.material;
  survivor.instance = loaded.number;
  return survivor;
}

uint projectOne(Survivor survivor, uint side, out Projected projected, out Box box) {
  vec3 a = survivor.corners[0], b = survivor.corners[1], c = survivor.corners[2];
  if ((EFFECTS & kCutOuts) != 0) {
    projected.uvA = textureCoordinates.at[survivor.vertices.x];
    projected.uvB = textureCoordinates.at[survivor.vertices.y];
    projected.uvC = textureCoordinates.at[survivor.vertices.z];
  }
  float rangeMin = nearestPoint(min(min(a, b), c), max(max(a, b), c));
  uint fate;
  if (MOTION) {
    projected.velocities = mat3(0.0);
    if (motion.instances != 0) {
      InstanceMotion moving = instanceMotions.at[survivor.instance];
      projected.velocities = mat3(velocityOf(moving, a), velocityOf(moving, b), velocityOf(moving, c));
    }
    fate = movingBox(survivor.corners, projected.velocities, side, box, rangeMin);
  } else if (BOUNDS == kBoundsPaper) {
    fate = paperBox(a, b, c, (survivor.id >> 31) != 0, box, rangeMin);
  } else {
    fate = boundedBox(a, b, c, box, rangeMin);
  }
  projected.a = TaggedCorner(a, survivor.id);
  projected.b = vec4(b, rangeMin);
  projected.c = TaggedCorner(c, box.rowFirst | box.rowLast << 16);
  return fate;
}

#include "panes.glsl"
#include "project_store.glsl"

// Moves on to the subgroup's next visible cluster; false if none is left. With slabs, which are for few threads, a
// shared counter hands out the next cluster; otherwise each subgroup has a fixed share.
bool nextCluster(inout uint i) {
  if (BINNING == kBinningSlabs) {
    if (gl_SubgroupInvocationID == 0) i = atomicAdd(counters.nextCluster, 1);
    i = subgroupBroadcast(i, 0);
  } else {
    i = i == kNone ? gl_WorkGroupID.x * gl_NumSubgroups + gl_SubgroupID : i + gl_NumWorkGroups.x * gl_NumSubgroups;
  }
  return i < counters.visible;
}

// Returns the position of the n-th set bit.
uint nthSetBit(uint bits, uint n) {
  uint at = 0;
  for (uint width = 16; width > 0; width >>= 1) {
    uint below = bitCount(bits >> at & (1u << width) - 1);
    if (n < below) continue;
    n -= below;
    at += width;
  }
  return at;
}

uvec4 countOf(uint fate) { return uvec4(equal(uvec4(fate), uvec4(kRange, kFace, kBetween, kHidden))); }

// All lanes of the subgroup must call this; `there` is true if the lane has a survivor.
void boundAndStore(Survivor survivor, bool there, inout uvec4 culled) {
  for (uint side = 0; side < sideCount(); ++side) {
    uint fate = kNoTriangle;
    Projected projected;
    Box box;
    if (there) {
      fate = projectOne(survivor, side, projected, box);
      culled += countOf(fate);
    }
    if (subgroupAny(fate == kKeep)) storeKept(fate == kKeep, projected, box, survivor.material);
  }
}

void main() {
  uvec4 culled = uvec4(0);  // range, face, between beams, hidden
  uint nonFinite = 0, triangleCount = 0, lane = gl_SubgroupInvocationID, i = kNone;
  // Most clusters leave few triangles. These wait in the first lanes until every lane has one.
  Survivor survivor;
  uint waiting = 0;
  for (bool more = true; more;) {
    more = nextCluster(i);
    LoadedCluster loaded;
    Vertices vertices;
    uint left = 0;  // one bit for each triangle that needs bounds
    if (more) {
      loaded = loadCluster(i);
      triangleCount += loaded.triangleCount;
      vertices = verticesOf(loaded);
      for (uint first = 0; first < loaded.triangleCount; first += gl_SubgroupSize) {
        uint k = first + lane;
        uvec3 numbers = numbersOf(loaded, triangleCorners.at[loaded.triangleFirst + min(k, loaded.triangleCount - 1)].x);
        uint fate = cullOne(loaded, cornersOf(loaded, vertices, numbers));
        if (k >= loaded.triangleCount) fate = kNoTriangle;
        culled += countOf(fate);
        nonFinite += uint(fate == kNonFinite);
        if (fate == kKeep) left |= 1u << k;
      }
      left = subgroupOr(left);
    }
    uint count = bitCount(left), taken = 0;
    while (taken < count || (!more && waiting > 0)) {
      if (taken < count) {
        uint number = min(taken + lane - min(lane, waiting), count - 1);
        Survivor next = survivorOf(loaded, vertices, nthSetBit(left, number));
        if (lane >= waiting) survivor = next;
      }
      uint there = waiting + count - taken;
      if (more && there < gl_SubgroupSize) {
        waiting = there;
        break;
      }
      boundAndStore(survivor, lane < there, culled);
      taken = min(taken + gl_SubgroupSize - waiting, count);
      waiting = 0;
    }
  }
  culled = subgroupAdd(culled);
  nonFinite = subgroupAdd(nonFinite);
  if (gl_SubgroupInvocationID == 0) {
    if (triangleCount > 0) atomicAdd(counters.triangles, triangleCount);
    if (nonFinite > 0) atomicAdd(counters.nonFinite, nonFinite);
    if (culled.x > 0) atomicAdd(counters.culledByRange, culled.x);
    if (culled.y > 0) atomicAdd(counters.culledByFace, culled.y);
    if (culled.z > 0) atomicAdd(counters.culledBetweenBeams, culled.z);
    if (culled.w > 0) atomicAdd(counters.culledHidden, culled.w);
  }
}
