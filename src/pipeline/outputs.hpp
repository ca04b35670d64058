// SPDX-License-Identifier: Apache-2.0
// What the stages leave of a scan for the host to read.
#pragma once

#include "effects/sensor_plan.hpp"

namespace gnosphere {

/// One array that is read back.
struct Output {
  uint32_t binding;  ///< gpu::kBind...
  uint32_t bytesPerBeam;
};

/// All outputs but the counters: points and owners first, or `words` alone where leavesWords().
std::vector<Output> outputsOf(const SensorPlan& plan, bool words);
/// The most that any one array holds of a beam.
uint64_t mostBytesPerBeam(const SensorPlan& plan);

}  // namespace gnosphere
