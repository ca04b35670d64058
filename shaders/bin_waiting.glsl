// SPDX-License-Identifier: Apache-2.0
// Tries triangles on the footprints of beams. A first test, with bounds that are the same for all beams, rules out half of
// the beams that a box may hold. Offering a triangle to a beam takes several times as long; so those that are left wait in
// the first lanes of the subgroup until every lane has one.

// Prepares a triangle at rest for the first test of all beams. Lasers are up to motion.shift metres away from the origin,
// so the normal of an edge is longer for a laser by at most motion.shift times the edge's length.
Prepared preparedForAll(Triangle triangle) {
  Prepared prepared = prepare(triangle);
  if (!APART) return prepared;
  vec3 a = triangle.a, b = triangle.b, c = triangle.c;
  vec3 edges = vec3(length(c - b), length(a - c), length(b - a));
  prepared.reach += (frame.footprint * 1.001 + 1e-6) * 1.001 * motion.shift * edges;
  return prepared;
}

// A projected triangle, and a beam whose footprint may meet it. For a beam of a list, `row` and `column` are its index.
struct Meeting {
  uint projected, row, column;
};

uint waiting = 0;  // so many of the first lanes hold a meeting
Meeting held;

// The lanes may hold meetings of other views than that of the tile.
void offerHeld() {
  uint ofTile = view;
  setViewOf(held.projected);
  uint index = LISTED ? held.column : held.row * frame.columns + held.column;
  Beam beam;
  if (LISTED) {
    beam = listedBeam(index);
  } else {
    Row row = loadedRow(held.row);
    beam = beamOf(loadedColumn((AZIMUTH_OFFSETS ? row.azimuths : 0) + held.column), row.angles.x, row.angles.y);
  }
  Triangle seen = loadProjected(held.projected);
  if (APART) seen = seenFrom(seen, held.projected, held.column, held.row, beam.azimuth);
  Turned turned = turnedFrom(seen, held.row, index, beam.azimuth);
  lookAtSurface(held.projected);
  offerFootprint(seen, preparedFor(seen, turned), turned, beam,
                 watertightSides(turned, beam.cosElevation, beam.sinElevation), index, held.projected);
  lookFrom(ofTile);
}

// Adds the meetings of the lanes that have one to those that wait. Offers them if every lane has one, or if `flush` says
// that no more will come. All lanes must call this.
void offerWaiting(bool meets, Meeting own, bool flush) {
  meetAgain();
  uvec2 joined = joinWaiting(meets, waiting);
  uint lane = gl_SubgroupInvocationID, there = joined.x;
  own = Meeting(subgroupShuffle(own.projected, joined.y), subgroupShuffle(own.row, joined.y),
                subgroupShuffle(own.column, joined.y));
  if (lane >= waiting) held = own;
  if (there < gl_SubgroupSize && !flush) {
    waiting = there;
    return;
  }
  if (lane < there) offerHeld();
  held = own;  // the first lanes hold the meetings for which this round had no lane
  waiting = max(there, gl_SubgroupSize) - gl_SubgroupSize;
}

// Each lane tries all beams of a box, and hands `flush` on to offerWaiting(). All lanes must call this.
void trySmallTogether(uint i, bool there, bool flush) {
  Triangle triangle;
  Box box = Box(0.0, 0.0, 1, 0, uvec2(0));
  if (there) {
    TaggedCorner c = loadedC(i);
    triangle = triangleOf(loadedA(i), loadedB(i), c.corner);
    box = boxOf(i, projectedColumns.at[i], c.tag);
    setViewOf(i);
  }
  Prepared prepared = preparedForAll(triangle);
  uint columnCount = boxColumnCount(box);
  seemFrom(triangle);
  Silhouette silhouette = noSilhouette();
  if (!MOTION) silhouette = silhouetteOf(triangle, prepared, box);
  Walk walk = walkOf(box);
  for (bool more = true; more;) {
    Place place;
    bool meets = false;
    if (there && !ended(box, walk)) {
      Beam beam;
      bool tried = stepTo(box, columnCount, silhouette, walk, beam, place);
      tried = tried && !isBehindHit(triangle, place.index);
      if (tried) {
        Triangle seen = triangle;
        if (APART) seen = seenFrom(triangle, i, place.column, place.row, beam.azimuth);
        Turned turned = turnedFrom(seen, place.row, place.index, beam.azimuth);
        if (MOTION && seen.moves) prepared = preparedFor(seen, turned);
        meets = footprintMayMeet(seen, prepared, turned, beam);
      }
    }
    more = anyLane(there && !ended(box, walk));
    offerWaiting(meets, Meeting(i, place.row, place.column), flush && !more);
  }
}
