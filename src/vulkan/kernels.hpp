// SPDX-License-Identifier: Apache-2.0
// Which pipelines a sensor's stages are made of.
#pragma once

#include <optional>
#include <vector>

#include "effects/sensor_plan.hpp"
#include "vulkan/kernel.hpp"

namespace gnosphere::vulkan {

/// The pipelines that a way of binning dispatches, and no others.
struct Kernels {
  /// `float64` chooses the modules whose exact tests filter in double precision.
  /// `moving`: of scans in motion.
  Kernels(const Device& device, const Layout& layout, const Options& options, uint32_t binning, bool float64,
          bool moving, const SensorPlan& plan);
  Kernel projectGroups;
  Kernel projectClusters;
  Kernel projectOccluders;
  Kernel projectTriangles;
  std::vector<Kernel> bin;
  std::vector<Kernel> prefixSum;
  std::optional<Kernel> resolve;  ///< or footprint, or neither where the host resolves words
  std::vector<Kernel> footprint;
  std::optional<Kernel> surfaces;  ///< not with footprint, which looks at them itself
  std::optional<Kernel> effects;
};

}  // namespace gnosphere::vulkan
