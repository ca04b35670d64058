// SPDX-License-Identifier: Apache-2.0
// Tries the beams of a tile, which is a part of a large box or, with slabs, of any box. A subgroup processes a tile.

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
// lane has columns of its own, and some return early.
void narrowRows(Tile tile, Prepared prepared, uint kFrom, uint kTo, float angle, inout uint from, inout uint to) {
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
  float blur = blurOf(prepared, far);
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

// Returns rows from..to - 1 of a box, which hold all whose beams in columns kFrom..kTo may hit the triangle. The lanes run
// together again behind the `if`; behind a function from which some return early Vulkan does not promise that.
void rowsIn(Tile tile, Prepared prepared, uint kFrom, uint kTo, float angle, out uint from, out uint to) {
  uint rowCount = boxRowCount(tile.box);
  from = 0;
  to = rowCount;
  // A small tile does not repay this work, and the paper's bounds must stay as they are.
  bool pays = rowCount * (tile.end - tile.first) > kFewBeams;
  if (pays && BOUNDS != kBoundsPaper) narrowRows(tile, prepared, kFrom, kTo, angle, from, to);
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
