// SPDX-License-Identifier: Apache-2.0
// Compute pipelines from the SPIR-V modules.
#pragma once

#include <map>
#include <span>

#include "gnosphere/plan.hpp"
#include "pipeline/kernels.hpp"
#include "shared.h"
#include "vulkan/pipeline_cache.hpp"

namespace gnosphere::vulkan {

/// The push constants of every dispatch.
struct PushConstants {
  VkDeviceAddress addresses;  ///< address of the frame's gpu::Addresses
  gpu::Pass pass;
};

/// The compiled kernels of a simulator; each is compiled once.
class Kernels {
 public:
  Kernels(const Device& device, const PipelineCache& cache);

  /// Returns the pipeline layout; it has only PushConstants, no descriptors.
  VkPipelineLayout layout() const { return layout_.get(); }
  /// Compiles the kernels that are not yet compiled, on all threads of the host.
  void prepare(std::span<const Variant> variants);
  /// Returns the pipeline of a kernel; compiles it if prepare() has not done so.
  VkPipeline of(const Variant& variant);
  /// Returns the number of compiled kernels.
  size_t count() const { return pipelines_.size(); }
  /// Adds what is known of a compiled kernel: how long the driver took and, on a device with statistics, what its
  /// compiler says.
  void describe(const Variant& variant, Plan::Pipeline& pipeline) const;

 private:
  struct Compiled {
    DeviceHandle<VkPipeline> pipeline;
    double ms = 0;
  };
  Compiled make(const Variant& variant) const;

  const Device& device_;
  const PipelineCache& cache_;
  DeviceHandle<VkPipelineLayout> layout_;
  std::map<Variant, Compiled> pipelines_;
};

}  // namespace gnosphere::vulkan
