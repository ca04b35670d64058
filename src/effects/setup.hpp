// SPDX-License-Identifier: Apache-2.0
// What stage effects needs to know of a simulator, sensor by sensor.
#pragma once

#include <vector>

#include "effects/parameters.h"
#include "effects/planned.hpp"

namespace gnosphere {

struct EffectsSetup {
  PlannedEffects planned;
  Effects effects;
  std::vector<gpu::Optics4> optics;     ///< per material
  std::vector<AlphaImage> alphaImages;  ///< only where holes are planned
  Sensor sensor;
  uint32_t sensorIndex = 0;
};

/// Of every sensor. Throws Error(invalidArgument) as planEffects() does.
std::vector<EffectsSetup> setUpEffects(const Scene& scene, const std::vector<Sensor>& sensors,
                                       const SimulatorOptions& options);

/// Whether it is planned for any of the sensors.
bool anyPlans(const std::vector<EffectsSetup>& setups, bool (PlannedEffects::*asks)() const);

}  // namespace gnosphere
