// SPDX-License-Identifier: Apache-2.0
// The meshes on the device: clusters in chunks, each within the device's buffer limit.
#pragma once

#include <vector>

#include "geometry/chunks.hpp"
#include "vulkan/instances.hpp"

namespace gnosphere::vulkan {

/// A run of clusters with everything they refer to.
struct GeometryChunk {
  Buffer groups;
  Buffer clusters;
  Buffer positions;
  Buffer triangleCorners;
  // Only where surfaces are looked at, see ChunkSurfaces:
  Buffer clusterMaterials;
  Buffer meshPlaces;
  Buffer trianglePlaces;
  Buffer textureCoordinates;
};

class Geometry {
 public:
  /// `surfaces`: with the tables that lead from a triangle's owner to the triangle. `holes`: with those of textures.
  Geometry(const Device& device, const Scene& scene, bool surfaces, bool holes);

  const std::vector<GeometryChunk>& chunks() const { return chunks_; }
  size_t clusterCount() const { return packed_.clusterCount(); }
  uint64_t bytes() const;
  /// New places for the vertices of a mesh; the device must not be using it.
  void setPositions(size_t mesh, std::span<const float> positions);
  Instances& instances() { return instances_; }
  const Instances& instances() const { return instances_; }

 private:
  void addSurfaces(Uploader& uploader, ChunkSurfaces surfaces, GeometryChunk& chunk);

  const Device& device_;
  Chunks packed_;
  std::vector<GeometryChunk> chunks_;
  std::vector<std::vector<uint32_t>> meshPlaces_;  // as each chunk has them
  Instances instances_;
};

}  // namespace gnosphere::vulkan
