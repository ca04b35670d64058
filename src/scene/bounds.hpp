// SPDX-License-Identifier: Apache-2.0
// Boxes around meshes, which tell without a look at the vertices where an instance cannot be.
#pragma once

#include <vector>

#include "gnosphere/scene.hpp"

namespace gnosphere {

/// Returns the box, in the frame of the mesh, around the finite vertices that triangles use, deformed as the mesh is.
Bounds meshBounds(const Mesh& mesh);

/// Returns the box of each instance around the finite vertices that its triangles use, in world coordinates. The time
/// is that of all vertices of all instances.
std::vector<Bounds> instanceBounds(const Scene& scene);

/// Returns a box that contains `transform * p` for every point `p` of a box that is not empty. Additions and
/// multiplications round monotonically, and the box is computed as a point is, so it contains the rounded results, too.
Bounds operator*(const Transform& transform, const Bounds& bounds);

}  // namespace gnosphere
