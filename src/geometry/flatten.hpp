// SPDX-License-Identifier: Apache-2.0
// Scene -> clusters of a few triangles, in groups, as the arrays that a device reads.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/cone.hpp"
#include "gnosphere/scene.hpp"

namespace gnosphere {

/// The clusters of one mesh, and what was left out of it.
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
  uint32_t triangleCount = 0;  ///< usable ones; others may follow them
  bool doubleSided = true;
  uint32_t material = 0;  ///< index into Scene::materials
  Cone cone;
};

/// A run of clusters that lie together.
struct FlatGroup {
  float low[3], high[3];  ///< box of its usable triangles
  uint32_t firstCluster = 0, clusterCount = 0;
};

/// What becomes of a triangle before there is a pose.
enum class Fate {
  usable,
  nonFinite,   ///< a corner is NaN, infinite or beyond 1e9 m
  degenerate,  ///< two corners at the same place
};
Fate fateOf(const float* a, const float* b, const float* c);

/// Arrays of every mesh, each once; instances refer to them. A cluster owns a run of `positions` (3 floats a vertex)
/// and of `vertices`, and a run of `triangles`: the usable ones, then those that are not, which may become so when
/// vertices move. After the last cluster and the last group comes an empty one, where the next would begin.
struct FlatScene {
  std::vector<FlatMesh> meshes;
  std::vector<FlatGroup> groups;
  std::vector<FlatCluster> clusters;
  std::vector<float> positions;
  std::vector<uint32_t> vertices;  ///< which of its mesh each is
  std::vector<FlatTriangle> triangles;
};

FlatScene flatten(const Scene& scene);

/// The box and the triangles of a cluster after its vertices have moved: usable ones first, counted. `positions` and
/// `triangles` are the cluster's own, `dropped` counts the others.
void fit(FlatCluster& cluster, const float* positions, std::span<FlatTriangle> triangles, FlatMesh& dropped);
/// The box of a group around those of its clusters.
void fit(FlatGroup& group, std::span<const FlatCluster> clusters);

}  // namespace gnosphere
