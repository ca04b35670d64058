// SPDX-License-Identifier: Apache-2.0
// The scene on the device: clusters in chunks, each within the device's buffer limit, and the placements.
#pragma once

#include <vector>

#include "flatten.hpp"
#include "gnosphere/scan.hpp"
#include "shared.h"
#include "vulkan/buffer.hpp"

namespace gnosphere::vulkan {

/// A run of clusters with everything they refer to, and where they are placed.
struct GeometryChunk {
  Buffer placed;  ///< (instance, group) pairs
  Buffer groups;
  Buffer clusters;
  Buffer positions;
  Buffer triangleCorners;
  uint32_t placedGroups = 0;
  uint32_t placedClusters = 0;
};

class Geometry {
 public:
  Geometry(const Device& device, const Scene& scene);

  const std::vector<GeometryChunk>& chunks() const { return chunks_; }
  size_t clusterCount() const { return clusterCount_; }
  /// Most (instance, group) pairs, and most placed clusters, of any chunk.
  uint32_t maxPlacedGroups() const;
  uint32_t maxPlacedClusters() const;
  uint64_t bytes() const;
  uint32_t instanceCount() const { return static_cast<uint32_t>(instances_.size()); }
  /// Triangles placed, and dropped while flattening.
  const Counters& dropped() const { return dropped_; }
  /// Writes every instance's transform to the sensor's frame, composed in double.
  void placeInstances(const Pose& pose, gpu::Instance* out) const;

 private:
  void addPlacements(const Scene& scene, const FlatScene& flat);
  void addChunk(Uploader& uploader, const Scene& scene, const FlatScene& flat, size_t first, size_t end);

  struct Placement {
    Transform transform;  ///< of the mesh's positions, its origin included
    uint32_t firstTriangle;
    bool mirrored;
  };

  std::vector<GeometryChunk> chunks_;
  std::vector<Placement> instances_;
  size_t clusterCount_ = 0;
  Counters dropped_;
};

}  // namespace gnosphere::vulkan
