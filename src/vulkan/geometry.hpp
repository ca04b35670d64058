// SPDX-License-Identifier: Apache-2.0
// The meshes on the device: clusters in chunks, each within the device's buffer limit.
#pragma once

#include <vector>

#include "flatten.hpp"
#include "vulkan/instances.hpp"

namespace gnosphere::vulkan {

/// A run of clusters with everything they refer to.
struct GeometryChunk {
  Buffer groups;
  Buffer clusters;
  Buffer positions;
  Buffer triangleCorners;
  // Only where surfaces are looked at:
  Buffer clusterMaterials;
  Buffer meshPlaces;      ///< per mesh of the scene: its first entry in trianglePlaces, kNone if it is in another chunk
  Buffer trianglePlaces;  ///< per triangle of a mesh: cluster * kClusterTriangles + its place there; kNone: elsewhere
};

class Geometry {
 public:
  /// `surfaces`: with the tables that lead from a triangle's owner to the triangle.
  Geometry(const Device& device, const Scene& scene, bool surfaces);

  const std::vector<GeometryChunk>& chunks() const { return chunks_; }
  size_t clusterCount() const { return flat_.clusters.size() - 1; }
  uint64_t bytes() const;
  /// New places for the vertices of a mesh; the device must not be using it.
  void setPositions(size_t mesh, std::span<const float> positions);
  Instances& instances() { return instances_; }
  const Instances& instances() const { return instances_; }

 private:
  void addChunk(Uploader& uploader, size_t first, size_t end);
  void addSurfaces(Uploader& uploader, const Scene& scene, size_t chunk);
  void addInstances(const Scene& scene);
  void summarize(size_t mesh, MeshSummary& summary) const;

  const Device& device_;
  std::vector<GeometryChunk> chunks_;
  std::vector<size_t> chunkFirsts_;                // the first group of each, and the end of the last
  std::vector<std::vector<uint32_t>> meshPlaces_;  // as each chunk has them
  // Without positions and triangles, which the device alone has, and with an empty cluster and group at the end.
  FlatScene flat_;
  Instances instances_;
};

}  // namespace gnosphere::vulkan
