// SPDX-License-Identifier: Apache-2.0
// Turns the nodes, skins and animations of a glTF file into Scene::animation.
#pragma once

#include "scene/gltf_accessor.hpp"

namespace gnosphere {

/// How an instance of the scene comes from a node of the file.
struct GltfPlacement {
  size_t node = 0;
  bool instanced = false;  ///< by EXT_mesh_gpu_instancing; `offset` maps the instance's frame to that of the node
  Transform offset;
};

/// A matrix as glTF has it, by columns; its fourth row is not read.
Transform gltfMatrix(const double* columns);

/// Fills Scene::animation, gives every node that deforms a mesh a mesh of its own, and puts it into the state at rest.
/// `placements` are by instance of the scene, `parents` by node of the file (-1: none).
void readGltfAnimation(const GltfFile& file, GltfArrays& arrays, const Source& source, const std::vector<int>& parents,
                       const std::vector<GltfPlacement>& placements, Scene& scene, LeftOut& leftOut);

}  // namespace gnosphere
