// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "device.hpp"

namespace viewer {

/// A pipeline that draws with a vertex buffer, push constants and a depth test.
class Pipeline {
 public:
  struct Parts {
    std::span<const uint32_t> vertexShader, fragmentShader;
    VkPrimitiveTopology topology;
    uint32_t stride;  ///< bytes per vertex
    std::span<const VkVertexInputAttributeDescription> attributes;
    uint32_t constantBytes;
  };

  Pipeline(const Device& on, VkRenderPass pass, const Parts& parts);
  ~Pipeline();
  Pipeline(const Pipeline&) = delete;
  Pipeline& operator=(const Pipeline&) = delete;

  void bind(VkCommandBuffer commands, const Buffer& vertices) const;
  template <typename Constants>
  void push(VkCommandBuffer commands, const Constants& constants) const {
    vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0,
                       sizeof constants, &constants);
  }

 private:
  VkDevice device_;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  VkPipeline pipeline_ = VK_NULL_HANDLE;
};

}  // namespace viewer
