// SPDX-License-Identifier: Apache-2.0
// Decides which effects are planned for a sensor in a scene, and why.
#pragma once

#include <cstdint>
#include <vector>

#include "gnosphere/plan.hpp"
#include "gnosphere/simulator.hpp"

namespace gnosphere {

/// Returns the parts of the accuracy: those given, or those of the level.
AccuracyParts accuracyPartsOf(const SimulatorOptions& options);

/// Returns one decision per effect, in the order of effectNames(). `materials` can give materials of the scene a
/// transmission. Throws Error(invalidArgument) as validate() does, and for an effect that is on but cannot be shown, or
/// off but needed; the message gives the remedy. If `lenient`, an effect that is on need not be visible in the scene.
std::vector<Plan::Decision> decide(const SensorRequest& request, const Scene& scene, const MaterialTable& materials,
                                   bool lenient = false);

/// Leaves out effects that the device or the accuracy does not support; throws Error(invalidArgument) if one is on.
void leaveOutUnsupported(const SimulatorOptions& options, const Effects& effects,
                         std::vector<Plan::Decision>& decisions);

/// Throws Error(invalidArgument) if a footprint has more sub-rays than the device takes.
void checkSubRays(const SimulatorOptions& options, const Effects& effects);

/// Returns the bits (effects/bits.h) of the planned effects.
uint32_t bitsOf(const std::vector<Plan::Decision>& decisions);

}  // namespace gnosphere
