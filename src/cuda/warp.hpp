// SPDX-License-Identifier: Apache-2.0
// Maps GLSL's built-ins to a CUDA thread: a warp is a subgroup, a block is a workgroup. The shaders call subgroup
// operations only where all invocations of the subgroup are active, so every mask is full.
#pragma once

#include "cuda/glsl.hpp"

#define gl_LocalInvocationID (uvec3(threadIdx.x, 0, 0))
#define gl_WorkGroupID (uvec3(blockIdx.x, blockIdx.y, 0))
#define gl_NumWorkGroups (uvec3(gridDim.x, gridDim.y, 1))
#define gl_SubgroupID (threadIdx.x / gl_SubgroupSize)
#define gl_SubgroupInvocationID (threadIdx.x % gl_SubgroupSize)
#define gl_NumSubgroups (gl_WorkGroupSize.x / gl_SubgroupSize)

// Declares __shared__ memory within a function, because a class member cannot be __shared__.
#define GNO_SHARED_ARRAY(type_, name_, count_)    \
  __device__ static type_* name_##OfWorkgroup() { \
    __shared__ type_ memory[count_];              \
    return memory;                                \
  }                                               \
  type_* name_ = name_##OfWorkgroup()

namespace gnosphere::cuda {

constexpr uint gl_SubgroupSize = 32;
constexpr struct { uint x, y, z; } gl_WorkGroupSize = {64, 1, 1};
constexpr uint kVertexRounds = 3;     // see cluster_corners.glsl
constexpr bool kLanesInStep = false;  // see lanes.glsl
constexpr uint kFullWarp = 0xffffffffu;

GNO_DEVICE void barrier() {
  __syncthreads();
}

GNO_DEVICE void subgroupMemoryBarrierBuffer() {}
GNO_DEVICE void subgroupBarrier() {
  __syncwarp();
}

template <typename T>
GNO_DEVICE T subgroupShuffle(T value, uint lane) {
  struct Words {
    uint word[sizeof(T) / sizeof(uint)];
  };
  auto words = __builtin_bit_cast(Words, value);
  for (uint& word : words.word) word = __shfl_sync(kFullWarp, word, int(lane));
  return __builtin_bit_cast(T, words);
}
template <typename T>
GNO_DEVICE T subgroupBroadcast(T value, uint lane) {
  return subgroupShuffle(value, lane);
}
template <typename T>
GNO_DEVICE T subgroupBroadcastFirst(T value) {
  return subgroupShuffle(value, 0);
}
GNO_DEVICE bool subgroupElect() {
  return gl_SubgroupInvocationID == 0;
}
GNO_DEVICE bool subgroupAny(bool value) {
  return __any_sync(kFullWarp, value);
}
GNO_DEVICE uvec4 subgroupBallot(bool value) {
  return {__ballot_sync(kFullWarp, value), 0, 0, 0};
}
GNO_DEVICE uint subgroupBallotBitCount(uvec4 ballot) {
  return __popc(ballot.x);
}
GNO_DEVICE uint subgroupBallotExclusiveBitCount(uvec4 ballot) {
  return __popc(ballot.x & ((1u << gl_SubgroupInvocationID) - 1));
}
template <typename T>
GNO_DEVICE T subgroupAdd(T value) {
  for (uint step = gl_SubgroupSize / 2; step > 0; step /= 2)
    value += subgroupShuffle(value, gl_SubgroupInvocationID ^ step);
  return value;
}
template <typename T>
GNO_DEVICE T subgroupMin(T value) {
  for (uint step = gl_SubgroupSize / 2; step > 0; step /= 2)
    value = min(value, subgroupShuffle(value, gl_SubgroupInvocationID ^ step));
  return value;
}
template <typename T>
GNO_DEVICE T subgroupMax(T value) {
  for (uint step = gl_SubgroupSize / 2; step > 0; step /= 2)
    value = max(value, subgroupShuffle(value, gl_SubgroupInvocationID ^ step));
  return value;
}
GNO_DEVICE uint subgroupOr(uint value) {
  for (uint step = gl_SubgroupSize / 2; step > 0; step /= 2)
    value |= subgroupShuffle(value, gl_SubgroupInvocationID ^ step);
  return value;
}

GNO_DEVICE uint atomicExchange(uint& memory, uint value) {
  return ::atomicExch(&memory, value);
}
GNO_DEVICE uint atomicAdd(uint& memory, uint value) {
  return ::atomicAdd(&memory, value);
}
GNO_DEVICE uint atomicMin(uint& memory, uint value) {
  return ::atomicMin(&memory, value);
}
GNO_DEVICE uint atomicMax(uint& memory, uint value) {
  return ::atomicMax(&memory, value);
}
GNO_DEVICE uint atomicOr(uint& memory, uint value) {
  return ::atomicOr(&memory, value);
}
GNO_DEVICE void memoryBarrierBuffer() {
  __threadfence();
}
GNO_DEVICE uint64_t atomicMin(uint64_t& memory, uint64_t value) {
  static_assert(sizeof(uint64_t) == sizeof(unsigned long long));
  return ::atomicMin(reinterpret_cast<unsigned long long*>(&memory), static_cast<unsigned long long>(value));
}

}  // namespace gnosphere::cuda
