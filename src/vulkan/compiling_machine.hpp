// SPDX-License-Identifier: Apache-2.0
// A Machine that compiles kernels for a Vulkan device and runs none.
#pragma once

#include <memory>

#include "pipeline/machine.hpp"

namespace gnosphere::vulkan {

/// Needs nothing of the driver but its compiler: arrays are in host memory, and nothing is submitted. Its description
/// of a kernel has what the compiler says.
std::unique_ptr<Machine> makeCompilingMachine(const SimulatorOptions& options);

}  // namespace gnosphere::vulkan
