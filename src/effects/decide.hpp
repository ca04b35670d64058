// SPDX-License-Identifier: Apache-2.0
// Which effects a scan of a sensor in a scene is planned with, and why.
#pragma once

#include <cstdint>
#include <vector>

#include "gnosphere/plan.hpp"
#include "gnosphere/simulator.hpp"

namespace gnosphere {

/// One decision per effect, in the order of effectNames(). `materials` may make materials of the scene let light
/// through. Throws Error(invalidArgument) as validate() does, and for an effect that is on and cannot be shown, or off
/// and needed, with the way out; but an effect that is on may lack what would show it if `lenient`.
std::vector<Plan::Decision> decide(const SensorRequest& request, const Scene& scene, const MaterialTable& materials,
                                   bool lenient = false);

/// Takes out what the options' device and accuracy cannot show; throws Error(invalidArgument) if it is on.
void leaveOutUnsupported(const SimulatorOptions& options, std::vector<Plan::Decision>& decisions);

/// Bits of effects/bits.h: those that are in.
uint32_t bitsOf(const std::vector<Plan::Decision>& decisions);

}  // namespace gnosphere
