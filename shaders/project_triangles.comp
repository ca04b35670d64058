// SPDX-License-Identifier: Apache-2.0
// Last pass of the stage project. One subgroup per visible cluster. First each invocation transforms a vertex to the
// sensor's frame, then it culls a triangle; the triangles that are left, collected from several clusters until they
// fill the subgroup, get exact angular bounds. Writes every triangle that a beam may hit, with a box that contains all
// such beams.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#extension GL_KHR_shader_subgroup_vote : require
#extension GL_EXT_scalar_block_layout : require
#ifdef INT64_ATOMICS
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
#endif
#include "common/shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "views.glsl"
#include "motion.glsl"
#include "sphere.glsl"
#include "bounds.glsl"
#include "common/beam.h"
#include "lanes.glsl"
#include "shared_runs.glsl"
#include "to_sensor.glsl"
#include "firing_times.glsl"
#include "cull.glsl"
#include "limits.glsl"
#include "deformed.glsl"
#include "cluster_corners.glsl"
#define HOLES_ARE_AT_HAND
bool inHole(uint slot, vec3 weights);
#include "inside.glsl"
#undef HOLES_ARE_AT_HAND
#include "rows_between.glsl"
#include "columns_between.glsl"
#include "nearest_hit.glsl"
#include "seen.glsl"

layout(local_size_x = 64) in;

const uint kKeep = 0, kNonFinite = 1, kRange = 2, kFace = 3, kBetween = 4, kHidden = 5, kNoTriangle = 6;

// A projected triangle as arrays.h describes it.
struct Projected {
  TaggedCorner a;
  vec4 b;
  TaggedCorner c;
  TextureCorners inTexture;  // only with cut-outs
  mat3 velocities;           // of the corners; only with motion or origins, as is the next one
  bool moves;                // the triangle itself
  mat3 seen;                 // the corners as a column near the box sees them; only with motion, as is the next one
  bool inOneFrame;           // whether `seen` is known
};

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
  return (CULLING & kCullOccluded) != 0 && pass.occluders != 0 && !isSmall(box) &&
         occluded(Window(box.rowFirst, box.rowLast + 1, box.columnMin, box.columnMax), rangeMin);
}

// True if no beam lies in a box of few rows, although it has cells of a list, or columns between which rows look.
bool withoutBeams(Box box) {
  if (!BESIDE_COLUMNS || boxRowCount(box) > kFewRows) return false;
  if (!LISTED) {
    bool any = false;
    for (uint row = box.rowFirst; row <= box.rowLast; ++row) {
      vec2 behind = behindIn(row, box);
      any = any || ceil(box.columnMin - behind.y) <= floor(box.columnMax - behind.x);
    }
    return !any;
  }
  uint first = wrapColumn(firstColumn(box)), end = first + boxColumnCount(box), beams = 0;
  for (uint row = box.rowFirst; row <= box.rowLast; ++row) {
    uint cell = cellEntry(row * frame.columns);
    beams += cellStarts.at[cell + min(end, frame.columns)] - cellStarts.at[cell + first];
    if (end > frame.columns) beams += cellStarts.at[cell + end - frame.columns] - cellStarts.at[cell];
  }
  return beams == 0;
}

// Computes the outline of points from the span of their elevation keys and a margin, which is much cheaper than
// outlineOf(). `size` is that of the box around them, and `rangeMin` the range of its nearest point. An edge that spans d
// radians (at most its length divided by the nearest range) rises above its ends by at most d^2 / 8 times the tangent of
// its elevation, which is at most 2.4 here: for d up to 0.2 and keys up to 0.6. Returns false for any other points.
bool narrowOutline(float keyMin, float keyMax, vec3 size, float rangeMin, out Outline outline) {
  float squares = dot(size, size) / (rangeMin * rangeMin);
  float widening = 0.35 * squares + keySlack();
  outline = Outline(keyMin - widening, keyMax + widening);
  return squares < 0.04 && max(-keyMin, keyMax) < 0.6;
}

bool narrowOutline(vec3 a, vec3 b, vec3 c, float rangeMin, out Outline outline) {
  vec3 size = max(max(a, b), c) - min(min(a, b), c), keys = keysOf(a, b, c);
  float keyMin = min(min(keys.x, keys.y), keys.z), keyMax = max(max(keys.x, keys.y), keys.z);
  return narrowOutline(keyMin, keyMax, size, rangeMin, outline);
}

// Sets the columns of a triangle with a narrow outline; false if it lies between two columns. Seen from corner a the
// others are less than 0.4 radians away, where the tangent of an angle exceeds the angle only a little.
bool coverNarrowColumns(vec3 a, vec3 b, vec3 c, Outline outline, inout Box box) {
  float slack = columnSlack(outline.keyMin, outline.keyMax);
  box.columnMin = 0.0;
  box.columnMax = float(frame.columns);
  if (slack > 0.25 * float(frame.columns)) return true;
  float start = azimuthOf(a.y, a.x);
  float toB = (a.x * b.y - a.y * b.x) / dot(a.xy, b.xy), toC = (a.x * c.y - a.y * c.x) / dot(a.xy, c.xy);
  float low = min(min(toB, toC), 0.0), high = max(max(toB, toC), 0.0);
  box.columnMin = columnAt(start + low) - slack;
  box.columnMax = box.columnMin + (high - low) * frame.columnsPerRadian + 2.0 * slack;
  return !betweenColumns(box.columnMin, box.columnMax);
}

// True if neither motion nor rounding can change the side. In the frames of the columns each corner is up to `shift`
// elsewhere and rounded anew, by up to 6e-7 of its distance. Both edges change by that and by their share `bend`.
bool facesAwayThroughout(vec3 a, vec3 b, vec3 c, float shift, float bend) {
  vec3 u = b - a, v = c - a, normal = cross(u, v);
  float distance = max(max(length(a), length(b)), length(c)) + shift, lengthU = length(u), lengthV = length(v);
  float changeU = bend * lengthU + 1.2e-6 * distance, changeV = bend * lengthV + 1.2e-6 * distance;
  float turned = lengthU * changeV + lengthV * changeU + changeU * changeV;  // the most by which the normal changes
  return dot(normal, a) > distance * (2e-6 * lengthU * lengthV + 1.00001 * turned) + 1.00001 * length(normal) * shift;
}

// The culling tests that need no exact bounds. All lanes run all of them, because loads in divergent branches cost
// more.
uint culledEarly(vec3 a, vec3 b, vec3 c, bool oneSided) {
  vec3 low = min(min(a, b), c), high = max(max(a, b), c);
  float rangeMin = nearestPoint(low, high);
  uint fate = kKeep;
  setSeeming(0.0);  // it is that of the last triangle
  if (ORIGINS) {
    seemFromLasers(low, high);
    rangeMin = max(rangeMin - motion.shift, 0.0);
  }
  // If one subgroup processes all triangles of a cluster at once, this extra test saves no time.
  if (BOUNDS == kBoundsExact && gl_SubgroupSize < kClusterTriangles) {
    Outline outline;
    Box box;
    bool narrow = narrowOutline(a, b, c, rangeMin, outline);
    fate = narrow && !coverRows(outline, box) ? kBetween : kKeep;
  }
  bool away = ORIGINS ? facesAwayThroughout(a, b, c, motion.shift, 0.0) : facesAway(a, b, c);
  fate = oneSided && away ? kFace : fate;
  return outOfRange(a, rangeMin) ? kRange : fate;
}

uint boundedBox(vec3 a, vec3 b, vec3 c, out Box box, float rangeMin) {
  Outline outline;
  bool some;
  if (BOUNDS == kBoundsExact && narrowOutline(a, b, c, rangeMin, outline)) {
    some = coverRows(outline, box) && coverNarrowColumns(a, b, c, outline, box);
  } else {
    outline = outlineOf(a, b, c);
    some = coverRows(outline, box) && coverColumns(a, b, c, outline, box);
  }
  if (!some || withoutBeams(box)) return kBetween;
  return hidden(box, rangeMin) ? kHidden : kKeep;
}

#include "project_motion.glsl"
#include "project_silhouettes.glsl"

// Devices round quotients and roots, so the sine of a corner straight above may exceed 1, for which asin is undefined.
float elevationOf(vec3 p) { return asin(clamp(p.z / length(p), -1.0, 1.0)); }

// Section 3 of the paper: one-sided faces need n . v0 < 0; the box is the floor of the corners' angles.
uint paperBox(vec3 a, vec3 b, vec3 c, bool oneSided, out Box box, out float rangeMin) {
  rangeMin = abs(dot(normalize(cross(b - a, c - a)), a));
  if (outOfRange(a, rangeMin)) return kRange;
  if (oneSided && dot(cross(b - a, c - a), a) >= 0.0) return kFace;
  vec3 elevation = vec3(elevationOf(a), elevationOf(b), elevationOf(c));
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
  if (MOTION && !atRest(loaded.bound.x > 0.0)) {
    if (BOUNDS != kBoundsPaper) fate = culledMoving(a, b, c, isOneSided(loaded), loaded.bound);
  } else if (BOUNDS != kBoundsPaper) {
    fate = culledEarly(a, b, c, isOneSided(loaded));
  }
  // No beam hits a triangle that a deformation has reduced to a line, unless it grows within the scan.
  bool grows = MOTION && loaded.bound.x > 0.0;
  if (DEFORMED != kDeformsNothing && !grows && (a == b || b == c || c == a)) fate = kBetween;
  return inLimits(a) && inLimits(b) && inLimits(c) ? fate : kNonFinite;
}

// A triangle that passed the early culling; it may belong to an earlier cluster than the current one.
struct Survivor {
  mat3 corners;
  uint id;         // the top bit says one-sided
  uvec3 vertices;  // entries in `positions`
  uint cluster;
  uint material;   // only with a footprint
  uint view;       // only with several views
  uint instance;  // only with motion, as is the next one
  bool moves;     // the instance
};

// Returns the k-th triangle of a cluster. All lanes of the subgroup must call this.
Survivor survivorOf(LoadedCluster loaded, Vertices vertices, uint k) {
  uvec2 triangle = triangleCorners.at[loaded.triangleFirst + k];
  uvec3 numbers = numbersOf(loaded, triangle.x);
  Survivor survivor;
  survivor.corners = cornersOf(loaded, vertices, numbers);
  survivor.id = placedFirstOf(loaded.instance) + triangle.y | (isOneSided(loaded) ? 1u << 31 : 0u);
  survivor.vertices = loaded.vertexFirst + numbers;
  survivor.cluster = loaded.cluster;
  survivor.material = loaded.material;
  survivor.view = VIEWS ? instanceViews.at[loaded.number] : 0;
  survivor.instance = loaded.number;
  survivor.moves = MOTION && loaded.bound.x > 0.0;
  return survivor;
}

uint projectOne(Survivor survivor, inout Interval interval, out Projected projected, out Box box) {
  vec3 a = survivor.corners[0], b = survivor.corners[1], c = survivor.corners[2];
  float rangeMin = nearestPoint(min(min(a, b), c), max(max(a, b), c));
  uint fate;
  if (APART) {
    projected.velocities = mat3(0.0);
    projected.moves = survivor.moves;
    if (MOTION && projected.moves) {
      InstanceMotion moving = instanceMotions.at[survivor.instance];
      uvec3 vertices = survivor.vertices;
      projected.velocities = mat3(vertexVelocity(moving, survivor.instance, survivor.cluster, vertices.x),
                                  vertexVelocity(moving, survivor.instance, survivor.cluster, vertices.y),
                                  vertexVelocity(moving, survivor.instance, survivor.cluster, vertices.z));
    }
    fate = movingBox(survivor.corners, survivor.moves, interval, projected, box, rangeMin);
  } else if (BOUNDS == kBoundsPaper) {
    fate = paperBox(a, b, c, (survivor.id >> 31) != 0, box, rangeMin);
  } else {
    fate = boundedBox(a, b, c, box, rangeMin);
  }
  projected.a = TaggedCorner(a, survivor.id);
  projected.b = vec4(b, rangeMin);
  projected.c = TaggedCorner(c, box.rowFirst | box.rowLast << 16);
  if ((EFFECTS & kCutOuts) != 0 && fate == kKeep) {
    projected.inTexture.a = textureCoordinates.at[survivor.vertices.x];
    projected.inTexture.b = textureCoordinates.at[survivor.vertices.y];
    projected.inTexture.c = textureCoordinates.at[survivor.vertices.z];
  }
  return fate;
}

#include "panes.glsl"
#include "project_store.glsl"

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

#include "project_tries.glsl"
#include "project_few_beams.glsl"

// Sets the beams that are tried on all triangles of a cluster, if they are few, and returns true if every beam that may
// meet the cluster has a hit nearer than it by now. The cluster was not hidden when project_clusters listed it, but since
// then this kernel has tried other triangles of the same shell. Each lane may ask about another cluster.
bool isHiddenByNow(uvec2 pair, uint material, uint vertexCount, out FewBeams few) {
  few.count = 0;
  bool triesHere = BINNING == kBinningSlabs && BOUNDS != kBoundsPaper && (!ORIGINS || SHIFTS_TURNED);
  if (!triesHere) return false;
  if (DEFORMED != kDeformsNothing && deformers.at[instanceMeshes.at[pair.x]].deformed != 0) return false;
  vec3 low, high;
  Instance instance = loadedInstance(pair.x);
  Group box = loadedBox(pair.y);
  sensorBox(instance, box.low, box.high, low, high);
  setView(pair.x);
  if (MOTION) widenByMotion(pair.x, box.low, box.high, low, high);
  setSeeming(0.0);
  float nearest = seemFromSensor(low, high);
  if (APART && (seeming > 1.0 || !(nearest > 0.0))) return false;
  Window window = windowInTime(low, high, nearest);
  if (mayTryAll(material, vertexCount) && inLimits(low) && inLimits(high) && window.first < window.end &&
      hasFewBeams(window, kBeamsTriedOnAll)) {
    uvec2 span = columnsOf(window);
    few.rowFirst = window.first;
    few.columnFirst = span.x;
    few.columnCount = span.y - span.x;
    few.count = few.columnCount * (window.end - window.first);
    few.nearest = nearest;
    few.test = lineTestOf(instance, box.low, box.high);
    return few.count == 0;
  }
  return (CULLING & kCullOccluded) != 0 && hasFewBeams(window, kBeamsAskedAgain) && behindHits(window, nearest);
}

// Moves on to the subgroup's next visible cluster; false if none is left. On a CPU, which has few threads, a shared
// counter hands out the next clusters; otherwise each subgroup has a fixed share. A cluster that is hidden by now is
// returned with no triangles.
bool nextCluster(inout uint next, inout Batch batch, inout FewBeams ofBatch, inout LoadedCluster loaded,
                 inout FewBeams few) {
  if (batch.done == batch.count) {
    uint near = shells.of[pass.shell].visible;
    uint count = BINNING == kBinningSlabs ? near + shells.of[pass.shell].visibleBehind : near;
    uint subgroups = gl_NumWorkGroups.x * gl_NumSubgroups, stride = 1, i;
    uint wanted = gl_SubgroupSize;
    if (BINNING == kBinningSlabs || kLanesInStep) {
      wanted = min(count / (4 * subgroups) + 1, gl_SubgroupSize);
      if (isFirstLane()) i = atomicAdd(shells.of[pass.shell].nextCluster, wanted);
      i = fromFirstLane(i);
    } else {
      stride = subgroups;
      i = next;
      next += stride * wanted;
    }
    if (i >= count) return false;
    batch.count = min(wanted, (count - i + stride - 1) / stride);
    batch.done = 0;
    uint entry = gl_SubgroupInvocationID < batch.count ? i + gl_SubgroupInvocationID * stride : i;
    loadBatch(entry < near ? entry : pass.clusters - 1 - (entry - near), batch);
    if (isHiddenByNow(batch.pair, batch.material, batch.counts & 0xffff, ofBatch)) batch.counts = 0;
  }
  if (BINNING == kBinningSlabs) few = fromLane(ofBatch, batch.done);
  loadNext(batch, loaded);
  return true;
}

bool stored = false;  // whether this subgroup has stored any triangle

// All lanes of the subgroup must call this; `there` is true if the lane has a survivor. With motion, a triangle may
// have several boxes, for intervals of the scan.
void boundAndStore(Survivor survivor, bool there, inout uvec4 culled) {
  Interval interval = wholeScan();
  bool any = false;
  while (true) {
    uint fate = kNoTriangle;
    Projected projected;
    Box box;
    bool shares = false;
    if (there) {
      lookFrom(survivor.view);
      fate = projectOne(survivor, interval, projected, box);
      any = any || fate == kKeep;
      there = MOTION && !isEmpty(interval);
      if (!there && !any) culled += countOf(fate);
    }
    if (fate == kKeep) {
      Triangle triangle = triangleOf(projected.a, projected.b, projected.c.corner);
      if (MOTION) triangle.moves = projected.moves;
      Prepared prepared = prepare(triangle);
      Silhouette silhouette = noSilhouette();
      if (!MOTION) {
        silhouette = silhouetteOf(triangle, prepared, box);
      } else if (BINNING == kBinningSlabs && projected.inOneFrame) {
        silhouette = STAGGERED ? driftingSilhouette(triangle, survivor.corners, projected, box)
                               : silhouetteOf(triangle, projected.seen, box);
      }
      if (isTriedHere(box, silhouette, survivor.material, survivor.moves)) {
        if ((EFFECTS & kCutOuts) != 0) {
          triedSurface = optics.at[survivor.material];
          triedTexture = projected.inTexture;
        }
        shares = SHARES_BEAMS;
        if (!shares) tryBox(triangle, projected.velocities, prepared, silhouette, box);
        fate = kNoTriangle;
      }
    }
    if (SHARES_BEAMS) tryBoxes(shares, projected, box);
    if (subgroupAny(fate == kKeep)) {
      storeKept(fate == kKeep, projected, box, survivor.material);
      stored = true;
    }
    if (!MOTION || !subgroupAny(there)) return;
  }
}

// Returns one bit for each triangle of a cluster that is not culled, and counts the culled ones. Each lane looks at one
// triangle at a time, so all lanes of the subgroup must call this.
uint cullAll(LoadedCluster loaded, Vertices vertices, inout uvec4 culled, inout uint nonFinite) {
  uint left = 0;
  for (uint first = 0; first < loaded.triangleCount; first += gl_SubgroupSize) {
    uint k = first + gl_SubgroupInvocationID;
    uvec3 numbers = numbersOf(loaded, triangleCorners.at[loaded.triangleFirst + min(k, loaded.triangleCount - 1)].x);
    uint fate = cullOne(loaded, cornersOf(loaded, vertices, numbers));
    if (k >= loaded.triangleCount) fate = kNoTriangle;
    culled += countOf(fate);
    nonFinite += uint(fate == kNonFinite);
    if (fate == kKeep) left |= 1u << k;
  }
  return subgroupOr(left);
}

// Adds the counts of all lanes to the counters. All lanes of the subgroup must call this.
void addCounts(uvec4 culled, uint nonFinite, uint triangleCount) {
  culled = subgroupAdd(culled);
  nonFinite = subgroupAdd(nonFinite);
  triedCount = subgroupAdd(triedCount);
  if (subgroupElect()) {
    if (stored || triedCount > 0) atomicMax(shells.of[pass.shell].binWork.x, frame.triangleWorkgroups);
    if (triedCount > 0) atomicAdd(counters.tried, triedCount);
    if (triangleCount > 0) atomicAdd(counters.triangles, triangleCount);
    if (nonFinite > 0) atomicAdd(counters.nonFinite, nonFinite);
    if (culled.x > 0) atomicAdd(counters.culledByRange, culled.x);
    if (culled.y > 0) atomicAdd(counters.culledByFace, culled.y);
    if (culled.z > 0) atomicAdd(counters.culledBetweenBeams, culled.z);
    if (culled.w > 0) atomicAdd(counters.culledHidden, culled.w);
  }
}

void main() {
  useOwnAddresses();
  loadMotion();
  uvec4 culled = uvec4(0);  // range, face, between beams, hidden
  uint nonFinite = 0, triangleCount = 0, lane = gl_SubgroupInvocationID;
  uint next = gl_WorkGroupID.x * gl_NumSubgroups + gl_SubgroupID;
  Batch batch;
  batch.count = batch.done = 0;
  LoadedCluster loaded;
  loaded.number = kNone;
  FewBeams ofBatch, few;
  few.count = 0;
  // Most clusters leave few triangles. These wait in the first lanes until every lane has one.
  Survivor survivor;
  uint waiting = 0;
  for (bool more = true; more;) {
    more = nextCluster(next, batch, ofBatch, loaded, few);
    if (more) setView(loaded.number);
    if (more && few.count > 0 && loaded.triangleCount > 0) {
      if (tryOnAll(loaded, few)) {
        triangleCount += loaded.triangleCount;
        if (lane == 0) triedCount += loaded.triangleCount;
      }
      loaded.triangleCount = 0;
    }
    Vertices vertices;
    uint left = 0;  // one bit for each triangle that needs bounds
    if (more && loaded.triangleCount > 0) {
      triangleCount += loaded.triangleCount;
      vertices = verticesOf(loaded);
      left = cullAll(loaded, vertices, culled, nonFinite);
    }
    uint count = bitCount(left), taken = 0;
    while (taken < count || (!more && waiting > 0)) {
      if (taken < count) {
        uint number = min(taken + lane - min(lane, waiting), count - 1);
        Survivor added = survivorOf(loaded, vertices, nthSetBit(left, number));
        if (lane >= waiting) survivor = added;
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
  addCounts(culled, nonFinite, triangleCount);
}
