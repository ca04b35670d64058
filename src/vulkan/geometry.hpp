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
};

class Geometry {
 public:
  Geometry(const Device& device, const Scene& scene);

  const std::vector<GeometryChunk>& chunks() const { return chunks_; }
  size_t clusterCount() const { return flat_.clusters.size() - 1; }
  uint64_t bytes() const;
  /// New places for the vertices of a mesh; the device must not be using it.
  void setPositions(size_t mesh, std::span<const float> positions);
  Instances& instances() { return instances_; }
  const Instances& instances() const { return instances_; }

 private:
  void addChunk(Uploader& uploader, size_t first, size_t end);
  void addInstances(const Scene& scene);
  void summarize(size_t mesh, MeshSummary& summary) const;

  const Device& device_;
  std::vector<GeometryChunk> chunks_;
  std::vector<size_t> chunkFirsts_;  // the first group of each, and the end of the last
  // Without positions and triangles, which the device alone has, and with an empty cluster and group at the end.
  FlatScene flat_;
  Instances instances_;
};

}  // namespace gnosphere::vulkan
