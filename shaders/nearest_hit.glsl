// SPDX-License-Identifier: Apache-2.0
// Finds the beams of a box, and keeps the nearest hit of every beam in `words`.

#ifdef INT64_ATOMICS
layout(buffer_reference, scalar, buffer_reference_align = 16) coherent buffer Words64 { uint64_t at[]; };
Words64 words64 = Words64(words);
#endif

float farthestOf(uint index) {
  return BINNING == kBinningLists
             ? frame.rangeMax
             : min(uintBitsToFloat(min(words.at[beamEntry(index)].y, 0x7f800000u)), frame.rangeMax);
}

// Any invocation may call this. Ranges are positive, so their bits order like numbers.
void offerNearest(uint beam, float range, uint id) {
#ifdef INT64_ATOMICS
  atomicMin(words64.at[beamEntry(beam)], packUint2x32(uvec2(id, floatBitsToUint(range))));
#endif
}

// Walks over the beams of a box, row by row and column by column.
struct Walk {
  uint row, k;       // the next beam of a grid; for a list the next cell
  uint kEnd;         // of a grid: the end of the row's columns in which beams may hit; k if the row is not entered yet
  vec2 angles;       // of a grid: cosine and sine of the row's elevation
  uint azimuths;     // where the row's run of `columns` begins
  uint index, end;   // of a list: the beams of cells before that are left
};

Walk walkOf(Box box) { return Walk(box.rowFirst, 0, 0, vec2(0.0), 0, 0, 0); }

// True if the beam in a column of a row fires within the time of a box.
bool firesWithin(Box box, uint row, uint column) {
  if (!TIMED || isWholeScan(box.times)) return true;
  if (LISTED) {
    // Slices are compared as places in the table of poses, because some compilers convert to integers lane by lane.
    float place = beamOrigins.at[tableEntry(column)].w;
    return place >= float(box.times.x * kSliceIntervals) &&
           (place < float((box.times.y + 1) * kSliceIntervals) || box.times.y == kTimeSlices - 1);
  }
  uint time = uint(whole(floor(momentOf(loadedRow(row).first, loadedRow(row).lag, column, frame.columns))));
  return time >= box.times.x && time <= box.times.y;
}

// Finds the run of cells from the walk's cell on that lie in one row and do not wrap, and moves on behind it.
void enterCells(Box box, uint columnCount, inout Walk walk) {
  uint column = wrapColumn(firstColumn(box) + int(walk.k)), run = min(columnCount - walk.k, frame.columns - column);
  uint cell = cellEntry(walk.row * frame.columns + column);
  walk.index = cellStarts.at[cell];
  walk.end = cellStarts.at[cell + run];
  walk.k += run;
}

// Finds the columns of the walk's row whose beams may hit.
void enterRow(Box box, uint columnCount, Silhouette silhouette, inout Walk walk) {
  walk.angles = loadedRow(walk.row).angles.xy;
  walk.azimuths = AZIMUTH_OFFSETS ? loadedRow(walk.row).azimuths : 0;
  walk.k = 0;
  walk.kEnd = columnCount;
  if (!silhouette.known) return;
  vec2 between = columnsBetween(seenByRow(silhouette, walk.row), walk.angles.y / walk.angles.x);
  float first = float(firstColumn(box)) - box.columnMin;
  vec2 behind = behindIn(walk.row, box);
  int from = whole(ceil(between.x - first - behind.y)), to = whole(floor(between.y - first - behind.x)) + 1;
  walk.k = uint(min(max(from, 0), int(columnCount)));
  walk.kEnd = uint(min(max(to, int(walk.k)), int(columnCount)));
}

bool ended(Box box, Walk walk) { return walk.row > box.rowLast && walk.index == walk.end; }

// Moves the walk on by one beam. Returns false if this step has found no beam, because it entered other cells or a row
// without beams that may hit. A walk has no inner loops, so a subgroup takes as long as its longest walk.
bool stepTo(Box box, uint columnCount, Silhouette silhouette, inout Walk walk, out Beam beam, out Place place) {
  if (LISTED) {
    if (walk.index == walk.end) enterCells(box, columnCount, walk);
    bool there = walk.index < walk.end;
    place = Place(walk.index, walk.index, walk.index);
    if (there) {
      beam = listedBeam(walk.index);
      there = firesWithin(box, walk.index, walk.index);
      ++walk.index;
    }
    if (walk.k == columnCount && walk.index == walk.end) {
      walk.k = 0;
      ++walk.row;
    }
    return there;
  }
  if (walk.k == walk.kEnd) enterRow(box, columnCount, silhouette, walk);
  bool there = walk.k < walk.kEnd;  // all lanes load a beam, because loads in divergent branches cost more
  uint column = wrapColumn(firstColumn(box) + int(min(walk.k, columnCount - 1)));
  place = Place(walk.row, column, walk.row * frame.columns + column);
  beam = beamOf(loadedColumn(walk.azimuths + column), walk.angles.x, walk.angles.y);
  bool fires = there && firesWithin(box, walk.row, column);
  walk.k += there ? 1 : 0;
  if (walk.k == walk.kEnd) {
    walk.k = walk.kEnd = 0;
    ++walk.row;
  }
  return fires;
}
