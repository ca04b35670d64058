// SPDX-License-Identifier: Apache-2.0
// Stage bin: assigns every projected triangle to the beams that hit it. One invocation processes a small box; large
// boxes are cut into tiles and one subgroup processes a tile. PASS selects what happens with a hit. With slabs, a
// subgroup owns a range of columns, all boxes are tiles, listed by slab, and no atomics are needed. Stage project has tried
// the beams of most small boxes itself (isTriedHere()). Small boxes come here if there are lists or footprints, or if each
// column sees the triangle from another place and there are no slabs. Between shells this stage also computes the
// farthest-range table, so that the next shells can skip the triangles behind these ranges.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_shuffle : require
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
#include "inside.glsl"
#include "lanes.glsl"
#include "shared_runs.glsl"
#include "rows_between.glsl"
#include "seen.glsl"
#include "columns_between.glsl"
#include "firing_times.glsl"
#include "nearest_hit.glsl"
#include "occluders.glsl"
#include "panes.glsl"
#include "each_ray.glsl"

layout(local_size_x = 64) in;

// Only the subgroup that owns the beam's slab may call this; therefore no atomics are needed.
void keepNearer(uint beam, bool met, float range, uint id) {
#ifdef INT64_ATOMICS
  // Without a branch, because a store of some lanes takes longer than one of all lanes.
  uint64_t word = packUint2x32(met ? uvec2(id, floatBitsToUint(range)) : uvec2(kNone));
  words64.at[beamEntry(beam)] = min(words64.at[beamEntry(beam)], word);
#endif
}

// A word never grows, so a plain read could skip the atomic. The code does not read first: near triangles come first,
// so most atomics succeed anyway.
void offer(uint beam, float range, uint projected, uint id) {
  if (BINNING == kBinningNearest) {
    offerNearest(beam, range, id);
    return;
  }
  if (MAPPED && beamNumbers.at[beam] == kNone) return;
  if (PASS == kPassBinCount) {
    atomicAdd(listEnds.at[beamEntry(beam)], 1);
  } else {
    uint slot = atomicAdd(listEnds.at[beamEntry(beam)], 1);
    if (slot < frame.candidateCapacity) candidates.at[slot] = projected;
  }
}

// Prepends a candidate to the chain of a beam. A link has three entries: the projected triangle (with a footprint also
// kPaneBit if it is a pane), the range of its hit (with a footprint, the least range), and the link before. Without a
// footprint, the chain has the panes that the beam meets, and the beam is listed when its chain begins.
void link(uint beam, uint projected, uint rangeBits) {
  uint place = atomicAdd(counters.candidates, 1);
  if (place >= frame.candidateCapacity) return;
  uint before = atomicExchange(listEnds.at[beamEntry(beam)], place);
  candidates.at[3 * place] = projected;
  candidates.at[3 * place + 1] = rangeBits;
  candidates.at[3 * place + 2] = before;
  if (PANES && before == kNone) hardBeams.at[atomicAdd(counters.hardBeams, 1)] = beamEntry(beam);
}

#include "bin_footprints.glsl"

// Compilers inline it at every call, so each loop over beams has one call.
void tryBeam(Triangle triangle, Prepared prepared, Turned turned, Beam beam, uint index, uint projected) {
  if (FOOTPRINTS) {
    vec3 side = watertightSides(turned, beam.cosElevation, beam.sinElevation);
    if (!mayMeet(triangle, prepared, side)) return;
    if (CHAINS)
      offerFootprint(triangle, prepared, turned, beam, side, index, projected);
    else
      offer(index, 0.0, projected, triangle.id);
    return;
  }
  float range;
  bool met = meet(triangle, prepared, turned, beam, index, projected, range);
  if (BINNING != kBinningLists && PASS == kPassBinPanes) {
    if (met && comesBefore(range, triangle.id, words.at[beamEntry(index)])) link(index, projected, floatBitsToUint(range));
  } else if (BINNING == kBinningSlabs) {
    keepNearer(index, met, range, triangle.id);
  } else if (met) {
    offer(index, range, projected, triangle.id);
  }
}

// True if a beam has a hit nearer than all of a triangle. Asking costs less than a try if lasers see the triangle from
// different places.
bool isBehindHit(Triangle triangle, uint index) {
  return BINNING != kBinningLists && words.at[beamEntry(index)].y < floatBitsToUint(triangle.rangeMin);
}

Box boxOf(uint slot, vec2 span, uint packedRows) {
  return Box(span.x, span.y, packedRows & 0xffff, packedRows >> 16, TIMED ? projectedTimes.at[slot] : uvec2(0));
}

// Sets the angles by which a triangle seems elsewhere to lasers away from the sensor's origin.
void seemFrom(Triangle triangle) {
  if (!ORIGINS) return;
  vec3 a = triangle.a, b = triangle.b, c = triangle.c;
  seemFromLasers(min(min(a, b), c), max(max(a, b), c));
}

// Prepares a triangle that has been turned to a beam. A footprint needs the triangle's lengths alone, which are the same
// in the frame of the beam.
Prepared preparedFor(Triangle seen, Turned turned) {
  if (FOOTPRINTS && APART && SHIFTS_TURNED) {
    seen.a = vec3(turned.p.x, turned.q.x, turned.z.x);
    seen.b = vec3(turned.p.y, turned.q.y, turned.z.y);
    seen.c = vec3(turned.p.z, turned.q.z, turned.z.z);
  }
  return prepare(seen);
}

#include "bin_waiting.glsl"

// One invocation tries all beams of a box.
void trySmall(uint i) {
  TaggedCorner c = loadedC(i);
  Triangle triangle = triangleOf(loadedA(i), loadedB(i), c.corner);
  Box box = boxOf(i, projectedColumns.at[i], c.tag);
  setViewOf(i);
  Prepared prepared = prepare(triangle);
  lookAtSurface(i);
  uint columnCount = boxColumnCount(box);
  seemFrom(triangle);
  Silhouette silhouette = noSilhouette();
  if (!MOTION) silhouette = silhouetteOf(triangle, prepared, box);
  for (Walk walk = walkOf(box); !ended(box, walk);) {
    Place place;
    Beam beam;
    if (!stepTo(box, columnCount, silhouette, walk, beam, place)) continue;
    if (MOTION && LISTED && isBehindHit(triangle, place.index)) continue;
    Triangle seen = triangle;
    if (APART) seen = seenFrom(triangle, i, place.column, place.row, beam.azimuth);
    Turned turned = turnedFrom(seen, place.row, place.index, beam.azimuth);
    if (APART) prepared = preparedFor(seen, turned);
    tryBeam(seen, prepared, turned, beam, place.index, i);
  }
}

#include "bin_tile.glsl"

// Computes the entries of the farthest-range table in a slab that may have changed: those in rows first..last, and
// those in which project has found hits.
void writeTable(uint slab, uint first, uint last) {
  uint from = slab << frame.slabShift, end = min(from + (1 << frame.slabShift), frame.columns);
  uint perRow = (frame.columns - 1) / kCoarseColumns + 1;
  for (uint y = 0; y * kCoarseRows < frame.rows; ++y)
    for (uint x = from / kCoarseColumns; x * kCoarseColumns < end; ++x) {
      bool binned = first < (y + 1) * kCoarseRows && last >= y * kCoarseRows;
      if (!binned && staleEntries.at[firstStale() + y * perRow + x] == 0) continue;
      computeEntry(uvec2(x, y));
      if (subgroupElect()) staleEntries.at[firstStale() + y * perRow + x] = 0;
    }
}

// Computes the whole farthest-range table, where slabs do not write it. One subgroup per coarse entry.
void writeWholeTable() {
  uint perRow = (frame.columns + kCoarseColumns - 1) / kCoarseColumns,
       count = perRow * ((frame.rows + kCoarseRows - 1) / kCoarseRows);
  uint stride = gl_NumWorkGroups.x * gl_NumSubgroups;
  uint all = VIEWS ? count * frame.views : count;
  for (uint i = gl_WorkGroupID.x * gl_NumSubgroups + gl_SubgroupID; i < all; i += stride) {
    lookFrom(i / count);
    uint entry = i - view * count;
    computeEntry(uvec2(entry % perRow, entry / perRow));
  }
  if (gl_WorkGroupID == uvec3(0) && gl_LocalInvocationID.x == 0) {
    counters.binnedSmall = counters.projectedSmall;
    counters.binnedTiles = counters.tiles;
  }
}

// With slabs, the panes have lists of their own.
bool isInPass(uint projected) {
  return !PANES || BINNING != kBinningNearest || isPane(projected) == (PASS == kPassBinPanes);
}

// Takes the next slab and returns the last tile of its list, which it leaves empty for the next shell; kNone if the
// list is empty. A shared counter hands out the slabs.
uint takeSlab(uint slabs, out uint slab) {
  uint tile = kNone;
  slab = 0;
  if (subgroupElect()) {
    slab = atomicAdd(shells.of[pass.shell].nextSlab, 1);
    if (slab < slabs) tile = atomicExchange(slabEnds.at[PASS == kPassBinPanes ? slabs + slab : slab], kNone);
  }
  slab = subgroupBroadcastFirst(slab);
  return subgroupBroadcastFirst(tile);
}

// Processes the tiles of slab after slab.
void trySlabs() {
  uint perView = (frame.columns - 1 >> frame.slabShift) + 1, slabs = VIEWS ? perView * frame.views : perView, slab = kNone;
  uint rowFirst = 0, rowLast = 0;  // of the slab's tiles
  for (uint t = kNone; true;) {
    if (t == kNone) {
      if (slab != kNone && pass.table != kTableNone) writeTable(slab - view * perView, rowFirst, rowLast);
      t = takeSlab(slabs, slab);
      if (slab >= slabs) return;
      lookFrom(slab / perView);
      rowFirst = frame.rows;
      rowLast = 0;
      continue;
    }
    Tile tile = tileAt(t);
    if (isInPass(tile.slot)) tryTile(tile);
    subgroupMemoryBarrierBuffer();  // in the next tile, other lanes access these words
    meetAgain();
    rowFirst = min(rowFirst, tile.box.rowFirst);
    rowLast = max(rowLast, tile.box.rowLast);
    t = tile.before;
  }
}

// Returns the subgroup's next share of the work. On a CPU a shared counter hands out `together` shares of a shell at once,
// because they differ much; otherwise each subgroup has a fixed part of them.
uint nextShare(uint last, uint together) {
  uint subgroups = gl_NumWorkGroups.x * gl_NumSubgroups, share = gl_WorkGroupID.x * gl_NumSubgroups + gl_SubgroupID;
  if (kLanesInStep && BINNING == kBinningNearest) {
    if (last != kNone && (last + 1) % together != 0) return last + 1;
    if (isFirstLane()) share = atomicAdd(shells.of[pass.shell].nextSlab, together);
    return fromFirstLane(share);
  }
  return last == kNone ? share : last + subgroups;
}

// Tries the projected triangles without slabs: the tiles, and those with small boxes, of which each lane takes one. Tiles
// come first, because large triangles hide many small ones.
void tryProjected(uint firstSmall, uint firstTile) {
  uint end = counters.projectedSmall, small = (end - firstSmall + gl_SubgroupSize - 1) / gl_SubgroupSize;
  uint tileCount = counters.tiles - firstTile, all = tileCount + small;
  // Neighbouring triangles are tried by one thread, since threads that write the words of the same beams wait for each
  // other's cache lines: with one share at once, binning footprints took 1.3 of the time on two cores. There are enough
  // parts for 16 threads.
  uint together = clamp(all / 32, 1, 64);
  for (uint share = nextShare(kNone, together); WAITS || share < all; share = nextShare(share, together)) {
    if (share < tileCount) {
      Tile tile = tileAt(firstTile + share);
      setViewOf(tile.slot);
      if (isInPass(tile.slot)) tryTile(tile);
    } else {
      bool none = share >= all;  // a last round offers the triangles that still wait
      uint i = firstSmall + (share - tileCount) * gl_SubgroupSize + gl_SubgroupInvocationID;
      bool there = !none && i < end && isInPass(i);
      if (WAITS)
        trySmallTogether(i, there, none);
      else if (there)
        trySmall(i);
      meetAgain();  // the lanes have left the walks through their boxes one by one
      if (none) return;
    }
  }
}

void countOwnLinks() {
  uint sum = subgroupAdd(ownLinkCount);
  if (subgroupElect() && sum > 0) atomicAdd(counters.ownLinks, sum);
}

void main() {
  useOwnAddresses();
  loadMotion();
  if (PASS == kPassBinTable) {
    writeWholeTable();
    return;
  }
  loadFootprint();
  // If a list was too small, the host enlarges it and runs the scan again.
  if (counters.projectedSmall + counters.projectedLarge > frame.projectedCapacity ||
      counters.tiles > frame.tileCapacity)
    return;
  // With slabs, all triangles are in tiles. With kBinningNearest each shell bins only its new triangles; otherwise, and for
  // panes, one pass bins all of them.
  bool byShell = BINNING == kBinningNearest && PASS == kPassBinNearest;
  if (BINNING == kBinningSlabs)
    trySlabs();
  else
    tryProjected(byShell ? counters.binnedSmall : 0, byShell ? counters.binnedTiles : 0);
  if (CHAINS) countOwnLinks();
}
