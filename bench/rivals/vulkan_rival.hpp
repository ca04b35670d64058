// SPDX-License-Identifier: Apache-2.0
// Shared by both ways of tracing rays with Vulkan: all but the pipeline.
#pragma once

#include "rivals/vulkan.hpp"
#include "rivals/vulkan_structure.hpp"

namespace gnosphere::bench {

/// The push constants of rays.glsl.
struct Rays {
  float toScene[3][4];
  VkDeviceAddress directions, placements, hits;
  float rangeMin, rangeMax;
  uint32_t columns, channels;
};
static_assert(sizeof(Rays) == 88 && sizeof(Rays) <= 128);

class VulkanRival : public Rival {
 public:
  VulkanRival(const Scene& scene, const Vec3& origin, const VulkanOptions& options, const char* extension,
              VkShaderStageFlagBits stage);
  ~VulkanRival() override;

  double build() override;
  double update(std::span<const Moved> moved) override;
  double trace(const Sensor& sensor, const Pose& pose, Hits& hits) override;
  double deviceMs() const override { return deviceMs_; }
  uint64_t memoryBytes() const override { return structure_.bytes(); }

 protected:
  /// Binds the pipeline and traces the rays; descriptors and push constants are set before.
  virtual void recordRays(VkCommandBuffer commands, uint32_t columns, uint32_t channels) const = 0;

  VkShaderModule makeShader(std::span<const uint32_t> spirv) const;
  RayDevice& device() { return device_; }
  VkDevice deviceHandle() const { return device_.handle(); }
  VkPipelineLayout layout() const { return layout_; }

 private:
  void makeLayout();
  void makeSet();
  void prepare(const Sensor& sensor);
  Rays raysOf(const Pose& pose) const;

  RayDevice device_;
  VkShaderStageFlagBits stage_;
  Vec3 origin_;
  Motion motion_;
  RayStructure structure_;
  VkDescriptorSetLayout setLayout_ = VK_NULL_HANDLE;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  VkDescriptorPool pool_ = VK_NULL_HANDLE;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
  Sensor sensor_;  // the sensor whose directions are uploaded
  std::vector<float> directionsOnHost_;
  RayBuffer directions_, hits_, readback_;
  double deviceMs_ = 0;
};

std::unique_ptr<Rival> makeRayQuery(const Scene& scene, const Vec3& origin, const VulkanOptions& options);
std::unique_ptr<Rival> makeRayTracingPipeline(const Scene& scene, const Vec3& origin, const VulkanOptions& options);

}  // namespace gnosphere::bench
