// SPDX-License-Identifier: Apache-2.0
// Operations across the lanes of a subgroup. All active lanes must call them.

// Broadcasts an instance that the first lane has loaded.
Instance fromFirstLane(Instance instance) {
  return Instance(subgroupBroadcast(instance.row0, 0), subgroupBroadcast(instance.row1, 0),
                  subgroupBroadcast(instance.row2, 0), subgroupBroadcast(instance.offset, 0),
                  subgroupBroadcast(instance.firstTriangle, 0));
}

// Returns the output slot of a lane whose ballot bit is set. The first lane has reserved one slot per set bit, from
// its `base` on.
uint slotAfter(uint base, uvec4 ballot) { return subgroupBroadcast(base, 0) + subgroupBallotExclusiveBitCount(ballot); }
