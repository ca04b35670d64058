// SPDX-License-Identifier: Apache-2.0
// Traces rays from a compute shader, by VK_KHR_ray_query.
#include <cstdint>

#include "ray_query.spv.h"
#include "rivals/vulkan_rival.hpp"

namespace gnosphere::bench {
namespace {

constexpr uint32_t kTile = 8;  // local size of ray_query.comp in x and y

class RayQuery final : public VulkanRival {
 public:
  RayQuery(const Scene& scene, const Vec3& origin, const VulkanOptions& options)
      : VulkanRival(scene, origin, options, VK_KHR_RAY_QUERY_EXTENSION_NAME, VK_SHADER_STAGE_COMPUTE_BIT) {
    VkComputePipelineCreateInfo create = {VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    create.stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
    create.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    create.stage.module = makeShader(ray_query);
    create.stage.pName = "main";
    create.layout = layout();
    const VkResult result = vkCreateComputePipelines(deviceHandle(), VK_NULL_HANDLE, 1, &create, nullptr, &pipeline_);
    vkDestroyShaderModule(deviceHandle(), create.stage.module, nullptr);
    VK(result);
    device().throwOnMessages();
  }
  ~RayQuery() override { vkDestroyPipeline(deviceHandle(), pipeline_, nullptr); }

  std::string name() const override { return "Vulkan ray query"; }

 private:
  void recordRays(VkCommandBuffer commands, uint32_t columns, uint32_t channels) const override {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_);
    vkCmdDispatch(commands, (columns + kTile - 1) / kTile, (channels + kTile - 1) / kTile, 1);
  }

  VkPipeline pipeline_ = VK_NULL_HANDLE;
};

}  // namespace

std::unique_ptr<Rival> makeRayQuery(const Scene& scene, const Vec3& origin, const VulkanOptions& options) {
  return std::make_unique<RayQuery>(scene, origin, options);
}

}  // namespace gnosphere::bench
