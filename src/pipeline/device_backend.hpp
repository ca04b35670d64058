// SPDX-License-Identifier: Apache-2.0
// Scans on any device that runs the kernels.
#pragma once

#include "pipeline/backend.hpp"
#include "pipeline/machine.hpp"

namespace gnosphere {

std::unique_ptr<Backend> makeDeviceBackend(std::unique_ptr<Machine> machine, const Scene& scene,
                                           const SensorPlans& sensors, const SimulatorOptions& options);

}  // namespace gnosphere
