// SPDX-License-Identifier: Apache-2.0
// Bounding boxes of meshes and instances.
#pragma once

#include <vector>

#include "gnosphere/scene.hpp"

namespace gnosphere {

/// Returns the box, in the frame of the mesh, around the finite vertices that triangles use, deformed as the mesh is.
Bounds meshBounds(const Mesh& mesh);

/// Returns the box of each instance around the finite vertices that its triangles use, in world coordinates. The time
/// grows with the number of vertices of all instances.
std::vector<Bounds> instanceBounds(const Scene& scene);

/// Returns a box that contains `transform * p` for every point `p` of a box that is not empty. Additions and
/// multiplications round monotonically, and the box is computed as a point is, so it contains the rounded results, too.
Bounds operator*(const Transform& transform, const Bounds& bounds);

}  // namespace gnosphere
