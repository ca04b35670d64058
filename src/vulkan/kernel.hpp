// SPDX-License-Identifier: Apache-2.0
// Compiled kernels from the SPIR-V modules.
#pragma once

#include <map>
#include <mutex>
#include <shared_mutex>
#include <span>
#include <string>

#include "common/shared.h"
#include "gnosphere/plan.hpp"
#include "pipeline/kernels.hpp"
#include "vulkan/pipeline_cache.hpp"
#include "vulkan/specialise.hpp"

namespace gnosphere::vulkan {

/// The push constants of every dispatch.
struct PushConstants {
  VkDeviceAddress addresses;  ///< address of the frame's gpu::Addresses
  gpu::Pass pass;
};
static_assert(sizeof(PushConstants) <= 128, "Vulkan guarantees no more");

/// Puts constants into a module: codeOf() of specialise.hpp, or a replacement in a test.
using Specialise = Code (*)(std::span<const uint32_t> module, std::span<const uint32_t> constants, bool split);

/// A kernel as a driver gets it.
struct KernelCode : Code {
  std::vector<uint32_t> constants;  ///< by SpecId; the driver needs them if the module is not specialised
  uint32_t lanes = 0;               ///< of a subgroup
};
KernelCode codeOf(const Capabilities& capabilities, const Variant& variant, Specialise specialise = codeOf);

/// A hash of the code with which a driver compiles a kernel, and of the size of its subgroups. Kernels of equal digests
/// share a handle.
using KernelDigest = std::string;
KernelDigest digestOf(const KernelCode& code);

/// A kernel for a command buffer: a pipeline, or a shader object where Capabilities::keepsShaders. Both are null if the
/// kernel is not compiled.
struct KernelHandle {
  VkPipeline pipeline = VK_NULL_HANDLE;
  VkShaderEXT shader = VK_NULL_HANDLE;

  explicit operator bool() const { return pipeline != VK_NULL_HANDLE || shader != VK_NULL_HANDLE; }
  bool operator==(const KernelHandle&) const = default;
};

/// The compiled kernels of a device; each is compiled once. Kernels that are the same module once their options are in
/// place share their handle. Several threads may use it at once.
class Kernels {
 public:
  Kernels(const Device& device, const PipelineCache& cache, Specialise specialise = codeOf);

  /// Returns the pipeline layout; it has only PushConstants, no descriptors.
  VkPipelineLayout layout() const { return layout_.get(); }
  /// Compiles the kernels that are not yet compiled, on all threads of the host.
  void prepare(std::span<const Variant> variants);
  /// Returns the handle of a kernel, null if it is not compiled.
  KernelHandle of(const Variant& variant) const;
  /// Returns the number of different handles.
  size_t count() const;
  /// Adds what is known of a compiled kernel: how long the driver took and, on a device with statistics, what its
  /// compiler says.
  void describe(const Variant& variant, Plan::Pipeline& pipeline) const;

 private:
  struct Compiled {
    DeviceHandle<VkPipeline> pipeline;
    DeviceHandle<VkShaderEXT> shader;
    double ms = 0;
  };
  struct Missing;
  void make(Missing& one) const;
  /// Returns a kernel that is compiled, or null.
  const Compiled* find(const Variant& variant) const;

  const Device& device_;
  const PipelineCache& cache_;
  Specialise specialise_;
  DeviceHandle<VkPipelineLayout> layout_;
  std::mutex preparing_;             ///< held while kernels are compiled, which does not stop those who use others
  mutable std::shared_mutex mutex_;  ///< guards the members below
  std::map<KernelDigest, Compiled> compiled_;
  std::map<Variant, const Compiled*> pipelines_;  ///< places in compiled_
};

}  // namespace gnosphere::vulkan
