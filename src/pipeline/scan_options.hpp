// SPDX-License-Identifier: Apache-2.0
// Translates the options of a simulator into the options of the kernels, for every kind of device.
#pragma once

#include "common/shared.h"
#include "effects/decide.hpp"
#include "effects/sensor_plan.hpp"
#include "gnosphere/simulator.hpp"
#include "pipeline/kernels.hpp"

namespace gnosphere {

/// Returns the gpu::kCull... bits of the options.
uint32_t cullingBits(const SimulatorOptions& options);
/// Returns the options of a sensor's kernels; the caller sets BINNING, PASS, MOTION and kFieldPoints.
Options kernelOptions(const SimulatorOptions& options, const SensorPlan& plan);
/// Returns the distance in metres beyond which instances cannot be hit by beams of a range.
double reachOf(const SimulatorOptions& options, double rangeMax);
/// Returns whether the words (8 bytes per beam) tell points, ranges and owners: the host reads and resolves them, and
/// no stage does. Words suffice if there is one return per beam, on the beam's axis. The nearest hits must be in words,
/// which lists have only if stage effects computes the results.
bool leavesWords(uint32_t binning, const SensorPlan& plan);
/// Returns whether a StillImage may be kept.
bool keepsStill(const SimulatorOptions& options, uint32_t binning, const SensorPlan& plan);
/// Returns the name that Plan::binning uses.
const char* nameOfBinning(uint32_t binning);

}  // namespace gnosphere
