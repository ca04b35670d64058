// SPDX-License-Identifier: Apache-2.0
// SPIR-V words -> a compute pipeline.
#pragma once

#include <map>

#include "pipeline/kernels.hpp"
#include "shared.h"
#include "vulkan/pipeline_cache.hpp"

namespace gnosphere::vulkan {

/// What every kernel is told when it is dispatched.
struct PushConstants {
  VkDeviceAddress addresses;  ///< of the frame's gpu::Addresses
  gpu::Pass pass;
};

/// The kernels that a simulator's sensors need, each compiled once.
class Kernels {
 public:
  Kernels(const Device& device, const PipelineCache& cache);

  /// Of PushConstants, and nothing else.
  VkPipelineLayout layout() const { return layout_.get(); }
  /// Compiled now, if it is asked for the first time.
  VkPipeline of(const Variant& variant);

 private:
  const Device& device_;
  const PipelineCache& cache_;
  DeviceHandle<VkPipelineLayout> layout_;
  std::map<Variant, DeviceHandle<VkPipeline>> pipelines_;
};

}  // namespace gnosphere::vulkan
