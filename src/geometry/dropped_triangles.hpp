// SPDX-License-Identifier: Apache-2.0
// Triangles of a scene that no beam can meet, because they are nowhere.
#pragma once

#include <cstdint>
#include <string>

#include "gnosphere/scene.hpp"

namespace gnosphere {

/// Triangles that a scene places.
struct DroppedTriangles {
  uint64_t nonFinite = 0;   ///< those with a corner that is NaN, infinite or beyond 1e9 m in its mesh
  uint64_t degenerate = 0;  ///< others of which two corners are equal
};

DroppedTriangles droppedTriangles(const Scene& scene);
/// Returns a warning of the triangles of a file that are not finite, such as "2 triangles of a.obj are dropped because
/// ...".
std::string droppedText(uint64_t triangles, const std::string& file);

}  // namespace gnosphere
