// SPDX-License-Identifier: Apache-2.0
// Stage bin: assigns every projected triangle to the beams that hit it. One invocation processes a small box; large
// boxes are cut into tiles and one subgroup processes a tile. PASS selects what happens with a hit. With slabs, a
// subgroup owns a range of columns, all boxes are tiles, listed by slab, and no atomics are needed. Unless there are
// lists, small boxes do not come here: project has tried their beams. Between shells this stage also computes the
// farthest-range table, so that the next shells can skip what lies behind.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
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
  if (PASS == kPassCount) {
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
  if (BINNING != kBinningLists && PASS == kPassPanes) {
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

// A tile's triangle and its range of columns in the triangle's box, the same for all lanes.
struct Tile {
  uint slot;
  Triangle triangle;
  Box box;
  uint first, end;
  uint column;  // the tile's first column, wrapped
  uint before;  // previous tile in the slab's list
};

// Returns the sensor column of column k of the tile's box, without azimuth offset.
uint columnOf(Tile tile, uint k) {
  uint column = tile.column + (k - tile.first);
  return min(column, column - frame.columns);  // after the last column comes the first again
}

Tile tileAt(uint t) {
  uvec4 tile = LOADED_4(tiles.at[t]);
  uint slot = tile.x;
  TaggedCorner a = TaggedCorner(LOADED_3(projectedA.at[slot].corner), projectedA.at[slot].tag);
  TaggedCorner c = TaggedCorner(LOADED_3(projectedC.at[slot].corner), projectedC.at[slot].tag);
  Box box = boxOf(slot, LOADED_2(projectedColumns.at[slot]), c.tag);
  Triangle triangle = triangleOf(a, LOADED_4(projectedB.at[slot]), c.corner);
  return Tile(slot, triangle, box, tile.y, min(tile.y + tile.z, boxColumnCount(box)),
              wrapColumn(firstColumn(box) + int(tile.y)), tile.w);
}

// The angle by which a triangle at rest appears to move while the beams of `count` neighbouring columns fire.
float driftWithin(Triangle triangle, float count) {
  if (STAGGERED) count += frame.shiftMax - frame.shiftMin;
  return seemingAngle(motion.shiftPerColumn, motion.turnPerColumn, triangle.rangeMin) * count;
}

// True if the sensor's vertical axis may pass through a triangle, or within `margin` metres of it. The columns of a box
// do not tell this, because the boxes of a moving sensor are cut to intervals of the scan.
bool mayMeetAxis(Turned turned, float margin) {
  vec3 p = turned.p, q = turned.q;
  return min(min(p.x, p.y), p.z) <= margin && max(max(p.x, p.y), p.z) >= -margin &&
         min(min(q.x, q.y), q.z) <= margin && max(max(q.x, q.y), q.z) >= -margin;
}

// Narrows the rows of a box to from..to - 1, the rows whose beams in columns kFrom..kTo may hit the triangle. Each
// lane computes its own range of columns.
void rowsIn(Tile tile, Prepared prepared, uint kFrom, uint kTo, float angle, out uint from, out uint to) {
  uint rowCount = boxRowCount(tile.box);
  from = 0;
  to = rowCount;
  // A small tile does not repay this work, and the paper's bounds must stay as they are.
  bool pays = rowCount * (tile.end - tile.first) > kFewBeams;
  if (!pays || BOUNDS == kBoundsPaper) return;
  uint first = columnOf(tile, kFrom);
  uint last = columnOf(tile, kTo + uint(ceil(BESIDE)));
  Triangle triangle = tile.triangle;
  if (MOTION) {
    // Columns at the seam fire at the start or at the end of the scan; the seam is not the same in each row.
    float early = float(first) - frame.shiftMax, late = float(last) - frame.shiftMin;
    if (triangle.moves || last < first || boxColumnCount(tile.box) == frame.columns ||
        (STAGGERED && (early < 0.0 || late > float(frame.columns - 1))))
      return;
    triangle = seenFrom(triangle, tile.slot, tile.box.rowFirst, first);
  }
  vec3 far = vec3(length(triangle.a), length(triangle.b), length(triangle.c));
  float blur = blurOf(triangle, prepared, far);
  if (MOTION) blur += driftWithin(triangle, angle * frame.columnsPerRadian);
  if (ORIGINS) blur += seemingAngle(motion.origins, 0.0, triangle.rangeMin);
  if (angle + blur > 0.5) return;
  float keyMin, keyMax, farthest = max(max(far.x, far.y), far.z);
  Turned turned = turn(triangle, loadedColumn(first));
  keysBetween(turned, turn(triangle, loadedColumn(last)), blur * farthest, keyMin, keyMax);
  // A thousandth of the distance is ten times what poleInside() allows for rounding.
  if (mayMeetAxis(turned, (blur + 1e-3) * farthest)) {
    if (min(min(tile.triangle.a.z, tile.triangle.b.z), tile.triangle.c.z) < 0.0) keyMin = -1.0;
    if (max(max(tile.triangle.a.z, tile.triangle.b.z), tile.triangle.c.z) > 0.0) keyMax = 1.0;
  }
  float widening = kKeySlack + blur + 0.25 * (angle + blur) * (angle + blur);
  rowsBetween(keyMin - widening, keyMax + widening, from, to);
  from = max(from, tile.box.rowFirst) - tile.box.rowFirst;
  to = max(min(to, tile.box.rowLast + 1), tile.box.rowFirst) - tile.box.rowFirst;
}

#include "bin_lists.glsl"

// Loads a word near a column in each of the rows from..to - 1. The loop over these rows needs their words one after the
// other and would wait for memory at each; here it waits once. The result is always true, because no triangle has such
// a number, but the compiler does not know that and keeps the loads. Where lanes do not run in step, another lane may be
// writing such a word.
bool areAtHand(uint from, uint to, uint column) {
  if (BINNING != kBinningSlabs || LISTED || !kLanesInStep) return true;
  uint largest = 0;
  for (uint row = from; row < to; row += gl_SubgroupSize)
    largest = max(largest, words.at[firstWord() + min(row + gl_SubgroupInvocationID, to - 1) * frame.columns +
                                    min(column, frame.columns - 1)].x + 1);
  return largest != kNone;
}

Prepared preparedInTile(Triangle triangle) { return WAITS ? preparedForAll(triangle) : prepare(triangle); }

// One subgroup tries all beams of one tile. The lanes cover `width` columns; if the tile has fewer columns than the
// subgroup has lanes, they cover several rows as well.
void tryTile(Tile tile) {
  lookAtSurface(tile.slot);
  if (TIMED && LISTED) {
    tryFiring(tile);
    return;
  }
  Prepared prepared = preparedInTile(tile.triangle);
  Box box = tile.box;
  uint lane = gl_SubgroupInvocationID;
  uint columnCount = tile.end - tile.first;
  uint shift = columnCount > 1 ? min(findMSB(columnCount - 1) + 1, findMSB(gl_SubgroupSize)) : 0;
  uint width = 1 << shift, height = gl_SubgroupSize >> shift;
  float angle = (float(width) + ceil(BESIDE)) / frame.columnsPerRadian;
  uint stride = frame.columns;
  // If all lasers of a column see the triangle at one time, it is prepared and turned once per column.
  bool shifts = ORIGINS && SHIFTS_TURNED, byColumn = !BESIDE_COLUMNS && !STAGGERED;
  if (ORIGINS) byColumn = byColumn && SHIFTS_TURNED && (!FOOTPRINTS || WAITS);
  // Each lane holds the angles of one row. Most boxes have no more rows than the subgroup has lanes.
  vec2 angles = loadedRow(min(box.rowFirst + lane, box.rowLast)).angles.xy;
  uint azimuths = AZIMUTH_OFFSETS ? loadedRow(min(box.rowFirst + lane, box.rowLast)).azimuths : 0, loaded = 0;
  for (uint part = tile.first; part < tile.end; part += width * gl_SubgroupSize) {
    uint kFrom = min(part + lane * width, tile.end - 1), from, to;
    rowsIn(tile, prepared, kFrom, min(kFrom + width, tile.end) - 1, angle, from, to);
    uint blocks = min((tile.end - part + width - 1) >> shift, gl_SubgroupSize);
    for (uint j = 0; j < blocks; ++j) {
      uint row = subgroupShuffle(from, j), rowEnd = subgroupShuffle(to, j);
      if (row >= rowEnd) continue;
      uint k = part + j * width + (lane & (width - 1));
      uint column = columnOf(tile, min(k, tile.end - 1));
      if (!areAtHand(box.rowFirst + row, box.rowFirst + rowEnd, column)) continue;
      vec2 azimuth = loadedColumn(column);
      Triangle seen = tile.triangle;
      if (byColumn) seen = seenFrom(tile.triangle, tile.slot, 0, column);
      if (MOTION && byColumn && (!WAITS || seen.moves)) prepared = preparedInTile(seen);
      Turned turned = turn(seen, azimuth), own = turned;
      uint mineEnd = k < tile.end ? rowEnd : 0;
      while (row < rowEnd) {
        uint base = row & ~(gl_SubgroupSize - 1);
        if (base != loaded) {
          angles = loadedRow(min(box.rowFirst + base + lane, box.rowLast)).angles.xy;
          if (AZIMUTH_OFFSETS) azimuths = loadedRow(min(box.rowFirst + base + lane, box.rowLast)).azimuths;
        }
        loaded = base;
        uint stop = min(rowEnd, base + gl_SubgroupSize);
        for (; row < stop; row += height) {
          uint mine = row + (lane >> shift);
          vec2 elevation = subgroupShuffle(angles, mine & (gl_SubgroupSize - 1));
          uint run = AZIMUTH_OFFSETS ? subgroupShuffle(azimuths, mine & (gl_SubgroupSize - 1)) : 0;
          // The test is a condition, not a `continue`, because all lanes must reach the next shuffle.
          bool here = mine < min(mineEnd, stop);
          uint index = (box.rowFirst + mine) * stride + column;
          if (APART && !LISTED && !byColumn) here = here && !isBehindHit(tile.triangle, index);
          if (TIMED && !LISTED) here = here && firesWithin(tile.box, box.rowFirst + mine, column);
          bool meets = false;
          if (LISTED && WAITS) {
            tryCellTogether(tile, prepared, here, index);
          } else if (LISTED) {
            if (here) tryCell(tile, prepared, index);
          } else if (here) {
            Beam beam;
            Triangle ofBeam = seen;
            Prepared ready = prepared;
            if (byColumn) {
              beam = beamOf(azimuth, elevation.x, elevation.y);
              if (shifts) own = shifted(turned, laserOf(box.rowFirst + mine));
            } else {
              beam = beamOf(loadedColumn(run + column), elevation.x, elevation.y);
              if (APART) {
                ofBeam = seenFrom(tile.triangle, tile.slot, column, box.rowFirst + mine, beam.azimuth);
              }
              own = turnedFrom(ofBeam, box.rowFirst + mine, index, beam.azimuth);
              if (APART && (!WAITS || ofBeam.moves)) ready = preparedFor(ofBeam, own);
            }
            if (WAITS)
              meets = footprintMayMeet(ofBeam, ready, own, beam);
            else
              tryBeam(ofBeam, ready, own, beam, index, tile.slot);
          }
          if (WAITS && !LISTED) offerWaiting(meets, Meeting(tile.slot, box.rowFirst + mine, column), false);
        }
        row = stop;
      }
    }
  }
}

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
  return !PANES || BINNING != kBinningNearest || isPane(projected) == (PASS == kPassPanes);
}

// Takes the next slab and returns the last tile of its list, which it leaves empty for the next shell; kNone if the
// list is empty. A shared counter hands out the slabs.
uint takeSlab(uint slabs, out uint slab) {
  uint tile = kNone;
  slab = 0;
  if (subgroupElect()) {
    slab = atomicAdd(shells.of[pass.shell].nextSlab, 1);
    if (slab < slabs) tile = atomicExchange(slabEnds.at[PASS == kPassPanes ? slabs + slab : slab], kNone);
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
  loadMotion();
  if (PASS == kPassTable) {
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
  bool byShell = BINNING == kBinningNearest && PASS == kPassNearest;
  if (BINNING == kBinningSlabs)
    trySlabs();
  else
    tryProjected(byShell ? counters.binnedSmall : 0, byShell ? counters.binnedTiles : 0);
  if (CHAINS) countOwnLinks();
}
