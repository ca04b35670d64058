// SPDX-License-Identifier: Apache-2.0
#include "pipeline/backend.hpp"

#include "gnosphere/error.hpp"

namespace gnosphere {

std::unique_ptr<Backend> makeBackend(const Scene& scene, const SensorPlans& sensors, const SimulatorOptions& options) {
  if (options.compileOnly && (options.device.kind != DeviceChoice::Kind::vulkan || options.device.adopted))
    throw Error(ErrorCode::invalidArgument,
                "compileOnly is for a Vulkan device of the library's own, not for " + nameOf(options.device));
  switch (options.device.kind) {
    case DeviceChoice::Kind::reference: return makeReferenceBackend(scene, sensors, options);
    case DeviceChoice::Kind::cuda:
    case DeviceChoice::Kind::cudaFast: return cuda::makeBackend(scene, sensors, options);
    case DeviceChoice::Kind::vulkan: break;
  }
  return makeVulkanBackend(scene, sensors, options);
}

}  // namespace gnosphere
