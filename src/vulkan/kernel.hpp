// SPDX-License-Identifier: Apache-2.0
// SPIR-V words -> a compute pipeline, and the layout that all of them share.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "shared.h"
#include "vulkan/buffer.hpp"

namespace gnosphere::vulkan {

/// Values of shaders/options.glsl, in its order; `pass` comes with each kernel.
struct Options {
  uint32_t bounds = gpu::kBoundsExact;
  uint32_t cull = gpu::kCullNearestPoint;
  uint32_t inside = gpu::kInsideWatertight;
  uint32_t range = gpu::kRangeEdgeWeights;
  bool azimuthOffsets = false;
  uint32_t faces = gpu::kFacesMaterial;
  uint32_t culling = 0;
  uint32_t effects = 0;  ///< bits of effects/plan.h
  uint32_t fields = 0;   ///< gpu::kField...
  uint32_t layers = 1;   ///< surfaces that a sub-ray meets
  uint32_t returns = 1;  ///< per beam
};
/// The specialisation of a kernel, in the order of shaders/options.glsl.
std::array<uint32_t, 12> constantsOf(const Options& options, uint32_t pass);

/// What all kernels share: set 0 (a sensor and its work arrays), set 1 (a chunk of the scene), the push constants, and
/// the cache that they are compiled into.
class Layout {
 public:
  /// `effects`: with the bindings that only stage effects has.
  Layout(const Device& device, VkPipelineCache cache, uint32_t maxSets, bool effects);
  Layout(const Layout&) = delete;
  Layout& operator=(const Layout&) = delete;

  VkPipelineLayout handle() const { return pipelineLayout_.get(); }
  VkPipelineCache cache() const { return cache_; }
  uint32_t bindingCount(uint32_t set) const { return bindingCounts_[set]; }
  /// A set of layout 0 or 1, its bindings to come.
  VkDescriptorSet makeSet(uint32_t set);
  /// Binding i is buffers[i].
  void updateSet(VkDescriptorSet handle, std::span<const Buffer* const> buffers);

 private:
  const Device& device_;
  VkPipelineCache cache_;
  uint32_t bindingCounts_[2];
  DeviceHandle<VkDescriptorSetLayout> setLayouts_[2];
  DeviceHandle<VkPipelineLayout> pipelineLayout_;
  DeviceHandle<VkDescriptorPool> pool_;
};

class Kernel {
 public:
  /// `name` is the shader's, for the plan.
  Kernel(const Device& device, const Layout& layout, const char* name, std::span<const uint32_t> spirv,
         const Options& options, uint32_t pass = 0);

  VkPipeline handle() const { return pipeline_.get(); }
  const char* name() const { return name_; }
  const std::array<uint32_t, 12>& constants() const { return constants_; }

 private:
  DeviceHandle<VkPipeline> pipeline_;
  const char* name_;
  std::array<uint32_t, 12> constants_;
};

}  // namespace gnosphere::vulkan
