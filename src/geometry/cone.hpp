// SPDX-License-Identifier: Apache-2.0
// Back-face cone of a cluster: the eye positions from which all its triangles are back-facing.
#pragma once

#include <cstdint>
#include <span>

namespace gnosphere {

/// A triangle of a cluster.
struct FlatTriangle {
  uint32_t corners;  ///< vertex numbers within the cluster, 8 bits each, in winding order
  uint32_t index;    ///< number of the triangle within the mesh
};

/// Let c and r be the middle and half diagonal of the cluster's box, and o the eye, in the mesh frame: every triangle
/// is back-facing if dot(c - o, axis) >= sine * |c - o| + r. (This is the normal cone of meshoptimizer.)
struct Cone {
  float axis[3] = {0, 0, 1};  ///< unit vector about which the triangles' normals lie
  float sine = 1;      ///< of the widest angle between a normal and the axis; 1 if no eye position sees only back faces
  float thinness = 0;  ///< 1 / smallest height of a triangle: how far rounding of a corner can tilt it, per distance
};

Cone coneOf(const float* positions, std::span<const FlatTriangle> triangles);

}  // namespace gnosphere
