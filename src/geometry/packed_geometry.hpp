// SPDX-License-Identifier: Apache-2.0
// The flattened meshes as the arrays that a device reads.
#pragma once

#include <span>
#include <vector>

#include "arrays.h"
#include "geometry/flatten.hpp"
#include "geometry/instance_table.hpp"

namespace gnosphere {

/// The arrays of the scene, wherever they lie. Places count bytes.
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

  /// Whole arrays, until dropArrays().
  std::vector<gpu::Group> groups() const;
  std::vector<gpu::Cluster> clusters() const;
  std::span<const float> positions() const { return flat_.positions; }
  std::span<const FlatTriangle> triangleCorners() const { return flat_.triangles; }
  /// What leads from a triangle's owner to the triangle: per mesh, its first entry in triangleSlots(); and per triangle
  /// of a mesh, cluster * kClusterTriangles + its number there.
  std::vector<uint32_t> meshTriangles() const;
  std::vector<uint32_t> triangleSlots() const;
  /// 2 per vertex.
  std::vector<float> textureCoordinates(const Scene& scene) const;
  /// Frees positions and triangles, which the device has by then.
  void dropArrays();

  /// Tells the instances of every mesh, and where the scene places them.
  void addTo(InstanceTable& instances, const Scene& scene) const;
  /// New places for the vertices of a mesh: in the memory, and in the table of instances. `slots`: the memory has
  /// triangleSlots, too.
  void setPositions(size_t mesh, std::span<const float> positions, bool slots, InstanceTable& instances,
                    SceneMemory& memory);

 private:
  void summarize(size_t mesh, MeshSummary& summary) const;
  void findSlots(size_t mesh, std::span<const FlatTriangle> triangles, std::span<uint32_t> slots) const;

  FlatScene flat_;  // with an empty cluster and group at the end
};

}  // namespace gnosphere
