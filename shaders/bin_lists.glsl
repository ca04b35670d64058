// SPDX-License-Identifier: Apache-2.0
// Tries the beams of a list in the cells of a tile.

// Tries the listed beams of a cell, where nothing moves.
void tryCell(Tile tile, Prepared prepared, uint cell) {
  uint entry = cellEntry(cell);
  for (uint index = cellStarts.at[entry], end = cellStarts.at[entry + 1]; index < end; ++index) {
    Beam beam = listedBeam(index);
    Triangle seen = tile.triangle;
    if (ORIGINS) seen = seenFrom(tile.triangle, index, beam.azimuth);
    Turned turned = turnedFrom(seen, index, index, beam.azimuth);
    if (ORIGINS) prepared = preparedFor(seen, turned);
    tryBeam(seen, prepared, turned, beam, index, tile.slot);
  }
}

// Tries the listed beams of a cell of each lane, where nothing moves.
void tryCellTogether(Tile tile, Prepared prepared, bool here, uint cell) {
  uint index = 0, end = 0;
  if (here) {
    uint entry = cellEntry(cell);
    index = cellStarts.at[entry];
    end = cellStarts.at[entry + 1];
  }
  while (anyLane(index < end)) {
    bool meets = false;
    if (index < end) {
      Beam beam = listedBeam(index);
      Triangle seen = tile.triangle;
      if (ORIGINS) seen = seenFrom(tile.triangle, index, beam.azimuth);
      meets = footprintMayMeet(seen, prepared, turnedFrom(seen, index, index, beam.azimuth), beam);
    }
    offerWaiting(meets, Meeting(tile.slot, index, index), false);
    ++index;
  }
}

// The blocks of cells in which a tile has cells. Columns before and behind the seam are apart.
struct Blocks {
  uvec2 firstColumn, lastColumn;  // of cells, before and behind the seam
  uvec2 across;                   // blocks side by side, before and behind the seam
  uint firstRow, count;           // the first row of blocks, number of all blocks
};

Blocks blocksOf(Tile tile) {
  uint count = tile.end - tile.first, beforeSeam = min(count, frame.columns - tile.column), behind = count - beforeSeam;
  Blocks blocks;
  blocks.firstColumn = uvec2(tile.column, 0);
  blocks.lastColumn = uvec2(tile.column + beforeSeam - 1, max(behind, 1) - 1);
  blocks.across = blocks.lastColumn / kTimedColumns - blocks.firstColumn / kTimedColumns + 1;
  if (behind == 0) blocks.across.y = 0;
  blocks.firstRow = tile.box.rowFirst / kTimedRows;
  blocks.count = (blocks.across.x + blocks.across.y) * (tile.box.rowLast / kTimedRows - blocks.firstRow + 1);
  return blocks;
}

// Returns the first and the last of a run of rows or columns that lie in a block of `size` of them, in bytes.
uint withinBlock(uvec2 run, uint block, uint size) {
  uint first = max(run.x, block * size) - block * size, last = min(run.y - block * size, size - 1);
  return first | last << 8;
}

// Returns the first entry of timedBeams among those of a block that fire within the time of the box, and the number of
// these entries. Sets `cells` to the tile's cells in the block: first row, last row, first column, last column, in bytes.
uvec2 runOfBlock(Blocks blocks, Box box, uint number, out uint cells) {
  uint across = blocks.across.x + blocks.across.y, down = uint(whole(floor((float(number) + 0.5) / float(across))));
  uint k = number - down * across;
  bool behindSeam = k >= blocks.across.x;
  uvec2 columns = behindSeam ? uvec2(blocks.firstColumn.y, blocks.lastColumn.y)
                             : uvec2(blocks.firstColumn.x, blocks.lastColumn.x);
  uint x = columns.x / kTimedColumns + k - (behindSeam ? blocks.across.x : 0), y = blocks.firstRow + down;
  cells = withinBlock(uvec2(box.rowFirst, box.rowLast), y, kTimedRows) |
          withinBlock(columns, x, kTimedColumns) << 16;
  uint perRow = (frame.columns - 1) / kTimedColumns + 1, rows = (frame.rows - 1) / kTimedRows + 1;
  uint first = firstOfTable(rows * perRow * kTimeSlices + 1) + (y * perRow + x) * kTimeSlices;
  uint start = timedStarts.at[first + box.times.x];
  return uvec2(tableEntry(start), timedStarts.at[first + box.times.y + 1] - start);
}

// True if a cell of a block, as timedBeams states it, is one of these.
bool isAmong(uint cells, uint cell) {
  uint row = cell & 0xffff, column = cell >> 16;
  return row >= (cells & 0xff) && row <= (cells >> 8 & 0xff) && column >= (cells >> 16 & 0xff) && column <= cells >> 24;
}

// Tries the beams in the cells of a tile that fire within the time of the tile's box. Each lane looks up the beams of one
// block, and the lanes share the beams of these runs. Some beams need no try: they lie in other cells, or have a nearer
// hit. The other beams wait in the first lanes until every lane has one.
void tryFiring(Tile tile) {
  Box box = tile.box;
  uint lane = gl_SubgroupInvocationID, last = gl_SubgroupSize - 1;
  Blocks blocks = blocksOf(tile);
  uint runs = blocks.count, nextRun = 0;
  uint upTo = 0, start = 0, total = 0, next = 0;  // the runs that are shared, and how many beams of them are done
  uint cells = 0;
  uint waiting = 0, waitingBeam = kNone;
  for (bool more = true; more || waiting > 0;) {
    if (next >= total && nextRun < runs) {
      uvec2 run = uvec2(0);
      if (nextRun + lane < runs) run = runOfBlock(blocks, box, nextRun + lane, cells);
      nextRun += gl_SubgroupSize;
      upTo = sumUpTo(run.y);
      start = run.x + run.y - upTo;
      total = subgroupShuffle(upTo, last);
      next = 0;
    }
    uint number = next + lane, owner = ownerOf(upTo, number);
    uint index = subgroupShuffle(start, owner) + number, among = subgroupShuffle(cells, owner);
    bool tried = number < total;
    if (tried) {
      uvec2 beam = timedBeams.at[index];
      index = beam.x;
      tried = isAmong(among, beam.y) && !isBehindHit(tile.triangle, index);
    }
    next += gl_SubgroupSize;
    more = next < total || nextRun < runs;
    uvec2 joined = joinWaiting(tried, waiting);
    uint there = joined.x, beam = subgroupShuffle(index, joined.y);
    if (lane >= waiting) waitingBeam = beam;
    if (more && there < gl_SubgroupSize) {
      waiting = there;
      continue;
    }
    meetAgain();  // another lane may have read the word that this lane writes
    if (lane < there) {
      Beam own = listedBeam(waitingBeam);
      Triangle seen = seenFrom(tile.triangle, tile.slot, waitingBeam, waitingBeam, own.azimuth);
      Turned turned = turnedFrom(seen, waitingBeam, waitingBeam, own.azimuth);
      tryBeam(seen, preparedFor(seen, turned), turned, own, waitingBeam, tile.slot);
    }
    waitingBeam = beam;  // the first lanes hold the beams for which this round had no lane
    waiting = max(there, gl_SubgroupSize) - gl_SubgroupSize;
  }
}
