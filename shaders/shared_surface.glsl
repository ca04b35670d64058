// SPDX-License-Identifier: Apache-2.0
// Finds the owners and surfaces of the hits of a subgroup. Neighbouring beams mostly hit the same triangle, so only the
// first of them looks it up, and the others take what it has found. With motion each beam sees its triangle from
// another place, so beams share the triangle where it is placed.

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

Corners cornersFrom(Corners corners, uint lane) {
  return Corners(subgroupShuffle(corners.a, lane), subgroupShuffle(corners.b, lane), subgroupShuffle(corners.c, lane));
}

// Returns the surface of another lane.
Surface surfaceFrom(Surface surface, uint lane) {
  surface.material = subgroupShuffle(surface.material, lane);
  if (!MOTION) surface.normal = subgroupShuffle(surface.normal, lane);
  if (MOTION || (FIELDS & kFieldBarycentrics) != 0) surface.corners = cornersFrom(surface.corners, lane);
  if (MOTION && motion.instances != 0) surface.velocities = cornersFrom(surface.velocities, lane);
  return surface;
}

// Finds the owner of the placed triangle (kNone: none) that a beam has hit, and its placed surface if `looks`. All
// invocations of the subgroup must call this, and run through their beams together.
void findHit(uint id, bool looks, out uvec2 owner, out Surface placed) {
  owner = lastOwner;
  placed = lastSurface;
  uint lane = gl_SubgroupInvocationID, last = gl_SubgroupSize - 1;
  uint before = subgroupShuffle(id, (lane - 1) & last);
  bool leading = id != (lane == 0 ? lastId : before);
  if (!subgroupAny(leading)) return;
  if (leading) {
    owner = ownerOfHit(id);
    if (looks) placed = placedSurfaceOf(owner);
  }
  uint leader = leaderOf(leading);
  if (leader == kNone) leader = lane;  // it still has what the step before has found
  owner = subgroupShuffle(owner, leader);
  if (looks) placed = surfaceFrom(placed, leader);
  lastId = subgroupShuffle(id, last);
  lastOwner = subgroupShuffle(owner, last);
  if (looks) lastSurface = surfaceFrom(placed, last);
}
