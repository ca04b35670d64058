// SPDX-License-Identifier: Apache-2.0
// Which effects a scan of a sensor in a scene is planned with, and why.
#pragma once

#include <cstdint>
#include <vector>

#include "gnosphere/effects.hpp"
#include "gnosphere/plan.hpp"
#include "gnosphere/scan.hpp"
#include "gnosphere/scene.hpp"
#include "gnosphere/sensor.hpp"

namespace gnosphere {

/// One decision per effect, in the order of effectNames(). `fields` are those that the scan holds beyond point, range
/// and owner; `table` may make materials of the scene let light through. Throws Error(invalidArgument) as validate()
/// does, and for an effect that is on and cannot be shown, or off and needed, with the way out.
std::vector<Plan::Decision> decide(const Effects& effects, const Sensor& sensor, const Scene& scene,
                                   const std::vector<Field>& fields, const MaterialTable& table);

/// Bits of effects/plan.h: those that are in.
uint32_t bitsOf(const std::vector<Plan::Decision>& decisions);

}  // namespace gnosphere
