// SPDX-License-Identifier: Apache-2.0
// What the lanes of a subgroup do together. Every live lane must call.

// One lane has loaded an instance for all.
Instance fromFirstLane(Instance instance) {
  return Instance(subgroupBroadcastFirst(instance.row0), subgroupBroadcastFirst(instance.row1),
                  subgroupBroadcastFirst(instance.row2), subgroupBroadcastFirst(instance.offset));
}

// The slot of a lane whose bit is set, where the first lane has reserved as many as there are bits, from `base` on.
uint slotAfter(uint base, uvec4 ballot) { return subgroupBroadcastFirst(base) + subgroupBallotExclusiveBitCount(ballot); }
