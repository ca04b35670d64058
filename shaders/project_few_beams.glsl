// SPDX-License-Identifier: Apache-2.0
// Where few beams may meet a cluster, tries these beams on all of its triangles. Finding the beams of each triangle costs
// more, because the beams are compared with the cluster's box first, which most of them miss.

// A lane has at most so many triangles of a cluster in subgroups of four lanes, which are the smallest.
const uint kMostTriangleRounds = kClusterTriangles / 4;

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

// True if few beams may be tried on all triangles of a cluster with so many vertices of this material.
bool mayTryAll(uint material, uint vertexCount) {
  bool possible = gl_SubgroupSize >= 4 && gl_SubgroupSize <= 32 && BINNING == kBinningSlabs && !MOTION;
  possible = possible && (EFFECTS & kStrays) == 0 && SHIFTS_TURNED;
  possible = possible && (CULLING & kCullRows) != 0 && (CULLING & kCullColumns) != 0;
  // Triangles are not culled here, and the first-corner cull takes hits away.
  possible = possible && CULL == kCullNearestPoint;
  if (!possible || !haveRoom(vertexCount)) return false;
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

// A hit as the bits of a word: the range and the number of the triangle.
const uvec2 kNoHit = uvec2(0xffffffffu);

uvec2 nearerOf(uvec2 a, uvec2 b) { return a.x < b.x || (a.x == b.x && a.y < b.y) ? a : b; }

uvec2 hitOf(Triangle triangle, uint row, Beam beam, uint index) {
  vec3 a = triangle.a, b = triangle.b, c = triangle.c, side;
  triangle.rangeMin = nearestPoint(min(min(a, b), c), max(max(a, b), c));
  if (ORIGINS) triangle.rangeMin = max(triangle.rangeMin - motion.shift, 0.0);
  Prepared prepared = prepare(triangle);
  float range;
  bool met = meetRounded(triangle, prepared, turnedFrom(triangle, row, index, beam.azimuth), beam, index, side, range);
  vec2 window = windowOf(prepared, index);
  return met && range >= window.x && range <= window.y ? uvec2(floatBitsToUint(range), triangle.id) : kNoHit;
}

// Returns four bits for each of three vertices: whether the vertex lies to the right of a beam, to its left, below it and
// above it. The coordinates across the beam are q, which points left, and w, which points up; both bits of a coordinate
// are set where it is 0.
uint sidesOf(vec3 q, vec3 w) {
  uvec3 sides = uvec3(lessThanEqual(q, vec3(0.0))) | uvec3(greaterThanEqual(q, vec3(0.0))) << 1 |
                uvec3(lessThanEqual(w, vec3(0.0))) << 2 | uvec3(greaterThanEqual(w, vec3(0.0))) << 3;
  return sides.x | sides.y << 4 | sides.z << 8;
}

// Returns on which sides of a beam the lane's vertices lie, four bits for each. Three vertices are turned together, as
// the corners of a triangle are, so that the inside test gets the same coordinates.
uint sidesOf(Vertices vertices, uint row, Beam beam) {
  uint sides = 0;
  [[unroll]] for (uint k = 0; k < kMostVertexRounds; k += 3)
    if (k < kVertexRounds && k * gl_SubgroupSize < vertices.count) {
      Triangle three =
          Triangle(vertices.corners[k], vertices.corners[k + 1], vertices.corners[k + 2], 0, false, 0.0, false);
      Turned turned = turnedFrom(three, row, 0, beam.azimuth);
      sides |= sidesOf(turned.q, aboveBeam(turned, beam.cosElevation, beam.sinElevation)) << 4 * k;
    }
  return sides;
}

// True if the corners of a triangle surround a beam, as surrounds() tells: otherwise the beam misses the triangle.
bool surroundedBy(uint sides, uvec3 corners) {
  uvec3 lanes = corners & (gl_SubgroupSize - 1), shifts = corners / gl_SubgroupSize * 4;
  uint all = subgroupShuffle(sides, lanes.x) >> shifts.x | subgroupShuffle(sides, lanes.y) >> shifts.y |
             subgroupShuffle(sides, lanes.z) >> shifts.z;
  return (all & 15) == 15;
}

// Returns the nearest hit of a beam, the same for all lanes. `packed` has the corners of the lane's triangles. Most
// triangles lie to one side of the beam, and comparing the cluster's vertices with the beam finds these triangles at less
// cost than a test of each triangle.
uvec2 nearestHit(LoadedCluster loaded, Vertices vertices, uint packed[kMostTriangleRounds], uint row, Beam beam,
                 uint index) {
  uint sides = sidesOf(vertices, row, beam), possible = 0;  // one bit for each of the lane's triangles
  [[unroll]] for (uint k = 0; k < kMostTriangleRounds; ++k)
    if (k * gl_SubgroupSize < kClusterTriangles && k * gl_SubgroupSize < loaded.triangleCount)
      possible |= surroundedBy(sides, numbersOf(loaded, packed[k])) ? 1u << k : 0u;
  uvec2 nearest = kNoHit;
  while (ballotOf(possible != 0).x != 0) {
    bool some = possible != 0;
    uint round = some ? findMSB(possible) : 0, number = round * gl_SubgroupSize + gl_SubgroupInvocationID;
    uvec2 triangle = triangleCorners.at[loaded.triangleFirst + min(number, loaded.triangleCount - 1)];
    mat3 corners = cornersOf(loaded, vertices, numbersOf(loaded, triangle.x));
    Triangle tried = Triangle(corners[0], corners[1], corners[2], placedFirstOf(loaded.instance) + triangle.y,
                              isOneSided(loaded), 0.0, false);
    if (some) nearest = nearerOf(nearest, hitOf(tried, row, beam, index));
    possible &= ~(1u << round);
  }
  EACH_STEP(k) nearest = nearerOf(nearest, subgroupShuffle(nearest, gl_SubgroupInvocationID ^ 1u << k));
  return nearest;
}

// Tries the beams on all triangles of the cluster. Returns false if none of them can meet it. All lanes of the subgroup
// must call this.
bool tryOnAll(LoadedCluster loaded, FewBeams few) {
  Vertices vertices;
  vertices.count = 0;
  uint packed[kMostTriangleRounds];
  for (uint first = 0; first < few.count; first += gl_SubgroupSize) {
    // Each lane loads a beam.
    uint k = min(first + gl_SubgroupInvocationID, few.count - 1),
         down = smallWhole(floor((float(k) + 0.5) / float(few.columnCount)));
    uint row = few.rowFirst + down, column = few.columnFirst + k - down * few.columnCount;
    column = min(column, column - frame.columns);  // after the last column comes the first again
    uint index = row * frame.columns + column, known = words.at[beamEntry(index)].y;
    Beam own = beamOf(loadedColumn((AZIMUTH_OFFSETS ? loadedRow(row).azimuths : 0) + column), loadedRow(row).angles.x,
                      loadedRow(row).angles.y);
    bool hidden = (CULLING & kCullOccluded) != 0 && known < floatBitsToUint(few.nearest);
    bool there = first + gl_SubgroupInvocationID < few.count && !hidden && mayPass(few.test, own.direction);
    uint left = ballotOf(there).x;
    if (left == 0) continue;
    if (vertices.count == 0) {
      vertices.count = loaded.vertexCount;
      [[unroll]] for (uint k = 0; k < kVertexRounds; ++k)
        if (k * gl_SubgroupSize < vertices.count) vertices.corners[k] = loadedVertex(loaded, k);
      // Lanes without a triangle try the last one again.
      [[unroll]] for (uint k = 0; k < kMostTriangleRounds; ++k)
        if (k * gl_SubgroupSize < kClusterTriangles && k * gl_SubgroupSize < loaded.triangleCount)
          packed[k] = triangleCorners.at[loaded.triangleFirst + min(k * gl_SubgroupSize + gl_SubgroupInvocationID,
                                                                    loaded.triangleCount - 1)].x;
    }
    uvec2 nearest = kNoHit;  // of the lane's beam
    for (uint beams = left; beams != 0;) {
      uint lane = findMSB(beams);
      beams ^= 1u << lane;
      Beam beam = beamOf(subgroupShuffle(own.azimuth, lane), subgroupShuffle(own.cosElevation, lane),
                         subgroupShuffle(own.sinElevation, lane));
      uvec2 hit = nearestHit(loaded, vertices, packed, ORIGINS ? subgroupShuffle(row, lane) : 0, beam,
                             subgroupShuffle(index, lane));
      if (gl_SubgroupInvocationID == lane) nearest = hit;
    }
    // The lanes offer their hits together, because lavapipe goes through all lanes for each atomic operation.
    if (nearest.x != kNoHit.x && nearest.x <= known) {
      offerNearest(index, uintBitsToFloat(nearest.x), nearest.y);
      if (pass.last == 0) markStale(row, column);
    }
  }
  return vertices.count > 0;
}
