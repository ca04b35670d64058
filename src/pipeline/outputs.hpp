// SPDX-License-Identifier: Apache-2.0
// The arrays of a scan that the host reads back.
#pragma once

#include "common/arrays.h"
#include "effects/sensor_plan.hpp"

namespace gnosphere {

/// One array that is read back.
struct Output {
  gpu::Array array;
  uint32_t bytesPerBeam;
};

/// Lists all outputs except the counters: points and owners or, if `words` is true (see leavesWords()), words; then
/// those of effects.
std::vector<Output> outputsOf(const SensorPlan& plan, bool words);

}  // namespace gnosphere
