// SPDX-License-Identifier: Apache-2.0
// Tries the beams of a triangle at once, without storing it, where these are few.

// True if the beams of a box are tried here, instead of in stage bin, which needs panes. Where each column sees the
// triangle from elsewhere, every beam costs more, which repays itself only where a whole subgroup would try the box in
// stage bin.
bool isTriedHere(Box box, Silhouette silhouette, uint material, bool moves) {
  bool seenFromOnePlace = BINNING == kBinningSlabs || !MOTION || atRest(moves);
  if (ORIGINS) seenFromOnePlace = seenFromOnePlace && SHIFTS_TURNED;
  bool walks = silhouette.known || (LISTED && VIEWS && !MOTION);  // cells of a list are all tried
  bool few = BINNING == kBinningSlabs && walks && walkLength(silhouette, box) <= kTriedSteps;
  return BINNING != kBinningLists && BOUNDS != kBoundsPaper && seenFromOnePlace && (EFFECTS & kFootprint) == 0 &&
         !(PANES && isPaneMaterial(material)) && (isSmall(box) || few);
}

uint triedCount = 0;  // triangles that this invocation has tried

// Notes that the entry of the farthest-range table that holds a beam is out of date. Only slabs ask for these notes;
// otherwise the table is computed as a whole.
void markStale(uint row, uint column) {
  uint perRow = (frame.columns - 1) / kCoarseColumns + 1;
  uint entry = firstStale() + row / kCoarseRows * perRow + column / kCoarseColumns;
  if (staleEntries.at[entry] == 0) atomicMax(staleEntries.at[entry], 1);
}

// Notes the same for all beams of a box.
void markStale(Box box) {
  uint columnCount = boxColumnCount(box);
  for (uint k = 0; k < columnCount;) {
    uint column = wrapColumn(firstColumn(box) + int(k));
    for (uint y = box.rowFirst / kCoarseRows; y <= box.rowLast / kCoarseRows; ++y) markStale(y * kCoarseRows, column);
    k += min(kCoarseColumns - column % kCoarseColumns, frame.columns - column);
  }
}

// The surface of the triangle whose beams are tried, and its texture.
Optics4 triedSurface;
TextureCorners triedTexture;

bool inHole(uint slot, vec3 weights) {
  return triedSurface.passage.y > 0.0 && isHole(triedSurface, triedTexture, weights);
}

// Tries the beams of a box that may hit. The walk is one loop, not two nested ones: a subgroup then runs as long as its
// longest walk.
void tryBox(Triangle triangle, mat3 velocities, Prepared prepared, Silhouette silhouette, Box box) {
  uint columnCount = boxColumnCount(box);
  bool met = false;
  for (Walk walk = walkOf(box); !ended(box, walk);) {
    Place place;
    Beam beam;
    if (!stepTo(box, columnCount, silhouette, walk, beam, place)) continue;
    // No hit of the triangle is nearer than `rangeMin`. This comparison also lets the test overlap with the load: lavapipe's
    // compiler moves a load to its first use, which would be behind the test.
    uint known = words.at[beamEntry(place.index)].y;
    if (floatBitsToUint(triangle.rangeMin) > known) continue;
    float range;
    Triangle seen = triangle;
    if (MOTION && BINNING == kBinningSlabs && !atRest(triangle.moves)) {
      if (BEAM_FRAMES) {
        if (triangle.moves)
          seen = movedUntil(columnMotionOf(place.row, place.column).velocity.w, triangle, velocities);
      } else {
        seen = seenAt(triangle, velocities, columnMotionOf(place.row, place.column));
      }
      prepared = prepare(seen);
    }
    if (meet(seen, prepared, turnedFrom(seen, place.row, place.index, beam.azimuth), beam, place.index, kNone, range) &&
        floatBitsToUint(range) <= known) {
      offerNearest(place.index, range, triangle.id);
      met = true;
    }
  }
  ++triedCount;
  if (BINNING == kBinningSlabs && met && pass.last == 0) markStale(box);
}

// True if the lanes of a subgroup share the beams of their triangles. The boxes of a list hold numbers of beams that
// differ much, and without sharing all lanes wait for the one with the most. A single scan gains nothing, because it tries
// only small boxes here.
#define SHARES_BEAMS \
  (LISTED && VIEWS && !MOTION && SHIFTS_TURNED && (EFFECTS & kCutOuts) == 0 && gl_SubgroupSize <= 32)

// Tries the beams of the boxes of all lanes that have a triangle, as tryBox() does for one box. In each round every lane
// looks up one run of cells, and the lanes share the beams of all these runs. All lanes of the subgroup must call this.
void tryBoxes(bool there, Projected own, Box box) {
  uint lane = gl_SubgroupInvocationID, last = gl_SubgroupSize - 1, ownView = view;
  uint columnCount = there ? boxColumnCount(box) : 0;
  uint metLanes = 0;  // one bit for each lane whose triangle a beam meets
  Walk walk = walkOf(box);
  while (ballotOf(there && walk.row <= box.rowLast).x != 0) {
    uint count = 0;
    if (there && walk.row <= box.rowLast) {
      enterCells(box, columnCount, walk);
      count = walk.end - walk.index;
      if (walk.k == columnCount) {
        walk.k = 0;
        ++walk.row;
      }
    }
    uint upTo = sumUpTo(count), total = subgroupShuffle(upTo, last), start = walk.index + count - upTo;
    for (uint first = 0; first < total; first += gl_SubgroupSize) {
      uint number = min(first + lane, total - 1), owner = ownerOf(upTo, number);
      TaggedCorner a = TaggedCorner(subgroupShuffle(own.a.corner, owner), subgroupShuffle(own.a.tag, owner));
      Triangle triangle = triangleOf(a, subgroupShuffle(own.b, owner), subgroupShuffle(own.c.corner, owner));
      uint index = subgroupShuffle(start, owner) + number;
      lookFrom(subgroupShuffle(ownView, owner));
      uint known = words.at[beamEntry(index)].y;
      Beam beam = listedBeam(index);
      float range;
      Turned turned = turnedFrom(triangle, index, index, beam.azimuth);
      // The condition before the call of meet(), which some lanes leave early, also makes them run together again.
      bool met = first + lane < total && meet(triangle, prepare(triangle), turned, beam, index, kNone, range) &&
                 floatBitsToUint(range) <= known;
      if (met) offerNearest(index, range, triangle.id);
      metLanes |= met ? 1u << owner : 0;
    }
    lookFrom(ownView);
  }
  triedCount += there ? 1 : 0;
  if (BINNING != kBinningSlabs || pass.last != 0) return;
  EACH_STEP(k) metLanes |= subgroupShuffle(metLanes, lane ^ 1u << k);
  if ((metLanes >> lane & 1) != 0) markStale(box);
}
