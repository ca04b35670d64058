// SPDX-License-Identifier: Apache-2.0
// Replaces the CUDA backend in a build without CUDA.
#include "gnosphere/error.hpp"
#include "pipeline/backend.hpp"

namespace gnosphere::cuda {

std::unique_ptr<Backend> makeBackend(const Scene&, const SensorPlans&, const SimulatorOptions& options) {
  throw Error(ErrorCode::device, "device '" + nameOf(options.device) +
                                     "': CUDA is not built in; configure the build with -DGNOSPHERE_CUDA=ON");
}

std::vector<DeviceInfo> devices(std::string& problem) {
  problem = "CUDA is not built in";
  return {};
}

}  // namespace gnosphere::cuda
