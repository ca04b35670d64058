// SPDX-License-Identifier: Apache-2.0
// Operations across the lanes of a subgroup. All active lanes must call them.

// All lanes of the subgroup wait here for one another. On CPU devices subgroupBarrier() must not be called: Mesa's lavapipe
// waits for the whole workgroup at it, and if subgroups of the workgroup run through a loop a different number of times,
// the work of some rounds is lost.
void meetAgain() {
  if (!kLanesInStep) subgroupBarrier();
}

// Runs a statement for k = 0, 1, ... as long as 1 << k is less than the size of a subgroup of at most 64 lanes. Compilers
// unroll it, because its number of steps is constant; lavapipe updates a mask of active lanes in each step of other loops.
#define EACH_STEP(k) [[unroll]] for (uint k = 0; k < 6; ++k) if (1u << k < gl_SubgroupSize)

// Mesa's lavapipe goes through the lanes one by one for a ballot, an election or the value of the first lane, but
// shuffles in one instruction. So on CPUs, whose subgroups are full and have at most 32 lanes, these are shuffles.
uvec4 ballotOf(bool condition) {
  if (!kLanesInStep || gl_SubgroupSize > 32) return subgroupBallot(condition);
  uint bits = condition ? 1u << gl_SubgroupInvocationID : 0;
  EACH_STEP(k) bits |= subgroupShuffle(bits, gl_SubgroupInvocationID ^ 1u << k);
  return uvec4(bits, 0, 0, 0);
}

bool anyLane(bool condition) {
  uvec4 lanes = ballotOf(condition);
  return (lanes.x | lanes.y) != 0;
}

bool isFirstLane() {
  if (!kLanesInStep) return subgroupElect();
  return gl_SubgroupInvocationID == 0;
}

uint fromFirstLane(uint value) {
  if (!kLanesInStep) return subgroupBroadcastFirst(value);
  return subgroupShuffle(value, 0);
}

// Load a vector from an array at an index that is the same for all lanes. Each component is loaded by another lane,
// because on a device that gathers the loads of all lanes, a load of one lane takes as long.
#define LOADED_4(vector_) (gl_SubgroupSize < 4 ? vector_ : fromFourLanes(vector_[min(gl_SubgroupInvocationID, 3u)]))
#define LOADED_3(vector_) (gl_SubgroupSize < 4 ? vector_ : fromFourLanes(vector_[min(gl_SubgroupInvocationID, 2u)]).xyz)
#define LOADED_2(vector_) (gl_SubgroupSize < 4 ? vector_ : fromFourLanes(vector_[min(gl_SubgroupInvocationID, 1u)]).xy)

vec4 fromFourLanes(float own) {
  return vec4(subgroupBroadcast(own, 0), subgroupBroadcast(own, 1), subgroupBroadcast(own, 2),
              subgroupBroadcast(own, 3));
}

uvec4 fromFourLanes(uint own) {
  return uvec4(subgroupBroadcast(own, 0), subgroupBroadcast(own, 1), subgroupBroadcast(own, 2),
               subgroupBroadcast(own, 3));
}

// Returns the instance with a number, which must be the same for all lanes of the subgroup.
Instance instanceAt(uint number) {
  return Instance(LOADED_4(instances.at[number].row0), LOADED_4(instances.at[number].row1),
                  LOADED_4(instances.at[number].row2), LOADED_3(instances.at[number].offset),
                  instances.at[number].firstTriangle);
}

// Returns the output slot of a lane whose ballot bit is set. The first lane has reserved a slot for each set bit, the
// first one being `base`.
uint slotAfter(uint base, uvec4 ballot) { return fromFirstLane(base) + subgroupBallotExclusiveBitCount(ballot); }

// Returns how the mesh of an instance is deformed, which is the same for all lanes; they must all call this. Of a mesh
// that is not deformable it loads no more than that.
Deformer deformerOf(uint instance) {
  Deformer told = Deformer(0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, vec3(0.0), vec3(0.0));
  uint mesh = instanceMeshes.at[instance];
  if (deformers.at[mesh].joints + deformers.at[mesh].targets == 0) return told;
  if (subgroupElect()) told = deformers.at[mesh];
  return Deformer(subgroupBroadcastFirst(told.joints), subgroupBroadcastFirst(told.targets),
                  subgroupBroadcastFirst(told.deformed), subgroupBroadcastFirst(told.vertices),
                  subgroupBroadcastFirst(told.vertexFirst), subgroupBroadcastFirst(told.restFirst),
                  subgroupBroadcastFirst(told.offsetFirst), subgroupBroadcastFirst(told.weightFirst),
                  subgroupBroadcastFirst(told.rowFirst), subgroupBroadcastFirst(told.clusterFirst),
                  subgroupBroadcastFirst(told.bonesFirst), 0, subgroupBroadcastFirst(told.morphLow),
                  subgroupBroadcastFirst(told.morphHigh));
}
