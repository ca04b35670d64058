// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "gnosphere/scene.hpp"

namespace gnosphere {

/// Appends the materials, alpha images and meshes of `other`, which refer to each other as before. Returns the index of
/// the first of these meshes.
uint32_t appendMeshes(Scene& scene, const Scene& other);

}  // namespace gnosphere
