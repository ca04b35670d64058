// SPDX-License-Identifier: Apache-2.0
// Tells which vertices of a mesh belong to a surface.
#pragma once

#include <vector>

#include "gnosphere/scene.hpp"

namespace gnosphere {

/// Returns by vertex whether a triangle of the mesh uses it. Files may have vertices that no triangle uses, and these
/// are part of no surface.
std::vector<bool> usedVertices(const Mesh& mesh);

}  // namespace gnosphere
