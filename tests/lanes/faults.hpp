// SPDX-License-Identifier: Apache-2.0
// Small kernels with one fault each, to see that lanes on the host find it, and the same kernels without the fault.
#pragma once

#include <cstdint>

namespace gnosphere::lanes {

enum class Fault {
  none,
  missingBarrier,          ///< a lane reads what another lane of its workgroup has written, without barrier()
  missingSubgroupBarrier,  ///< the same within a subgroup, without subgroupBarrier()
  plainWrite,              ///< all lanes add to one word without an atomic
  plainRead,               ///< lanes read a word that others change atomically
  divergedCollective,      ///< a ballot in a branch that every other lane takes
  differentBroadcast,      ///< a broadcast from another lane in each lane
  absentLane,              ///< lane 0 has returned before the others elect one
  behindTheEnd,            ///< a read behind the last element of an array
};

/// Runs two workgroups of a kernel with this fault and of kernels without one. Throws Finding as dispatch() does.
void runKernelWith(Fault fault);

}  // namespace gnosphere::lanes
