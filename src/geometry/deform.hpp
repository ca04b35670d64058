// SPDX-License-Identifier: Apache-2.0
// The maps of joints as the formulas of common/deform.h take them.
#pragma once

#include <array>
#include <vector>

#include "common/types.h"
#include "gnosphere/scene.hpp"

namespace gnosphere {

/// Row-major 3x4 in single precision; takes and gives positions relative to Mesh::origin.
using JointMap = std::array<float, 12>;

/// Returns vertex number `vertex` of an array of x, y, z per vertex.
inline gpu::vec3 vertexAt(const std::vector<float>& values, size_t vertex) {
  return {values[3 * vertex], values[3 * vertex + 1], values[3 * vertex + 2]};
}

/// The maps of a deformation of a mesh with this origin, by joint; none if the deformation is empty.
std::vector<JointMap> jointMapsOf(const Vec3& origin, const Deformation& deformation);

/// A joint that a vertex follows.
struct Influence {
  uint32_t joint = 0;
  float weight = 0;
};

/// The joints that a vertex follows, in ascending order, each once, with weights above 0 that sum to 1 and are
/// multiples of 1 / gpu::kWeightUnits. Every device adds them up in this order. A vertex whose weights do not sum to 1
/// would leave the boxes of its joints.
void influencesOf(const Mesh& mesh, size_t vertex, std::vector<Influence>& influences);

}  // namespace gnosphere
