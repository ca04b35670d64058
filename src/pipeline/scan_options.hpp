// SPDX-License-Identifier: Apache-2.0
// What the options of a simulator mean for the kernels of a scan, on whatever device.
#pragma once

#include "effects/sensor_plan.hpp"
#include "gnosphere/simulator.hpp"
#include "pipeline/kernels.hpp"
#include "shared.h"

namespace gnosphere {

AccuracyParts accuracyPartsOf(const SimulatorOptions& options);
/// gpu::kCull... bits.
uint32_t cullingBits(const SimulatorOptions& options);
/// Of a sensor's kernels; BINNING, PASS and MOTION are left to the caller.
Options kernelOptions(const SimulatorOptions& options, const SensorPlan& plan, bool azimuthOffsets);
/// Metres: instances farther away need not be looked at.
double reachOf(const SimulatorOptions& options, const gpu::Frame& frame);
/// Whether words are all that is read back, for the host to resolve: 8 bytes per beam, where nothing but geometry is
/// plan.
bool leavesWords(uint32_t binning, const SensorPlan& plan);
/// Whether a StillImage may be kept.
bool keepsStill(const SimulatorOptions& options, uint32_t binning, const SensorPlan& plan);
/// As Plan::binning names it.
const char* nameOfBinning(uint32_t binning);

}  // namespace gnosphere
