// SPDX-License-Identifier: Apache-2.0
// Properties of a triangle at the point where a beam hits it.
#pragma once

#include "gnosphere/scene.hpp"
#include "reference/hit.hpp"

namespace gnosphere::reference {

/// Barycentric coordinates of a point, in the order of Triangle::corners.
using Weights = std::array<double, 3>;

/// Returns an index into Scene::materials.
uint32_t materialOf(const Scene& scene, const Triangle& triangle);
/// Returns the weights of the second and third corner, in the mesh's order.
std::array<double, 2> barycentricsOf(const Triangle& triangle, const Weights& weights);
/// Returns the unit normal that points towards the origin of the corners' frame, or 0 for a triangle without area.
Vec3 normalTowardsOrigin(const Vec3 (&corners)[3]);

/// Returns whether the texture has a hole there: alpha of the nearest pixel is below the material's cut-off (glTF 2.0,
/// 3.9.4).
bool isHole(const Scene& scene, const Triangle& triangle, const Weights& weights);
/// Returns whether single precision may decide otherwise: the edge of a hole lies within 1e-4 of the triangle.
bool isHoleInDoubt(const Scene& scene, const Triangle& triangle, const Weights& weights);

}  // namespace gnosphere::reference
