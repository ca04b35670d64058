// SPDX-License-Identifier: Apache-2.0
// Runs the kernels on the host, for tests. A workgroup has one invocation, and workgroups run one after another, so
// subgroup operations return the lane's own value, and atomics and barriers need no synchronisation.
#pragma once

#include <utility>

#include "cuda/glsl.hpp"

#define GNO_SHARED_ARRAY(type_, name_, count_) type_ name_[count_]

namespace gnosphere::cuda {

constexpr uint gl_SubgroupSize = 1, gl_SubgroupID = 0, gl_SubgroupInvocationID = 0, gl_NumSubgroups = 1;
constexpr uint kVertexRounds = 6;    // see cluster_corners.glsl
constexpr bool kLanesInStep = true;  // see lanes.glsl
constexpr struct { uint x, y, z; } gl_WorkGroupSize = {1, 1, 1};
constexpr uvec3 gl_LocalInvocationID(0);
inline thread_local uvec3 gl_WorkGroupID, gl_NumWorkGroups;

/// Runs a kernel's main function once per workgroup.
template <typename Main>
void runWorkgroups(uint workgroupsX, uint workgroupsY, const Main& main) {
  gl_NumWorkGroups = {workgroupsX, workgroupsY, 1};
  for (uint y = 0; y < workgroupsY; ++y)
    for (uint x = 0; x < workgroupsX; ++x) {
      gl_WorkGroupID = {x, y, 0};
      main();
    }
}

inline void barrier() {}
inline void subgroupMemoryBarrierBuffer() {}
inline void subgroupBarrier() {}

template <typename T>
T subgroupShuffle(T value, uint) {
  return value;
}
template <typename T>
T subgroupBroadcast(T value, uint) {
  return value;
}
template <typename T>
T subgroupBroadcastFirst(T value) {
  return value;
}
inline bool subgroupElect() {
  return true;
}
inline bool subgroupAny(bool value) {
  return value;
}
inline uvec4 subgroupBallot(bool value) {
  return {value, 0, 0, 0};
}
inline uint subgroupBallotBitCount(uvec4 ballot) {
  return ballot.x;
}
inline uint subgroupBallotExclusiveBitCount(uvec4) {
  return 0;
}
template <typename T>
T subgroupAdd(T value) {
  return value;
}
template <typename T>
T subgroupMin(T value) {
  return value;
}
template <typename T>
T subgroupMax(T value) {
  return value;
}
inline uint subgroupOr(uint value) {
  return value;
}

inline uint atomicAdd(uint& memory, uint value) {
  return std::exchange(memory, memory + value);
}
inline uint atomicExchange(uint& memory, uint value) {
  return std::exchange(memory, value);
}
inline uint atomicMin(uint& memory, uint value) {
  return std::exchange(memory, min(memory, value));
}
inline uint atomicMax(uint& memory, uint value) {
  return std::exchange(memory, max(memory, value));
}
inline uint atomicOr(uint& memory, uint value) {
  return std::exchange(memory, memory | value);
}
inline void memoryBarrierBuffer() {}
inline uint64_t atomicMin(uint64_t& memory, uint64_t value) {
  return std::exchange(memory, min(memory, value));
}

}  // namespace gnosphere::cuda
