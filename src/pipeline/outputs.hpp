// SPDX-License-Identifier: Apache-2.0
// The arrays of a scan that the host reads back.
#pragma once

#include "arrays.h"
#include "effects/sensor_plan.hpp"

namespace gnosphere {

/// One array that is read back.
struct Output {
  gpu::Array array;
  uint32_t bytesPerBeam;
};

/// Lists all outputs except the counters: points, owners and then those of effects. If `words` is true (see
/// leavesWords()), only `words`, and with panes the list of the beams that meet one, their points and owners.
std::vector<Output> outputsOf(const SensorPlan& plan, bool words);

}  // namespace gnosphere
