// SPDX-License-Identifier: Apache-2.0
// Checks of the parts of a scene that can be added one by one. Each throws Error(invalidArgument) that begins with
// `name`.
#pragma once

#include <string>
#include <vector>

#include "gnosphere/scene.hpp"

namespace gnosphere {

/// Returns the mesh of an instance; one that does not exist is an error that names the instance.
const Mesh& meshOf(const Scene& scene, size_t instance);

/// As many alpha values as pixels, and at least one.
void validate(const AlphaImage& image, const std::string& name);
/// Factors in 0..1, as glTF has them, and a retro-reflection of 0..Material::kMostRetro.
void validate(const Material& material, const std::string& name);
/// Arrays of fitting sizes, indices within them, and parts that cover every triangle with materials that exist.
void validate(const Mesh& mesh, const std::string& name, const std::vector<Material>& materials);

/// As many joints and weights as the mesh has, or none at all; finite values.
void validate(const Deformation& deformation, const std::string& name, const Mesh& mesh);

/// Returns what is wrong with the keys of a track, as "it has no keys"; empty if they are right. `morphTargets` is the
/// number of morph targets of the mesh that the track's node places.
std::string problemOf(const Track& track, size_t morphTargets);

/// Scene::animation: indices that exist, times that ascend, sizes that fit, finite numbers. Instances and meshes must
/// have been checked.
void validateAnimation(const Scene& scene);

}  // namespace gnosphere
