// SPDX-License-Identifier: Apache-2.0
#include "pipeline/backend.hpp"

#include "gnosphere/error.hpp"
#include "pipeline/result_ring.hpp"

namespace gnosphere {

std::unique_ptr<ResultRing> Backend::makeRing(size_t, uint64_t, uint64_t) {
  return nullptr;
}

std::unique_ptr<Backend> makeBackend(const Scene& scene, const SensorPlans& sensors, const SimulatorOptions& options) {
  const bool own = options.device.kind == DeviceChoice::Kind::vulkan && !options.device.adopted;
  for (const auto& [asked, name] :
       {std::pair(options.compileOnly, "compile_only"), {options.resultsOnDevice, "results_on_device"}})
    if (asked && !own)
      throw Error(
          ErrorCode::invalidArgument,
          std::string(name) + " is for a Vulkan device of the library's own, not for " + nameOf(options.device));
  switch (options.device.kind) {
    case DeviceChoice::Kind::reference: return makeReferenceBackend(scene, sensors, options);
    case DeviceChoice::Kind::cuda:
    case DeviceChoice::Kind::cudaFast: return cuda::makeBackend(scene, sensors, options);
    case DeviceChoice::Kind::vulkan: break;
  }
  return makeVulkanBackend(scene, sensors, options);
}

}  // namespace gnosphere
