// SPDX-License-Identifier: Apache-2.0
// The flattened meshes as the arrays that a device reads.
#pragma once

#include <span>
#include <vector>

#include "arrays.h"
#include "geometry/flatten.hpp"
#include "geometry/instance_table.hpp"

namespace gnosphere {

/// The memory that holds the scene's arrays, on whichever device. Places count bytes.
class SceneMemory {
 public:
  virtual ~SceneMemory() = default;
  virtual void write(gpu::Array array, uint64_t place, std::span<const std::byte> data) = 0;
  virtual void read(gpu::Array array, uint64_t place, std::span<std::byte> data) const = 0;
};

class PackedGeometry {
 public:
  explicit PackedGeometry(const Scene& scene) : flat_(flatten(scene)) {}

  size_t clusterCount() const { return flat_.clusters.size() - 1; }

  /// The whole arrays. They exist until dropArrays().
  std::vector<gpu::Group> groups() const;
  std::vector<gpu::Cluster> clusters() const;
  std::span<const float> positions() const { return flat_.positions; }
  std::span<const FlatTriangle> triangleCorners() const { return flat_.triangles; }
  /// Tables from (mesh, triangle number) to the stored triangle. meshTriangles(): per mesh, its first entry in
  /// triangleSlots(). triangleSlots(): per triangle of a mesh, cluster * kClusterTriangles + its number in the cluster.
  std::vector<uint32_t> meshTriangles() const;
  std::vector<uint32_t> triangleSlots() const;
  /// Two floats per vertex.
  std::vector<float> textureCoordinates(const Scene& scene) const;
  /// Frees positions and triangles once the device has them.
  void dropArrays();

  /// Adds every mesh and every instance of the scene to the table of instances.
  void addTo(InstanceTable& instances, const Scene& scene) const;
  /// Moves the vertices of a mesh: updates the device memory and the table of instances. `slots` tells whether the
  /// memory has triangleSlots.
  void setPositions(size_t mesh, std::span<const float> positions, bool slots, InstanceTable& instances,
                    SceneMemory& memory);

 private:
  void summarize(size_t mesh, MeshSummary& summary) const;
  void findSlots(size_t mesh, std::span<const FlatTriangle> triangles, std::span<uint32_t> slots) const;

  FlatScene flat_;  // ends with an empty cluster and an empty group
};

}  // namespace gnosphere
