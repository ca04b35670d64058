// SPDX-License-Identifier: Apache-2.0
// The candidates of a beam with a footprint: their list, and the tests of sub-rays against them. A sub-ray has the
// direction (1, u, v), where u and v are the tangents of its angles to the left and up. That vector has the length
// `length_`.

uint idOf(uint projected) { return projectedA.at[projected].tag & 0x7fffffffu; }

// The candidates of a beam. With kBinningLists they are a run of `candidates`; otherwise the triangle in its word, if
// there is one, and those of its chain: links at places of its own, and then those that did not fit there (see bin.comp).
const uint kOfWord = kNone - 1, kOwnPlace = 0x80000000u;
uint listFirst, listEnd, afterWord, ownEnd, chainFirst, wordCandidate;

void openList(uint index) {
  if (BINNING == kBinningLists) {
    // If the lists were too small, they are cut off here; the host enlarges them and runs the scan again.
    uint entry = beamEntry(index);
    listEnd = min(listEnds.at[entry], frame.candidateCapacity);
    listFirst = afterWord = entry == 0 ? 0 : min(listEnds.at[max(entry, 1) - 1], listEnd);
    return;
  }
  uint links = covers.at[beamEntry(index)].links, own = kOwnPlace | kOwnLinks * beamEntry(index);
  ownEnd = own + min(links, kOwnLinks);
  chainFirst = kNone;
  if (links > kOwnLinks) chainFirst = listEnds.at[beamEntry(index)];
  listEnd = kNone;
  listFirst = afterWord = links > 0 ? own : kNone;
  wordCandidate = words.at[beamEntry(index)].x;
  if (wordCandidate != kNone) listFirst = kOfWord;
}

bool isOwn(uint k) { return (k & kOwnPlace) != 0; }

uint nextOf(uint k) {
  if (BINNING == kBinningLists) return k + 1;
  if (k == kOfWord) return afterWord;
  if (isOwn(k)) return k + 1 < ownEnd ? k + 1 : chainFirst;
  return candidates.at[3 * k + 2];
}

uint linkedAt(uint k) { return isOwn(k) ? ownLinks.at[k & ~kOwnPlace].x : candidates.at[3 * k]; }

uint projectedAt(uint k) {
  if (BINNING == kBinningLists) return candidates.at[k];
  if (k == kOfWord) return wordCandidate;
  return linkedAt(k) & ~kPaneBit;
}

bool isPaneAt(uint k) {
  if (BINNING == kBinningLists) return isPane(candidates.at[k]);
  return k != kOfWord && (linkedAt(k) & kPaneBit) != 0;  // a word stops light
}

float nearestAt(uint k) {
  if (BINNING == kBinningLists || k == kOfWord) return rangeMinOf(projectedAt(k));
  return uintBitsToFloat(isOwn(k) ? ownLinks.at[k & ~kOwnPlace].y : candidates.at[3 * k + 1]);
}

// The panes that light may meet: candidates from `afterWord` on, before this one.
uint panesEnd;

// Moves a pane to `panesEnd`, before which the search has left only such panes and read everything. Of lanes that share a
// beam one stores the pane, after all have read what it replaces.
void keepPane(uint k) {
  uvec2 pane = BINNING == kBinningLists ? uvec2(projectedAt(k), 0) : uvec2(linkedAt(k), floatBitsToUint(nearestAt(k)));
  if (SPREAD_RAYS > 0) meetAgain();
  if (speaksForBeam()) {
    if (BINNING == kBinningLists) {
      candidates.at[panesEnd] = pane.x;
    } else if (isOwn(panesEnd)) {
      ownLinks.at[panesEnd & ~kOwnPlace] = pane;
    } else {
      candidates.at[3 * panesEnd] = pane.x;
      candidates.at[3 * panesEnd + 1] = pane.y;
    }
  }
  panesEnd = nextOf(panesEnd);
}

// Returns the range behind which no light of the beam goes on.
float endOf(uint index) {
  uint bits = BINNING == kBinningLists ? kNone : words.at[beamEntry(index)].y;
  return bits == kNone ? 3e38 : uintBitsToFloat(bits);
}

// A candidate in the beam's own frame: one component per corner.
struct Candidate {
  vec3 ahead, left, up;
  float rangeMin;
  uint id;
  bool oneSided;
};

// Returns a projected triangle in the frame of the beam's laser.
Triangle triangleAt(uint projected) {
  Triangle triangle = loadProjected(projected);
  if (MOTION && !atRest(triangle.moves)) triangle = seenAt(triangle, projected, beamMotion);
  if (ORIGINS) triangle = seenFromPoint(triangle, beamOrigin);
  return triangle;
}

Candidate candidateOf(uint projected, Beam beam) {
  Triangle triangle = triangleAt(projected);
  Turned turned = turn(triangle, beam.azimuth);
  precise vec3 above = turned.z * beam.cosElevation - turned.p * beam.sinElevation;
  return Candidate(cornerDepths(turned, beam.cosElevation, beam.sinElevation), turned.q, above, triangle.rangeMin,
                   triangle.id, triangle.oneSided);
}

vec3 normalOf(vec3 a, vec3 b, vec3 c) {
  precise vec3 u = b - a;
  precise vec3 v = c - a;
  return unitTowardsOrigin(crossOf(u, v), a);
}

// Code that runs for every sub-ray has no branches; it combines computed booleans with && and ||.
float rangeMin, rangeMax;

// A watertight test as in inside_watertight.glsl: sub-ray (1, u, v) shears every corner by the same operations.
bool isInside(Candidate candidate, float u, float v, out vec3 side) {
  precise vec3 q = candidate.left - u * candidate.ahead;
  precise vec3 w = candidate.up - v * candidate.ahead;
  precise vec3 sides = q.yzx * w.zxy - w.yzx * q.zxy;
  side = sides;
  bool facing = all(lessThanEqual(side, vec3(0.0)));
  bool averted = all(greaterThanEqual(side, vec3(0.0)));
  bool seen = facing || (averted && !candidate.oneSided);
  return seen && (!MOTION || surrounds(q, w));
}

// The supporting plane in the beam's frame: a normal that is not normalised, and how far the plane is from the place on
// the beam that is as deep as the corner nearest to the beam. The distance is the normal's product with the offset from
// that place to the corner; `offset` has its value for the axis, and its changes with the tangents of a sub-ray. Offsets
// are small beside ranges, so the error of a range does not grow as much at grazing incidence.
struct Plane {
  vec3 normal, offset;
  float depth;            // of the corner
  float least, farthest;  // depths of the triangle
};

Plane planeOf(Candidate c) {
  vec3 a = vec3(c.ahead.x, c.left.x, c.up.x), b = vec3(c.ahead.y, c.left.y, c.up.y);
  vec3 d = vec3(c.ahead.z, c.left.z, c.up.z);
  precise vec3 u = b - a;
  precise vec3 v = d - a;
  vec3 normal = crossOf(u, v);
  vec3 aside = abs(c.left) + abs(c.up), corner = a;
  if (aside.y < aside.x) corner = b;
  if (aside.z < min(aside.x, aside.y)) corner = d;
  precise vec3 offset =
      vec3(normal.y * corner.y + normal.z * corner.z, -(normal.y * corner.x), -(normal.z * corner.x));
  return Plane(normal, offset, corner.x, min(min(c.ahead.x, c.ahead.y), c.ahead.z),
               max(max(c.ahead.x, c.ahead.y), c.ahead.z));
}

// Computes the range at which a sub-ray meets the plane of a triangle that it hits. Returns false if that range does not
// count. Comparisons take the place of min() and max(), which cost more where the compiler cares about NaN.
bool reach(Candidate candidate, Plane plane, float u, float v, float length_, out float range) {
  precise float along = plane.normal.x + u * plane.normal.y + v * plane.normal.z;
  precise float offset = plane.offset.x + u * plane.offset.y + v * plane.offset.z;
  precise float depth = plane.depth + quotient(offset, along);
  depth = depth > plane.least ? depth : plane.least;
  depth = depth < plane.farthest ? depth : plane.farthest;
  precise float met = depth * length_;
  range = met > candidate.rangeMin ? met : candidate.rangeMin;
  bool ahead = depth > 0.0, near = range >= rangeMin, far = range <= rangeMax, tilted = along != 0.0;
  return ahead && near && far && tilted;
}

// True if the whole footprint lies within the triangle: the beam's axis is farther from the plane of each edge than
// the footprint reaches.
bool coversFootprint(Candidate c) {
  precise vec3 side = c.left.yzx * c.up.zxy - c.up.yzx * c.left.zxy;
  precise vec3 second = c.up.yzx * c.ahead.zxy - c.ahead.yzx * c.up.zxy;
  precise vec3 third = c.ahead.yzx * c.left.zxy - c.left.yzx * c.ahead.zxy;
  precise vec3 square = side * side;
  precise vec3 reach = (square + second * second + third * third) * (frame.footprint * frame.footprint * 1.01 + 1e-12);
  bool facing = all(lessThan(side, vec3(0.0)));
  bool averted = all(greaterThan(side, vec3(0.0)));
  return (facing || (averted && !c.oneSided)) && all(greaterThan(square, reach));
}

vec2 halfAxes;  // tangents: of an ellipse around the beam's axis, or around its deviation, that holds all sub-rays

// True if a sub-ray may hit the triangle: the middle of the footprint is no farther outside of the plane of each edge
// than the footprint reaches. The test misses nothing; the margin is far more than the rounding errors.
bool touchesFootprint(Candidate c, vec2 middle) {
  vec3 side = c.left.yzx * c.up.zxy - c.up.yzx * c.left.zxy;
  vec3 second = c.up.yzx * c.ahead.zxy - c.ahead.yzx * c.up.zxy;
  vec3 third = c.ahead.yzx * c.left.zxy - c.left.yzx * c.ahead.zxy;
  side += middle.x * second + middle.y * third;
  vec3 across = halfAxes.x * second, upwards = halfAxes.y * third, square = across * across + upwards * upwards;
  vec3 margin = 4e-6 * (abs(side) + abs(second) + abs(third));
  vec3 reach = 1.01 * vec3(sqrt(square.x), sqrt(square.y), sqrt(square.z)) + margin;
  bool facing = all(lessThanEqual(side, reach));
  bool averted = all(greaterThanEqual(side, -reach));
  return facing || (averted && !c.oneSided);
}

// On which side of a triangle's edges sub-rays lie, computed from the axis and the changes with the tangents: negative
// is inside. Corners shear to the same result, but at a higher cost. Where rounding errors may matter, isInside() decides.
struct Sides {
  vec3 axis, across, upwards;
  float doubt;  // far more than the rounding errors
};

Sides sidesOf(Candidate c, vec2 middle) {
  vec3 first = c.left.yzx * c.up.zxy, last = c.up.yzx * c.left.zxy;
  vec3 firstAcross = c.up.yzx * c.ahead.zxy, lastAcross = c.ahead.yzx * c.up.zxy;
  vec3 firstUpwards = c.ahead.yzx * c.left.zxy, lastUpwards = c.left.yzx * c.ahead.zxy;
  vec2 most = abs(middle) + halfAxes;
  vec3 doubt = 1e-6 * (abs(first) + abs(last) + most.x * (abs(firstAcross) + abs(lastAcross)) +
                       most.y * (abs(firstUpwards) + abs(lastUpwards)));
  Sides sides = Sides(first - last, firstAcross - lastAcross, firstUpwards - lastUpwards,
                      max(max(doubt.x, doubt.y), doubt.z));
  float sum = sides.axis.x + sides.axis.y + sides.axis.z;
  vec2 change = most * abs(vec2(sides.across.x + sides.across.y + sides.across.z,
                                sides.upwards.x + sides.upwards.y + sides.upwards.z));
  bool averted = sum > 0.0, same = abs(sum) > change.x + change.y + 3.0 * sides.doubt;
  // If some sub-rays may see the other face, or a face that they cannot hit, nothing is clear.
  float sign_ = !same || (averted && c.oneSided) ? 0.0 : averted ? -1.0 : 1.0;
  sides.axis *= sign_;
  sides.across *= sign_;
  sides.upwards *= sign_;
  return sides;
}

// Returns the largest side of a sub-ray: it is clearly inside below -doubt, and clearly outside above doubt.
float sideOf(Sides sides, float u, float v) {
  vec3 side = sides.axis + u * sides.across + v * sides.upwards;
  float larger = side.x > side.y ? side.x : side.y;
  return larger > side.z ? larger : side.z;
}

// Returns the cosine of a sub-ray's incidence on a surface whose normal is given as (ahead, left, up).
float cosineOf(vec3 normal, float u, float v, float inverseLength) {
  precise float along = (normal.x + u * normal.y + v * normal.z) * inverseLength;
  float cosine = abs(along);
  return cosine < 1.0 ? cosine : 1.0;
}

