// SPDX-License-Identifier: Apache-2.0
// Where few beams may meet a cluster, tries these beams on all of its triangles. Finding the beams of each triangle costs
// more, because the beams are compared with the cluster's box first, which most of them miss.

// A line through the sensor passes through a box if its volume with each half edge and the box's centre is small enough.
struct LineTest {
  vec3 sides[3];   // cross products of the second and third half edge, of the third and first, of the first and second
  vec3 across[3];  // cross products of each half edge and the centre
  vec3 slack;
};

// The beams of a window in which a cluster lies; `count` is 0 if its triangles are projected one by one.
struct FewBeams {
  uint rowFirst, columnFirst, columnCount, count;
  float nearest;  // lower bound of the range to any point of the cluster
  LineTest test;
};

// True if few beams may be tried on all triangles of a cluster of this material.
bool mayTryAll(uint material) {
  bool possible = gl_SubgroupSize <= 32 && BINNING == kBinningSlabs && !MOTION && (EFFECTS & kStrays) == 0;
  possible = possible && (CULLING & kCullRows) != 0 && (CULLING & kCullColumns) != 0 && SHIFTS_TURNED;
  if (!possible) return false;
  if (PANES && isPaneMaterial(material)) return false;
  return (EFFECTS & kCutOuts) == 0 || optics.at[material].passage.y == 0.0;
}

LineTest lineTestOf(Instance instance, vec3 low, vec3 high) {
  vec3 pivot = pivotOf(instance), middle = 0.5 * (low - pivot) + 0.5 * (high - pivot), extent = 0.5 * (high - low);
  vec3 centre = vec3(dot(instance.row0.xyz, middle), dot(instance.row1.xyz, middle), dot(instance.row2.xyz, middle)) +
                instance.offset;
  vec3 u = vec3(instance.row0.x, instance.row1.x, instance.row2.x) * extent.x,
       v = vec3(instance.row0.y, instance.row1.y, instance.row2.y) * extent.y,
       w = vec3(instance.row0.z, instance.row1.z, instance.row2.z) * extent.z;
  LineTest test;
  test.sides[0] = cross(v, w);
  test.sides[1] = cross(w, u);
  test.sides[2] = cross(u, v);
  test.across[0] = cross(u, centre);
  test.across[1] = cross(v, centre);
  test.across[2] = cross(w, centre);
  // As for the bounds of triangles, the slack is ten times what rounding of the corners and of the inside test amounts to.
  vec3 lengths = vec3(length(u), length(v), length(w));
  test.slack = lengths * (1e-5 * (length(centre) + lengths.x + lengths.y + lengths.z) + (ORIGINS ? motion.shift : 0.0));
  return test;
}

bool mayPass(LineTest test, vec3 line) {
  vec3 sides = abs(vec3(dot(line, test.sides[0]), dot(line, test.sides[1]), dot(line, test.sides[2])));
  vec3 across = abs(vec3(dot(line, test.across[0]), dot(line, test.across[1]), dot(line, test.across[2])));
  return all(lessThanEqual(across, sides.yzx + sides.zxy + test.slack));
}

FewBeams fromLane(FewBeams few, uint lane) {
  FewBeams told;
  told.rowFirst = subgroupShuffle(few.rowFirst, lane);
  told.columnFirst = subgroupShuffle(few.columnFirst, lane);
  told.columnCount = subgroupShuffle(few.columnCount, lane);
  told.count = subgroupShuffle(few.count, lane);
  told.nearest = subgroupShuffle(few.nearest, lane);
  for (uint k = 0; k < 3; ++k) {
    told.test.sides[k] = subgroupShuffle(few.test.sides[k], lane);
    told.test.across[k] = subgroupShuffle(few.test.across[k], lane);
  }
  told.test.slack = subgroupShuffle(few.test.slack, lane);
  return told;
}

void offerHit(Triangle triangle, Turned turned, Beam beam, uint index) {
  vec3 a = triangle.a, b = triangle.b, c = triangle.c, side;
  triangle.rangeMin = nearestPoint(min(min(a, b), c), max(max(a, b), c));
  if (ORIGINS) triangle.rangeMin = max(triangle.rangeMin - motion.shift, 0.0);
  Prepared prepared = prepare(triangle);
  float range;
  bool surrounded = surrounds(turned.q, aboveBeam(turned, beam.cosElevation, beam.sinElevation));
  if (!surrounded || !meetRounded(triangle, prepared, turned, beam, index, side, range)) return;
  vec2 window = windowOf(prepared, index);
  if (range >= window.x && range <= window.y) offerNearest(index, range, triangle.id);
}

// Tries the beams on all triangles of the cluster. Returns false if none of them can meet it. All lanes of the subgroup
// must call this.
bool tryOnAll(LoadedCluster loaded, FewBeams few) {
  Vertices vertices;
  vertices.count = 0;
  bool oneSided = isOneSided(loaded);
  for (uint first = 0; first < few.count; first += gl_SubgroupSize) {
    // Each lane loads a beam.
    uint k = min(first + gl_SubgroupInvocationID, few.count - 1), down = smallWhole(floor((float(k) + 0.5) / float(few.columnCount)));
    uint row = few.rowFirst + down, column = few.columnFirst + k - down * few.columnCount;
    column = min(column, column - frame.columns);  // after the last column comes the first again
    uint index = row * frame.columns + column, known = words.at[firstWord() + index].y;
    Beam own = beamOf(columns.at[(AZIMUTH_OFFSETS ? rows.at[row].azimuths : 0) + column], rows.at[row].angles.x,
                      rows.at[row].angles.y);
    bool hidden = (CULLING & kCullOccluded) != 0 && known < floatBitsToUint(few.nearest);
    bool there = first + gl_SubgroupInvocationID < few.count && !hidden && mayPass(few.test, own.direction);
    uint left = ballotOf(there).x;
    if (left == 0) continue;
    if (vertices.count == 0) {
      vertices.count = loaded.vertexCount;
      if (haveRoom(vertices.count))
        [[unroll]] for (uint k = 0; k < kVertexRounds; ++k)
          if (k * gl_SubgroupSize < vertices.count) vertices.corners[k] = loadedVertex(loaded, k);
    }
    for (uint from = 0; from < loaded.triangleCount; from += gl_SubgroupSize) {
      // Lanes without a triangle try the last one again.
      uint number = min(from + gl_SubgroupInvocationID, loaded.triangleCount - 1);
      uvec2 packed = triangleCorners.at[loaded.triangleFirst + number];
      mat3 corners = cornersOf(loaded, vertices, numbersOf(loaded, packed.x));
      Triangle triangle = Triangle(corners[0], corners[1], corners[2], placedFirstOf(loaded.instance) + packed.y, oneSided,
                                   0.0, false);
      for (uint beams = left; beams != 0;) {
        uint lane = findMSB(beams);
        beams ^= 1u << lane;
        vec2 azimuth = subgroupShuffle(own.azimuth, lane);
        float cosElevation = subgroupShuffle(own.cosElevation, lane), sinElevation = subgroupShuffle(own.sinElevation, lane);
        uint at = subgroupShuffle(index, lane);
        Turned turned = turnedFrom(triangle, ORIGINS ? subgroupShuffle(row, lane) : 0, azimuth);
        if (any(lessThanEqual(turned.q, vec3(0.0))) && any(greaterThanEqual(turned.q, vec3(0.0)))) {
          vec3 side = watertightSides(turned, cosElevation, sinElevation);
          if (all(lessThanEqual(side, vec3(0.0))) || (!oneSided && all(greaterThanEqual(side, vec3(0.0)))))
            offerHit(triangle, turned, beamOf(azimuth, cosElevation, sinElevation), at);
        }
      }
    }
    if (there && pass.last == 0 && words.at[firstWord() + index].y != known) markStale(row, column);
  }
  return vertices.count > 0;
}
