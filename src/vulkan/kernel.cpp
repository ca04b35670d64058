// SPDX-License-Identifier: Apache-2.0
#include "vulkan/kernel.hpp"

#include <span>

#include "bin.spv.h"
#include "bin_int64.spv.h"
#include "bin_int64_float64.spv.h"
#include "effects.spv.h"
#include "effects_footprint.spv.h"
#include "effects_footprint_looped.spv.h"
#include "effects_panes.spv.h"
#include "effects_strays.spv.h"
#include "fit_clusters.spv.h"
#include "place_instances.spv.h"
#include "prefix_sum.spv.h"
#include "project_clusters.spv.h"
#include "project_groups.spv.h"
#include "project_triangles.spv.h"
#include "project_triangles_int64.spv.h"
#include "project_triangles_int64_float64.spv.h"
#include "records.spv.h"
#include "resolve.spv.h"
#include "vulkan/specialise.hpp"

namespace gnosphere::vulkan {
namespace {

using Module = std::span<const uint32_t>;

// Returns the module for devices without 64-bit atomics, with them, or with double precision as well.
Module byAtomics(const Variant& variant, Module without, Module with, Module withDoubles) {
  if (variant.options.BINNING == gpu::kBinningLists && !variant.float64) return without;
  return variant.float64 ? withDoubles : with;
}

Module moduleOf(const Variant& variant, bool unrolls) {
  switch (variant.kernel) {
    case gnosphere::Kernel::fit_clusters: return fit_clusters;
    case gnosphere::Kernel::place_instances: return place_instances;
    case gnosphere::Kernel::project_groups: return project_groups;
    case gnosphere::Kernel::project_clusters: return project_clusters;
    case gnosphere::Kernel::project_triangles:
      return byAtomics(variant, project_triangles, project_triangles_int64, project_triangles_int64_float64);
    case gnosphere::Kernel::bin: return byAtomics(variant, bin, bin_int64, bin_int64_float64);
    case gnosphere::Kernel::prefix_sum: return prefix_sum;
    case gnosphere::Kernel::resolve: return resolve;
    case gnosphere::Kernel::effects_strays: return effects_strays;
    case gnosphere::Kernel::effects_footprint: return unrolls ? Module(effects_footprint) : effects_footprint_looped;
    case gnosphere::Kernel::effects_panes: return effects_panes;
    case gnosphere::Kernel::records: return records;
    case gnosphere::Kernel::effects: break;
  }
  return effects;
}

DeviceHandle<VkPipeline> compiled(const Device& device, const Variant& variant, VkPipelineLayout layout,
                                  VkPipelineCache cache) {
  const DeviceFunctions& vk = device.vk();
  const std::vector<uint32_t> spirv =
      specialised(moduleOf(variant, device.capabilities().unrolls), wordsOf(variant.options));
  VkShaderModuleCreateInfo module = {VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  module.codeSize = spirv.size() * sizeof spirv[0];
  module.pCode = spirv.data();
  const DeviceHandle<VkShaderModule> shader = device.make(vk.vkCreateShaderModule, vk.vkDestroyShaderModule, module);
  VkComputePipelineCreateInfo create = {VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
  create.stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
  create.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  create.stage.module = shader.get();
  create.stage.pName = "main";
  const FullSubgroups& subgroups = device.capabilities().subgroups;
  VkPipelineShaderStageRequiredSubgroupSizeCreateInfoEXT size = {
      VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_REQUIRED_SUBGROUP_SIZE_CREATE_INFO_EXT};
  size.requiredSubgroupSize = subgroups.size;
  create.stage.flags = VK_PIPELINE_SHADER_STAGE_CREATE_REQUIRE_FULL_SUBGROUPS_BIT_EXT;
  if (subgroups.required) create.stage.pNext = &size;
  create.layout = layout;
  VkPipeline pipeline = VK_NULL_HANDLE;
  VK(vk.vkCreateComputePipelines(device.handle(), cache, 1, &create, nullptr, &pipeline));
  return {pipeline, vk.vkDestroyPipeline, device.handle()};
}

}  // namespace

Kernels::Kernels(const Device& device, const PipelineCache& cache) : device_(device), cache_(cache) {
  const VkPushConstantRange constants = {VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(PushConstants)};
  VkPipelineLayoutCreateInfo layout = {VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  layout.pushConstantRangeCount = 1;
  layout.pPushConstantRanges = &constants;
  layout_ = device.make(device.vk().vkCreatePipelineLayout, device.vk().vkDestroyPipelineLayout, layout);
}

VkPipeline Kernels::of(const Variant& variant) {
  const auto found = pipelines_.find(variant);
  if (found != pipelines_.end()) return found->second.get();
  return pipelines_.emplace(variant, compiled(device_, variant, layout_.get(), cache_.handle())).first->second.get();
}

}  // namespace gnosphere::vulkan
