// SPDX-License-Identifier: Apache-2.0
#include "mesh.hpp"

#include "mesh_fragment.spv.h"
#include "mesh_vertex.spv.h"

namespace viewer {
namespace {

struct Constants {
  glm::mat4 toClip;
  glm::mat3x4 toWorld;  // the linear part; w of its columns is the colour
};

constexpr VkVertexInputAttributeDescription kPosition = {0, 0, VK_FORMAT_R32G32B32_SFLOAT, 0};

bool isOpaque(const gnosphere::Material& material) {
  return material.alphaMode != gnosphere::AlphaMode::blend && material.transmission == 0;
}

}  // namespace

SceneMesh::SceneMesh(const Device& on, VkRenderPass pass, const gnosphere::Scene& scene)
    : pipeline_(on, pass,
                {mesh_vertex,
                 mesh_fragment,
                 VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
                 3 * sizeof(float),
                 {&kPosition, 1},
                 sizeof(Constants)}) {
  std::vector<float> positions;
  std::vector<uint32_t> indices;
  for (const gnosphere::Mesh& mesh : scene.meshes) {
    std::vector<Part>& parts = parts_.emplace_back();
    for (const gnosphere::MeshPart& part : mesh.parts) {
      const gnosphere::Material& material = scene.materials[part.material];
      if (!isOpaque(material)) continue;
      parts.push_back({static_cast<uint32_t>(indices.size()) + 3 * part.firstTriangle,
                       3 * part.triangleCount,
                       static_cast<int32_t>(positions.size() / 3),
                       {material.baseColor[0], material.baseColor[1], material.baseColor[2]}});
    }
    positions.insert(positions.end(), mesh.positions.begin(), mesh.positions.end());
    indices.insert(indices.end(), mesh.indices.begin(), mesh.indices.end());
  }
  vertices_ = std::make_unique<Buffer>(on, positions.data(), positions.size() * sizeof(float),
                                       VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
  indices_ =
      std::make_unique<Buffer>(on, indices.data(), indices.size() * sizeof(uint32_t), VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
}

void SceneMesh::draw(VkCommandBuffer commands, const gnosphere::Scene& scene, const glm::dmat4& toClip) const {
  pipeline_.bind(commands, *vertices_);
  vkCmdBindIndexBuffer(commands, indices_->buffer, 0, VK_INDEX_TYPE_UINT32);
  for (const gnosphere::Instance& instance : scene.instances) {
    if (instance.mesh == gnosphere::kNoMesh) continue;
    const glm::dmat4 toWorld =
        glm::translate(matrixOf(instance.transform), vectorOf(scene.meshes[instance.mesh].origin));
    Constants constants = {glm::mat4(toClip * toWorld), glm::mat3x4(glm::mat4(toWorld))};
    for (const Part& part : parts_[instance.mesh]) {
      for (int i = 0; i < 3; ++i) constants.toWorld[i][3] = part.colour[i];
      pipeline_.push(commands, constants);
      vkCmdDrawIndexed(commands, part.indexCount, 1, part.firstIndex, part.firstVertex, 0);
    }
  }
}

}  // namespace viewer
