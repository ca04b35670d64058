// SPDX-License-Identifier: Apache-2.0
// Cuts a scene into clusters of a few triangles, and clusters into groups, as the arrays that a device reads.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/cone.hpp"
#include "gnosphere/scene.hpp"

namespace gnosphere {

/// The clusters of one mesh, and the triangles that were left out of them.
struct FlatMesh {
  uint32_t firstGroup = 0;
  uint32_t groupCount = 0;
  uint32_t nonFinite = 0;   ///< triangles with a corner that is NaN, infinite or beyond 1e9 m
  uint32_t degenerate = 0;  ///< triangles with two corners at the same place
};

/// A cluster as it is built; PackedGeometry packs it into a gpu::Cluster.
struct FlatCluster {
  float low[3], high[3];  ///< box of its usable triangles
  size_t firstVertex = 0, firstTriangle = 0;
  uint32_t triangleCount = 0;  ///< usable triangles; unusable ones may follow them
  bool doubleSided = true;
  uint32_t material = 0;  ///< index into Scene::materials
  Cone cone;
};

/// Consecutive clusters that lie close together.
struct FlatGroup {
  float low[3], high[3];  ///< box of its usable triangles
  uint32_t firstCluster = 0, clusterCount = 0;
};

/// Class of a triangle, which does not depend on the pose.
enum class Fate {
  usable,
  nonFinite,   ///< a corner is NaN, infinite or beyond 1e9 m
  degenerate,  ///< two corners at the same place
};
Fate fateOf(const float* a, const float* b, const float* c);

/// Arrays of every mesh, each stored once; instances refer to them. A cluster owns a run of `positions` (3 floats per
/// vertex) and of `vertices`, and a run of `triangles`: the usable ones, then the unusable ones, which may become
/// usable when vertices move. An empty cluster and an empty group follow the last ones and mark where the arrays end.
struct FlatScene {
  std::vector<FlatMesh> meshes;
  std::vector<FlatGroup> groups;
  std::vector<FlatCluster> clusters;
  std::vector<float> positions;
  std::vector<uint32_t> vertices;  ///< number of each vertex within its mesh
  std::vector<FlatTriangle> triangles;
};

FlatScene flatten(const Scene& scene);

/// Updates the box and the triangles of a cluster after its vertices have moved: usable triangles come first and are
/// counted. `positions` and `triangles` are the cluster's own; `dropped` counts the unusable triangles.
void fit(FlatCluster& cluster, const float* positions, std::span<FlatTriangle> triangles, FlatMesh& dropped);
/// Sets the box of a group to the union of its clusters' boxes.
void fit(FlatGroup& group, std::span<const FlatCluster> clusters);

}  // namespace gnosphere
