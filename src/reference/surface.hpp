// SPDX-License-Identifier: Apache-2.0
// What a triangle is made of where a beam meets it.
#pragma once

#include "gnosphere/scene.hpp"
#include "reference/hit.hpp"

namespace gnosphere::reference {

/// Weights of a triangle's corners at a point, in the order of Triangle::corners.
using Weights = std::array<double, 3>;

/// Index into Scene::materials.
uint32_t materialOf(const Scene& scene, const Triangle& triangle);
/// Weights of the second and third corner, as the mesh has them.
std::array<double, 2> barycentricsOf(const Triangle& triangle, const Weights& weights);
/// Unit, on the side of a beam with that direction, all in one frame; 0 for a triangle without area.
Vec3 normalAgainst(const Vec3& direction, const Vec3 (&corners)[3]);

/// The texture has a hole there: alpha below the material's cut-off (glTF 2.0, 3.9.4), at the nearest pixel.
bool isHole(const Scene& scene, const Triangle& triangle, const Weights& weights);
/// Single precision may see it otherwise: there is an edge of a hole within 1e-4 of the triangle.
bool isHoleInDoubt(const Scene& scene, const Triangle& triangle, const Weights& weights);

}  // namespace gnosphere::reference
