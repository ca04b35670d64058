// SPDX-License-Identifier: Apache-2.0
// Maps GLSL's built-ins to lanes on the host, as cuda/warp.hpp maps them to threads of CUDA. A workgroup has 64 lanes;
// a subgroup has as many as the test asks for.
#pragma once

#include <utility>

#include "cuda/glsl.hpp"
#include "lanes/accesses.hpp"
#include "lanes/schedule.hpp"

#define gl_LocalInvocationID (gnosphere::cuda::uvec3(gnosphere::lanes::current->local, 0, 0))
#define gl_WorkGroupID \
  (gnosphere::cuda::uvec3(gnosphere::lanes::current->group[0], gnosphere::lanes::current->group[1], 0))
#define gl_GlobalInvocationID \
  (gnosphere::cuda::uvec3(gl_WorkGroupID.x * gnosphere::lanes::kWorkgroupSize + gnosphere::lanes::current->local, 0, 0))
#define gl_NumWorkGroups \
  (gnosphere::cuda::uvec3(gnosphere::lanes::current->groups[0], gnosphere::lanes::current->groups[1], 1))
#define gl_SubgroupID (gnosphere::lanes::current->subgroup)
#define gl_SubgroupInvocationID (gnosphere::lanes::current->inSubgroup)
#define gl_SubgroupSize (gnosphere::lanes::order().subgroupSize)
#define gl_NumSubgroups (gnosphere::lanes::kWorkgroupSize / gl_SubgroupSize)

#define GNO_SHARED_ARRAY(type_, name_, count_) \
  type_* name_ = static_cast<type_*>(gnosphere::lanes::sharedMemory(#name_, sizeof(type_) * count_))

namespace gnosphere::cuda {

constexpr struct { uint x, y, z; } gl_WorkGroupSize = {lanes::kWorkgroupSize, 1, 1};
constexpr uint kVertexRounds = 6;     // see cluster_corners.glsl
constexpr bool kLanesInStep = false;  // see lanes.glsl

using CallSite = std::source_location;

inline void runWorkgroups(uint workgroupsX, uint workgroupsY, const std::function<void()>& main) {
  lanes::dispatch(workgroupsX, workgroupsY, main);
}

inline void barrier(CallSite where = CallSite::current()) {
  lanes::workgroupBarrier(where);
}
inline void subgroupMemoryBarrierBuffer() {}  // orders nothing without an execution barrier
inline void memoryBarrierBuffer() {}          // neither does this
inline void subgroupBarrier(CallSite where = CallSite::current()) {
  lanes::subgroupMemoryBarrier(where);
}

template <typename T>
T subgroupShuffle(T value, uint lane, CallSite where = CallSite::current()) {
  if (lane >= gl_SubgroupSize) lanes::fail("subgroupShuffle of a lane that the subgroup does not have");
  return lanes::meet("subgroupShuffle", &value, sizeof value, where).template of<T>(lane);
}
template <typename T>
T subgroupBroadcast(T value, uint lane, CallSite where = CallSite::current()) {
  return lanes::meetWith("subgroupBroadcast", lane, &value, sizeof value, where).template of<T>(lane);
}
template <typename T>
T subgroupBroadcastFirst(T value, CallSite where = CallSite::current()) {
  return lanes::meet("subgroupBroadcastFirst", &value, sizeof value, where).template of<T>(0);
}
inline bool subgroupElect(CallSite where = CallSite::current()) {
  lanes::meet("subgroupElect", nullptr, 0, where);
  return gl_SubgroupInvocationID == 0;
}

/// Combines the values of all lanes, from lane 0 up.
template <typename T>
T combined(const char* operation, T value, auto with, CallSite where) {
  const lanes::Given given = lanes::meet(operation, &value, sizeof value, where);
  T result = given.of<T>(0);
  for (uint lane = 1; lane < gl_SubgroupSize; ++lane) result = with(result, given.of<T>(lane));
  return result;
}
inline bool subgroupAny(bool value, CallSite where = CallSite::current()) {
  return combined(
      "subgroupAny", value, [](bool a, bool b) { return a || b; }, where);
}
template <typename T>
T subgroupAdd(T value, CallSite where = CallSite::current()) {
  return combined(
      "subgroupAdd", value, [](T a, T b) { return T(a + b); }, where);
}
template <typename T>
T subgroupMin(T value, CallSite where = CallSite::current()) {
  return combined(
      "subgroupMin", value, [](T a, T b) { return min(a, b); }, where);
}
template <typename T>
T subgroupMax(T value, CallSite where = CallSite::current()) {
  return combined(
      "subgroupMax", value, [](T a, T b) { return max(a, b); }, where);
}
inline uint subgroupOr(uint value, CallSite where = CallSite::current()) {
  return combined(
      "subgroupOr", value, [](uint a, uint b) { return a | b; }, where);
}
inline uvec4 subgroupBallot(bool value, CallSite where = CallSite::current()) {
  const lanes::Given given = lanes::meet("subgroupBallot", &value, sizeof value, where);
  uint words[4] = {};
  for (uint lane = 0; lane < gl_SubgroupSize; ++lane)
    if (given.of<bool>(lane)) words[lane / 32] |= 1u << lane % 32;
  return {words[0], words[1], words[2], words[3]};
}
inline uint subgroupBallotBitCount(uvec4 ballot) {
  return bitCount(ballot.x) + bitCount(ballot.y) + bitCount(ballot.z) + bitCount(ballot.w);
}
inline uint subgroupBallotExclusiveBitCount(uvec4 ballot) {
  uint count = 0;
  for (uint lane = 0; lane < gl_SubgroupInvocationID; ++lane) count += ballot[lane / 32] >> lane % 32 & 1;
  return count;
}

// Atomic operations are not instrumented, so that their loads and stores do not count as plain accesses.
uint atomicAdd(uint& memory, uint value);
uint atomicExchange(uint& memory, uint value);
uint atomicOr(uint& memory, uint value);
uint atomicMin(uint& memory, uint value);
uint atomicMax(uint& memory, uint value);
uint64_t atomicMin(uint64_t& memory, uint64_t value);

}  // namespace gnosphere::cuda
