// SPDX-License-Identifier: Apache-2.0
#include "geometry/dropped_triangles.hpp"

#include <vector>

#include "geometry/flatten.hpp"

namespace gnosphere {

DroppedTriangles droppedTriangles(const Scene& scene) {
  std::vector<DroppedTriangles> dropped;  // by mesh
  for (const Mesh& mesh : scene.meshes) {
    const auto corner = [&](size_t i) { return mesh.positions.data() + 3 * size_t{mesh.indices[i]}; };
    DroppedTriangles& counts = dropped.emplace_back();
    for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
      const Fate fate = fateOf(corner(i), corner(i + 1), corner(i + 2));
      counts.nonFinite += fate == Fate::nonFinite;
      counts.degenerate += fate == Fate::degenerate && !mesh.deformable();
    }
  }
  DroppedTriangles sum;
  for (const Instance& instance : scene.instances) {
    sum.nonFinite += dropped[instance.mesh].nonFinite;
    sum.degenerate += dropped[instance.mesh].degenerate;
  }
  return sum;
}

std::string droppedText(uint64_t triangles, const std::string& file) {
  return std::to_string(triangles) + (triangles == 1 ? " triangle of " : " triangles of ") + file +
         (triangles == 1 ? " is" : " are") +
         " dropped because a corner is NaN, infinite or beyond 1e9 m or units of the file";
}

}  // namespace gnosphere
