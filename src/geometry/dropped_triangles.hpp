// SPDX-License-Identifier: Apache-2.0
// Counts the triangles of a scene that no beam can hit because of where their corners are.
#pragma once

#include <cstdint>
#include <string>

#include "gnosphere/scene.hpp"

namespace gnosphere {

/// Numbers of triangles that a scene places.
struct DroppedTriangles {
  uint64_t nonFinite = 0;   ///< with a corner that is NaN, infinite or beyond 1e9 m in its mesh
  uint64_t degenerate = 0;  ///< others with two equal corners, in meshes that are not deformable
};

DroppedTriangles droppedTriangles(const Scene& scene);
/// Returns a warning of the triangles of a file that are not finite, such as "2 triangles of a.obj are dropped because
/// ...".
std::string droppedText(uint64_t triangles, const std::string& file);

}  // namespace gnosphere
