// SPDX-License-Identifier: Apache-2.0
// Vulkan's own ray tracing, on the device that we run on.
#pragma once

#include "gnosphere/simulator.hpp"
#include "rivals/rival.hpp"

namespace gnosphere::bench {

enum class VulkanWay { rayQuery, rayTracingPipeline };

struct VulkanOptions {
  DeviceChoice device;
  Motion motion = Motion::none;
  bool validation = false;
  uint64_t maxAllocationBytes = 0;  ///< cap on any one allocation; 0 = what the device allows
};

/// Meshes are shared by their instances, as in the scene, and placed in single precision relative to `origin`, which
/// should be near the sensor. Nothing is built yet. update() renews what is above the meshes; with Motion::everything
/// it also refits every mesh, while build() builds them anew. Drivers compile at the first call of each: warm up.
/// Throws Error(device) that says what the device lacks, Error(outOfMemory).
std::unique_ptr<Rival> makeVulkan(const Scene& scene, const Vec3& origin, VulkanWay way,
                                  const VulkanOptions& options = {});

}  // namespace gnosphere::bench
