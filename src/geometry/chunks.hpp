// SPDX-License-Identifier: Apache-2.0
// The flattened meshes as a device reads them: clusters in chunks, each within the device's buffer limit.
#pragma once

#include <functional>
#include <vector>

#include "geometry/flatten.hpp"
#include "geometry/instance_table.hpp"

namespace gnosphere {

/// A run of groups with everything they refer to, or a part of such a run.
struct ChunkArrays {
  std::vector<gpu::Group> groups;
  std::vector<gpu::Cluster> clusters;
  std::vector<float> positions;
  std::vector<FlatTriangle> triangleCorners;
};

/// What leads from a triangle's owner to the triangle.
struct ChunkSurfaces {
  std::vector<uint32_t> clusterMaterials;
  std::vector<uint32_t> meshPlaces;      ///< per mesh of the scene: its first entry in trianglePlaces, kNone: elsewhere
  std::vector<uint32_t> trianglePlaces;  ///< per triangle of a mesh: cluster * kClusterTriangles + its place there
  std::vector<float> textureCoordinates;  ///< 2 per vertex of the chunk; only with holes
};

/// Where in the arrays of a chunk a part lies: first elements (of positions: first vertices).
struct ChunkPart {
  size_t chunk, group, cluster, vertex, triangle;
};

class Chunks {
 public:
  /// Throws Error(outOfMemory) where no chunk fits into arrays of `maxBytes` each.
  Chunks(const Scene& scene, uint64_t maxBytes);

  size_t count() const { return firsts_.size() - 1; }
  size_t clusterCount() const { return flat_.clusters.size() - 1; }
  /// Until dropArrays().
  ChunkArrays arrays(size_t chunk) const;
  ChunkSurfaces surfaces(size_t chunk, const Scene& scene, bool holes) const;
  /// The entries of `places`, those of one mesh in trianglePlaces, for the triangles of a part of it.
  void placeTriangles(const ChunkPart& part, std::span<const FlatTriangle> triangles, std::span<uint32_t> places) const;
  /// The device has positions and triangles.
  void dropArrays();

  /// Tells the instances of every mesh, and where the scene places them.
  void addTo(InstanceTable& instances, const Scene& scene) const;
  /// New places for the vertices of a mesh: `read` gives triangles of a part as the device has them, `write` gets what
  /// the part becomes. The instances are told.
  void setPositions(size_t mesh, std::span<const float> positions, InstanceTable& instances,
                    const std::function<std::vector<FlatTriangle>(const ChunkPart& part, size_t count)>& read,
                    const std::function<void(const ChunkPart& part, const ChunkArrays& arrays)>& write);

 private:
  void summarize(size_t mesh, MeshSummary& summary) const;

  std::vector<size_t> firsts_;  // the first group of each chunk, and the end of the last
  FlatScene flat_;              // with an empty cluster and group at the end
};

}  // namespace gnosphere
