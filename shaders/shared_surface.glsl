// SPDX-License-Identifier: Apache-2.0
// Finds the owners and surfaces of the hits of a subgroup. Neighbouring beams mostly hit the same triangle, so only the
// first of them looks it up, and the others take what it has found. With motion each beam sees its triangle at a
// different time, and nothing is shared.

// The placed triangle that the last lane has hit in the step before, its owner and its surface; at first none.
uint lastId = kNone;
uvec2 lastOwner = uvec2(kNone);
Surface lastSurface = noSurface();

uvec2 ownerOfHit(uint id) { return id == kNone ? uvec2(kNone) : ownerOf(id); }

// Returns the lane itself if it leads, otherwise the last leading lane before it; kNone if there is none.
uint leaderOf(bool leading) {
  uint lane = gl_SubgroupInvocationID, leader = leading ? lane : kNone;
  for (uint step = 1; step < gl_SubgroupSize; step *= 2) {
    uint before = subgroupShuffle(leader, (lane - step) & (gl_SubgroupSize - 1));
    if (leader == kNone && lane >= step) leader = before;
  }
  return leader;
}

// Returns the surface of another lane.
Surface surfaceFrom(Surface surface, uint lane) {
  surface.normal = subgroupShuffle(surface.normal, lane);
  surface.material = subgroupShuffle(surface.material, lane);
  if ((FIELDS & kFieldBarycentrics) != 0)
    surface.corners = Corners(subgroupShuffle(surface.corners.a, lane), subgroupShuffle(surface.corners.b, lane),
                              subgroupShuffle(surface.corners.c, lane));
  return surface;
}

// Finds the owner of the placed triangle (kNone: none) that the beam with this index has hit, and its surface if
// `looks`. All invocations of the subgroup must call this, and run through their beams together.
void findHit(uint index, uint id, bool looks, out uvec2 owner, out Surface surface) {
  owner = lastOwner;
  surface = lastSurface;
  if (MOTION) {
    owner = ownerOfHit(id);
    if (looks) surface = surfaceOf(index, owner);
    return;
  }
  uint lane = gl_SubgroupInvocationID, last = gl_SubgroupSize - 1;
  uint before = subgroupShuffle(id, (lane - 1) & last);
  bool leading = id != (lane == 0 ? lastId : before);
  if (!subgroupAny(leading)) return;
  if (leading) {
    owner = ownerOfHit(id);
    if (looks) surface = surfaceOf(index, owner);
  }
  uint leader = leaderOf(leading);
  if (leader == kNone) leader = lane;  // it still has what the step before has found
  owner = subgroupShuffle(owner, leader);
  if (looks) surface = surfaceFrom(surface, leader);
  lastId = subgroupShuffle(id, last);
  lastOwner = subgroupShuffle(owner, last);
  if (looks) lastSurface = surfaceFrom(surface, last);
}
