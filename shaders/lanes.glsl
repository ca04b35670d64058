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

// Returns how the mesh of an instance is deformed, which is the same for all lanes; they must all call this. Of a mesh
// that is not deformable it loads no more than that.
Deformer deformerOf(uint instance) {
  Deformer told = Deformer(0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, vec3(0.0), vec3(0.0));
  uint mesh = instanceMeshes.at[instance];
  if (deformers.at[mesh].joints + deformers.at[mesh].targets == 0) return told;
  if (gl_SubgroupInvocationID == 0) told = deformers.at[mesh];
  return Deformer(subgroupBroadcast(told.joints, 0), subgroupBroadcast(told.targets, 0),
                  subgroupBroadcast(told.deformed, 0), subgroupBroadcast(told.vertices, 0),
                  subgroupBroadcast(told.vertexFirst, 0), subgroupBroadcast(told.restFirst, 0),
                  subgroupBroadcast(told.offsetFirst, 0), subgroupBroadcast(told.weightFirst, 0),
                  subgroupBroadcast(told.rowFirst, 0), subgroupBroadcast(told.clusterFirst, 0),
                  subgroupBroadcast(told.bonesFirst, 0), 0, subgroupBroadcast(told.morphLow, 0),
                  subgroupBroadcast(told.morphHigh, 0));
}
