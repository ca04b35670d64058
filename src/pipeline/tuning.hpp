// SPDX-License-Identifier: Apache-2.0
// Choices that make scans fast on each kind of device. Tuning never changes a result.
#pragma once

#include <cstdint>

#include "common/shared.h"
#include "gnosphere/simulator.hpp"

namespace gnosphere {

struct Traits;

/// Largest number of workgroups per dispatch; kernels loop until all items are done.
struct DispatchSizes {
  uint32_t workgroups, cullWorkgroups, triangleWorkgroups, footprintWorkgroups;
};
DispatchSizes dispatchSizesOf(const Traits& traits);

/// Returns the gpu::kBinning... value for the options and the device.
uint32_t chooseBinning(const SimulatorOptions& options, const Traits& traits, bool footprint);

/// Returns how many sub-rays each lane of a subgroup computes if the lanes share the sub-rays of a beam; 0 if one
/// invocation computes all sub-rays of its beam. `rays` is the number of places for sub-rays, placesFor().
uint32_t raysPerLane(const SimulatorOptions& options, const Traits& traits, uint32_t rays);

/// Returns the binary logarithm of the number of columns that one subgroup owns with Binning::slabs.
uint32_t slabShift(uint32_t columns);
/// The same for a submission of several views, each of which has slabs of its own.
uint32_t slabShiftOfViews();
/// Returns the bytes that the lists of several views may take together.
uint64_t mostListBytes(const SimulatorOptions& options, const Traits& traits);
/// Returns the most views of a submission on a device for a sensor with so many beams; 1 if its scans gain nothing from
/// being submitted together.
uint32_t mostViews(const Traits& traits, uint64_t beams);

/// Returns the most work of one submission, see Step::work; 0 for no limit.
uint64_t mostWork(const SimulatorOptions& options, const Traits& traits);

/// Returns how many projected triangles there is room for at first in a submission of several views, per view.
uint32_t firstProjectedOfView(uint64_t beams);

/// Numbers of entries for which the lists of a scan have room.
struct Capacities {
  uint32_t projected = 0, tiles = 0, candidates = 0;
};
/// Returns the initial capacities; lists grow when a scan needs more.
Capacities firstCapacities(uint32_t binning, bool panes, bool footprint, uint64_t beams, uint64_t triangles);
/// Returns the largest capacities that the lists of a scan with footprints needed in the scenes that were measured, for
/// a sensor with so many beams.
Capacities mostOfFootprints(uint64_t beams);
/// Returns what the lists probably need if footprints meet so many projected triangles that there was no room for all.
Capacities leastWithFootprints(uint64_t projected);

}  // namespace gnosphere
