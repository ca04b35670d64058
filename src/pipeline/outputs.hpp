// SPDX-License-Identifier: Apache-2.0
// What the stages leave of a scan for the host to read.
#pragma once

#include "arrays.h"
#include "effects/sensor_plan.hpp"

namespace gnosphere {

/// One array that is read back.
struct Output {
  gpu::Array array;
  uint32_t bytesPerBeam;
};

/// All outputs but the counters: points and owners first, or `words` alone where leavesWords().
std::vector<Output> outputsOf(const SensorPlan& plan, bool words);

}  // namespace gnosphere
