// SPDX-License-Identifier: Apache-2.0
// Scene -> clusters of at most 64 triangles, in groups of at most 64, as the arrays that a device reads.
#pragma once

#include <cstdint>
#include <vector>

#include "gnosphere/scene.hpp"

namespace gnosphere {

/// The clusters of one mesh, and what was left out of it.
struct FlatMesh {
  uint32_t firstGroup = 0;
  uint32_t groupCount = 0;
  uint32_t nonFinite = 0;   ///< triangles with a corner that is NaN, infinite or beyond 1e9 m
  uint32_t degenerate = 0;  ///< triangles with two corners at the same place
};

/// A triangle of a cluster.
struct FlatTriangle {
  uint32_t corners;  ///< vertex numbers within the cluster, 8 bits each, in winding order
  uint32_t index;    ///< within the mesh
};

/// A cluster as it is built; chunks pack it into a gpu::Cluster.
struct FlatCluster {
  float low[3], high[3];  ///< its box
  size_t firstVertex = 0, firstTriangle = 0;
  uint32_t triangleCount = 0;
  bool doubleSided = true;
};

/// A run of clusters that lie together.
struct FlatGroup {
  float low[3], high[3];  ///< its box
  uint32_t firstCluster = 0, clusterCount = 0;
};

/// Arrays of every mesh, each once; instances refer to them. A cluster owns a run of `positions` (3 floats a vertex)
/// and a run of `triangles`.
struct FlatScene {
  std::vector<FlatMesh> meshes;
  std::vector<FlatGroup> groups;
  std::vector<FlatCluster> clusters;
  std::vector<float> positions;
  std::vector<FlatTriangle> triangles;
};

FlatScene flatten(const Scene& scene);

}  // namespace gnosphere
