// SPDX-License-Identifier: Apache-2.0
// What is fastest on which kind of device. Nothing here changes a result.
#pragma once

#include <cstdint>
#include <vector>

#include "gnosphere/simulator.hpp"
#include "shared.h"

namespace gnosphere {

struct Traits;

/// Workgroups per dispatch, at most: kernels loop over however many items there are.
struct DispatchSizes {
  uint32_t groups, cullGroups, triangleGroups, footprintGroups;
};
DispatchSizes dispatchSizesOf(const Traits& traits, uint32_t binning);

/// gpu::kBinning...: how the options, the device and a footprint, which needs lists, let triangles meet beams.
uint32_t chooseBinning(const SimulatorOptions& options, const Traits& traits, bool footprint);

/// Metres, ascending, the last one infinity: what lies nearer than one end is binned before, and hides, what lies
/// beyond it. One shell is everything.
std::vector<float> shellEnds(const SimulatorOptions& options, uint32_t binning, const gpu::Frame& frame,
                             uint64_t triangles);

/// Columns that one subgroup owns with Binning::slabs, as a power of two.
uint32_t slabShift(uint32_t columns);

/// Entries of the lists of a scan.
struct Capacities {
  uint32_t projected = 0, tiles = 0, candidates = 0;
};
/// Room to begin with; lists grow to what a scan turns out to need.
Capacities firstCapacities(uint32_t binning, uint64_t beams, uint64_t triangles);

}  // namespace gnosphere
