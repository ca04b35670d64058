// SPDX-License-Identifier: Apache-2.0
// Splits a mesh into clusters of a few triangles, and these into groups of clusters.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/cone.hpp"
#include "gnosphere/scene.hpp"

namespace gnosphere {

/// A cluster as it is built; PackedGeometry packs it into a gpu::Cluster.
struct FlatCluster {
  float low[3], high[3];  ///< box of its usable triangles
  size_t firstVertex = 0, firstTriangle = 0;
  uint32_t triangleCount = 0;  ///< usable ones; others may follow them
  bool doubleSided = true;
  uint32_t material = 0;  ///< index into Scene::materials
  Cone cone;
};

/// A run of neighbouring clusters.
struct FlatGroup {
  float low[3], high[3];  ///< box of its usable triangles
  uint32_t firstCluster = 0, clusterCount = 0;
};

/// Whether a triangle can be used; independent of the pose.
enum class Fate {
  usable,
  nonFinite,   ///< a corner is NaN, infinite or beyond 1e9 m
  degenerate,  ///< two corners at the same place
};
/// Whether a point can be a corner: no coordinate is NaN, infinite or beyond 1e9 m.
bool inLimits(const float* point);
Fate fateOf(const float* a, const float* b, const float* c);

/// One mesh as clusters in groups. Places count from the mesh's own first entry. A cluster owns a run of `positions` (3
/// floats a vertex) and of `vertices`, and a run of `triangles`: the usable ones, then the others, which may become
/// usable when vertices move. The last cluster and the last group are empty; they mark the ends of the runs.
struct FlatMesh {
  std::vector<FlatGroup> groups;
  std::vector<FlatCluster> clusters;
  std::vector<float> positions;
  std::vector<uint32_t> vertices;  ///< by vertex: index of the vertex in the Mesh from which it was copied
  std::vector<FlatTriangle> triangles;
  uint32_t nonFinite = 0;   ///< triangles with a corner that is NaN, infinite or beyond 1e9 m
  uint32_t degenerate = 0;  ///< triangles with two corners at the same place

  bool deformable = false;

  /// Whether triangles of this fate are usable. In a deformable mesh corners that coincide may part.
  bool keeps(Fate fate) const { return fate == Fate::usable || (fate == Fate::degenerate && deformable); }
  uint32_t groupCount() const { return static_cast<uint32_t>(groups.size()) - 1; }
  uint32_t clusterCount() const { return static_cast<uint32_t>(clusters.size()) - 1; }
};

FlatMesh flatten(const Mesh& mesh, const std::vector<Material>& materials);

/// Updates the box and the triangles of a cluster after its vertices have moved: usable triangles come first and are
/// counted in the cluster, the others in `dropped`. `positions` and `triangles` are those of the cluster alone.
void fit(FlatCluster& cluster, const float* positions, std::span<FlatTriangle> triangles, FlatMesh& dropped);
/// Sets the box of a group to enclose those of its clusters.
void fit(FlatGroup& group, std::span<const FlatCluster> clusters);

}  // namespace gnosphere
