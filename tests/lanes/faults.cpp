// SPDX-License-Identifier: Apache-2.0
#include "lanes/faults.hpp"

#include "lanes/lanes.hpp"

namespace gnosphere::lanes {
namespace {

using namespace cuda;

constexpr uint kElements = 2 * kWorkgroupSize;

struct Arrays {
  uint* values = reinterpret_cast<uint*>(allocate("values", kElements * sizeof(uint)));
  uint* sums = reinterpret_cast<uint*>(allocate("sums", 4 * sizeof(uint)));
  ~Arrays() {
    release(values);
    release(sums);
  }
};

uint invocation() {
  return gl_WorkGroupID.x * kWorkgroupSize + gl_LocalInvocationID.x;
}

/// Each lane reads the value of the next lane of its workgroup.
void passOn(const Arrays& arrays, Fault fault) {
  const uint local = gl_LocalInvocationID.x, base = gl_WorkGroupID.x * kWorkgroupSize;
  arrays.values[base + local] = local;
  if (fault != Fault::missingBarrier) barrier();
  const uint next = arrays.values[base + (local + 1) % kWorkgroupSize];
  barrier();
  arrays.values[base + local] = next;
}

/// Each lane reads the value of the next lane of its subgroup, as bin does with the words of a slab.
void exchange(const Arrays& arrays, Fault fault) {
  const uint base = gl_WorkGroupID.x * kWorkgroupSize + gl_SubgroupID * gl_SubgroupSize;
  arrays.values[base + gl_SubgroupInvocationID] = gl_SubgroupInvocationID;
  if (fault != Fault::missingSubgroupBarrier) subgroupBarrier();
  atomicAdd(arrays.sums[0], arrays.values[base + (gl_SubgroupInvocationID + 1) % gl_SubgroupSize]);
}

void count(const Arrays& arrays, Fault fault) {
  if (fault == Fault::plainWrite)
    arrays.sums[1] += 1;
  else
    atomicAdd(arrays.sums[1], 1);
  if (fault == Fault::plainRead && arrays.sums[1] > kElements) arrays.values[invocation()] = 0;
}

void collect(const Arrays& arrays, Fault fault) {
  const uint lane = gl_SubgroupInvocationID;
  if (fault == Fault::absentLane && lane == 0) return;
  if (fault == Fault::divergedCollective && lane % 2 == 0) {
    arrays.values[invocation()] = subgroupBallotBitCount(subgroupBallot(true));
    return;
  }
  uint slot = 0;
  if (subgroupElect()) slot = atomicAdd(arrays.sums[2], gl_SubgroupSize);
  slot = subgroupBroadcast(slot, fault == Fault::differentBroadcast ? lane : 0) + lane;
  arrays.values[slot] = lane;
}

}  // namespace

void runKernelWith(Fault fault) {
  const Arrays arrays;
  const auto run = [](const char* name, const std::function<void()>& main) {
    setKernel(name);
    dispatch(2, 1, main);
  };
  run("pass on", [&] { passOn(arrays, fault); });
  run("exchange", [&] { exchange(arrays, fault); });
  run("count", [&] { count(arrays, fault); });
  run("collect", [&] { collect(arrays, fault); });
  run("read", [&] {
    atomicAdd(arrays.sums[3], arrays.values[fault == Fault::behindTheEnd ? invocation() + 1 : invocation()]);
  });
}

}  // namespace gnosphere::lanes
