// SPDX-License-Identifier: Apache-2.0
// The Backend for every device that runs the kernels, whether by Vulkan or CUDA.
#pragma once

#include "pipeline/backend.hpp"
#include "pipeline/machine.hpp"

namespace gnosphere {

std::unique_ptr<Backend> makeDeviceBackend(std::unique_ptr<Machine> machine, const Scene& scene,
                                           const SensorPlans& sensors, const SimulatorOptions& options);

}  // namespace gnosphere
