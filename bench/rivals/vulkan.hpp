// SPDX-License-Identifier: Apache-2.0
// Vulkan's ray tracing, on the device that GnoSphere uses.
#pragma once

#include "gnosphere/simulator.hpp"
#include "rivals/rival.hpp"

namespace gnosphere::bench {

enum class VulkanWay { rayQuery, rayTracingPipeline };

struct VulkanOptions {
  DeviceChoice device;
  Motion motion = Motion::none;
  bool validation = false;
  uint64_t maxAllocationBytes = 0;  ///< limit on any one allocation; 0: the device's own
};

/// Instances share meshes as in the scene, and are placed in single precision relative to `origin`, which should be
/// near the sensor. build() must be called first. update() rebuilds the top structure; with Motion::everything it also
/// refits every mesh, while build() rebuilds them. Drivers compile at the first call of each function, so warm up.
/// Throws Error(device) with the feature that the device lacks, or Error(outOfMemory).
std::unique_ptr<Rival> makeVulkan(const Scene& scene, const Vec3& origin, VulkanWay way,
                                  const VulkanOptions& options = {});

}  // namespace gnosphere::bench
