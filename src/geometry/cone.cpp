// SPDX-License-Identifier: Apache-2.0
#include "geometry/cone.hpp"

#include <meshoptimizer.h>

#include <algorithm>
#include <glm/glm.hpp>
#include <vector>

#include "common/shared.h"

namespace gnosphere {
namespace {

// Height over the longest edge; 0 for slivers that have no area in single precision.
float smallestHeight(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
  const float longest = std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
  return longest > 0 ? glm::length(glm::cross(b - a, c - a)) / longest : 0;
}

}  // namespace

Cone coneOf(const float* positions, std::span<const FlatTriangle> triangles) {
  std::vector<uint32_t> corners;
  uint32_t vertexCount = 0;
  float height = gpu::kCoordinateLimit;
  for (const FlatTriangle& triangle : triangles) {
    glm::vec3 points[3];
    for (int k = 0; k < 3; ++k) {
      const uint32_t vertex = triangle.corners >> (8 * k) & 0xff;
      corners.push_back(vertex);
      vertexCount = std::max(vertexCount, vertex + 1);
      points[k] = {positions[3 * vertex], positions[3 * vertex + 1], positions[3 * vertex + 2]};
    }
    height = std::min(height, smallestHeight(points[0], points[1], points[2]));
  }
  Cone cone;
  if (corners.empty() || !(height > 0)) return cone;
  const meshopt_Bounds bounds =
      meshopt_computeClusterBounds(corners.data(), corners.size(), positions, vertexCount, 3 * sizeof(float));
  std::copy_n(bounds.cone_axis, 3, cone.axis);
  cone.sine = bounds.cone_cutoff;
  cone.thinness = 1 / height;
  return cone;
}

}  // namespace gnosphere
