// SPDX-License-Identifier: Apache-2.0
// What the lanes of a subgroup do together. Every live lane must call.

// One lane has loaded an instance for all.
Instance fromFirstLane(Instance instance) {
  return Instance(subgroupBroadcast(instance.row0, 0), subgroupBroadcast(instance.row1, 0),
                  subgroupBroadcast(instance.row2, 0), subgroupBroadcast(instance.offset, 0),
                  subgroupBroadcast(instance.firstTriangle, 0));
}

// The slot of a lane whose bit is set, where the first lane has reserved as many as there are bits, from `base` on.
uint slotAfter(uint base, uvec4 ballot) { return subgroupBroadcast(base, 0) + subgroupBallotExclusiveBitCount(ballot); }
