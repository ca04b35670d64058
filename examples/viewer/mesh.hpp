// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "camera.hpp"
#include "pipeline.hpp"

namespace viewer {

/// Draws the triangles of a scene. Transparent materials are left out, and textures are not read.
class SceneMesh {
 public:
  SceneMesh(const Device& on, VkRenderPass pass, const gnosphere::Scene& scene);

  /// Draws the instances where the scene has them now; its meshes must be those of the constructor.
  void draw(VkCommandBuffer commands, const gnosphere::Scene& scene, const glm::dmat4& toClip) const;

 private:
  struct Part {
    uint32_t firstIndex, indexCount;
    int32_t firstVertex;
    glm::vec3 colour;
  };

  Pipeline pipeline_;
  std::vector<std::vector<Part>> parts_;  // by mesh
  std::unique_ptr<Buffer> vertices_, indices_;
};

}  // namespace viewer
