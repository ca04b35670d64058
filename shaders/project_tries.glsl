// SPDX-License-Identifier: Apache-2.0
// Tries the beams of a triangle at once, without storing it, where these are few.

// True if the beams of a box are tried here, instead of in stage bin, which needs panes. Where each column sees the
// triangle from elsewhere, every beam costs more, which repays itself only where a whole subgroup would try the box in
// stage bin.
bool isTriedHere(Box box, Silhouette silhouette, uint material, bool moves) {
  bool seenFromOnePlace = BINNING == kBinningSlabs || !MOTION || atRest(moves);
  if (ORIGINS) seenFromOnePlace = seenFromOnePlace && SHIFTS_TURNED;
  bool walks = silhouette.known || (LISTED && VIEWS);  // cells of a list are all tried
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
    float range;
    uint known = words.at[firstWord() + place.index].y;  // loaded before the test, which then need not wait for it
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
