// SPDX-License-Identifier: Apache-2.0
// From where does a whole cluster show its back?
#pragma once

#include <cstdint>
#include <span>

namespace gnosphere {

/// A triangle of a cluster.
struct FlatTriangle {
  uint32_t corners;  ///< vertex numbers within the cluster, 8 bits each, in winding order
  uint32_t index;    ///< within the mesh
};

/// With c and r the middle and half diagonal of the cluster's box, and o the eye, in the mesh frame: every triangle
/// shows its back if dot(c - o, axis) >= sine * |c - o| + r. (The sphere of a cone of normals, as in meshoptimizer.)
struct Cone {
  float axis[3] = {0, 0, 1};  ///< unit vector about which the triangles' normals lie
  float sine = 1;             ///< of the widest angle between a normal and the axis; 1 where there is no such eye
  float thinness = 0;         ///< 1 / smallest height of a triangle: what a rounded corner tilts it by, per distance
};

Cone coneOf(const float* positions, std::span<const FlatTriangle> triangles);

}  // namespace gnosphere
