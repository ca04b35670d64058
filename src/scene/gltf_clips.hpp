// SPDX-License-Identifier: Apache-2.0
// Animations of a glTF file -> Clip.
#pragma once

#include "scene/gltf_accessor.hpp"

namespace gnosphere {

/// `nodes` gives the index in Scene::animation by node of the file. The scene has its nodes, its meshes and the
/// animated instances of deformable meshes.
std::vector<Clip> readGltfClips(const GltfFile& file, GltfArrays& arrays, const Source& source,
                                const std::vector<uint32_t>& nodes, const Scene& scene, LeftOut& leftOut);

}  // namespace gnosphere
