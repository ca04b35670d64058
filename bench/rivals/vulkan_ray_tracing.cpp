// SPDX-License-Identifier: Apache-2.0
// Traces rays from a ray-generation shader, by VK_KHR_ray_tracing_pipeline.
#include <cstdint>
#include <cstring>

#include "ray_tracing_hit.spv.h"
#include "ray_tracing_miss.spv.h"
#include "ray_tracing_start.spv.h"
#include "rivals/vulkan_rival.hpp"

namespace gnosphere::bench {
namespace {

constexpr uint32_t kGroups = 3;  // ray generation, miss, hit

class RayTracingPipeline final : public VulkanRival {
 public:
  RayTracingPipeline(const Scene& scene, const Vec3& origin, const VulkanOptions& options)
      : VulkanRival(scene, origin, options, VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME,
                    VK_SHADER_STAGE_RAYGEN_BIT_KHR) {
    makePipeline();
    makeTable();
    device().throwOnMessages();
  }
  ~RayTracingPipeline() override { vkDestroyPipeline(deviceHandle(), pipeline_, nullptr); }

  std::string name() const override { return "Vulkan ray-tracing pipeline"; }

 private:
  void makePipeline() {
    const std::pair<VkShaderStageFlagBits, VkShaderModule> shaders[kGroups] = {
        {VK_SHADER_STAGE_RAYGEN_BIT_KHR, makeShader(ray_tracing_start)},
        {VK_SHADER_STAGE_MISS_BIT_KHR, makeShader(ray_tracing_miss)},
        {VK_SHADER_STAGE_CLOSEST_HIT_BIT_KHR, makeShader(ray_tracing_hit)}};
    VkPipelineShaderStageCreateInfo stages[kGroups];
    VkRayTracingShaderGroupCreateInfoKHR groups[kGroups];
    for (uint32_t i = 0; i < kGroups; ++i) {
      stages[i] = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
      stages[i].stage = shaders[i].first;
      stages[i].module = shaders[i].second;
      stages[i].pName = "main";
      const bool hit = shaders[i].first == VK_SHADER_STAGE_CLOSEST_HIT_BIT_KHR;
      groups[i] = {VK_STRUCTURE_TYPE_RAY_TRACING_SHADER_GROUP_CREATE_INFO_KHR};
      groups[i].type =
          hit ? VK_RAY_TRACING_SHADER_GROUP_TYPE_TRIANGLES_HIT_GROUP_KHR : VK_RAY_TRACING_SHADER_GROUP_TYPE_GENERAL_KHR;
      groups[i].generalShader = hit ? VK_SHADER_UNUSED_KHR : i;
      groups[i].closestHitShader = hit ? i : VK_SHADER_UNUSED_KHR;
      groups[i].anyHitShader = groups[i].intersectionShader = VK_SHADER_UNUSED_KHR;
    }
    VkRayTracingPipelineCreateInfoKHR create = {VK_STRUCTURE_TYPE_RAY_TRACING_PIPELINE_CREATE_INFO_KHR};
    create.stageCount = create.groupCount = kGroups;
    create.pStages = stages;
    create.pGroups = groups;
    create.maxPipelineRayRecursionDepth = 1;
    create.layout = layout();
    const VkResult result =
        vkCreateRayTracingPipelinesKHR(deviceHandle(), VK_NULL_HANDLE, VK_NULL_HANDLE, 1, &create, nullptr, &pipeline_);
    for (const auto& [stage, shader] : shaders) vkDestroyShaderModule(deviceHandle(), shader, nullptr);
    VK(result);
  }

  // Makes the shader binding table: one handle per group, each at the start of its own region.
  void makeTable() {
    VkPhysicalDeviceRayTracingPipelinePropertiesKHR limits = {
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_PIPELINE_PROPERTIES_KHR};
    VkPhysicalDeviceProperties2 properties = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &limits, {}};
    vkGetPhysicalDeviceProperties2(device().physical(), &properties);
    const uint64_t handleBytes = limits.shaderGroupHandleSize, alignment = limits.shaderGroupBaseAlignment;
    const uint64_t stride = (handleBytes + alignment - 1) / alignment * alignment;
    std::vector<char> handles(kGroups * handleBytes);
    VK(vkGetRayTracingShaderGroupHandlesKHR(deviceHandle(), pipeline_, 0, kGroups, handles.size(), handles.data()));
    table_ = RayBuffer(device(), "shader binding table", kGroups * stride + alignment, MemoryKind::upload);
    const VkDeviceAddress first = (table_.address() + alignment - 1) / alignment * alignment;
    for (uint32_t i = 0; i < kGroups; ++i) {
      regions_[i] = {first + i * stride, stride, stride};
      std::memcpy(static_cast<char*>(table_.mapped()) + (regions_[i].deviceAddress - table_.address()),
                  &handles[i * handleBytes], handleBytes);
    }
  }

  void recordRays(VkCommandBuffer commands, uint32_t columns, uint32_t channels) const override {
    const VkStridedDeviceAddressRegionKHR none = {};
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR, pipeline_);
    vkCmdTraceRaysKHR(commands, &regions_[0], &regions_[1], &regions_[2], &none, columns, channels, 1);
  }

  VkPipeline pipeline_ = VK_NULL_HANDLE;
  RayBuffer table_;
  VkStridedDeviceAddressRegionKHR regions_[kGroups] = {};
};

}  // namespace

std::unique_ptr<Rival> makeRayTracingPipeline(const Scene& scene, const Vec3& origin, const VulkanOptions& options) {
  return std::make_unique<RayTracingPipeline>(scene, origin, options);
}

}  // namespace gnosphere::bench
