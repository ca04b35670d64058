// SPDX-License-Identifier: Apache-2.0
// The flattened meshes as the arrays that a device reads.
#pragma once

#include <span>
#include <vector>

#include "arrays.h"
#include "geometry/flatten.hpp"
#include "geometry/instance_table.hpp"
#include "geometry/ranges.hpp"

namespace gnosphere {

/// The arrays of the scene, wherever they lie. Places and sizes count bytes.
class SceneMemory {
 public:
  virtual ~SceneMemory() = default;
  /// Makes room for at least `bytes`; what the array holds stays.
  virtual void reserve(gpu::Array array, uint64_t bytes) = 0;
  virtual void write(gpu::Array array, uint64_t place, std::span<const std::byte> data) = 0;
  virtual void read(gpu::Array array, uint64_t place, std::span<std::byte> data) const = 0;
};

/// The meshes share the arrays: each owns a run of every one of them, which it gives back when it is removed.
class PackedGeometry {
 public:
  /// Writes into `memory` and tells `instances` of its meshes; both must outlive it.
  PackedGeometry(SceneMemory& memory, InstanceTable& instances) : memory_(memory), instances_(instances) {}

  /// Adds meshes after those that are there. Throws Error(outOfMemory), and then none is added.
  void add(std::span<const Mesh> meshes, const std::vector<Material>& materials);
  /// Puts a mesh where one was removed.
  void replace(size_t index, const Mesh& mesh, const std::vector<Material>& materials);
  /// No instance may place it.
  void remove(size_t index);
  /// New places for the vertices of a mesh, as many as it has.
  void setPositions(size_t index, std::span<const float> positions);

  /// From now on with the arrays that lead from a triangle's owner to the triangle: meshTriangles and triangleSlots.
  void addSlots();
  /// From now on with the texture coordinates of every vertex.
  void addTextureCoordinates();

  size_t clusterCount() const;
  size_t meshCount() const { return meshes_.size(); }  ///< removed ones, too

 private:
  /// A mesh, and where its runs begin.
  struct Entry {
    FlatMesh flat;  // positions and triangles are only in the memory
    uint64_t group = 0, cluster = 0, vertex = 0, triangle = 0;
    Vec3 origin;
    std::vector<float> uvs;  // 2 per vertex of the Mesh; empty: none
  };

  void place(std::span<Entry> entries);
  void giveBack(const Entry& entry);
  void reserve();
  void write(std::span<Entry> entries);
  void writeMeshTriangles();
  std::vector<uint32_t> slotsOf(const Entry& entry, std::span<const FlatTriangle> triangles) const;
  std::vector<FlatTriangle> trianglesOf(const Entry& entry) const;
  std::vector<gpu::Group> packedGroups(const Entry& entry) const;
  std::vector<gpu::Cluster> packedClusters(const Entry& entry) const;
  std::vector<float> textureCoordinates(const Entry& entry) const;

  SceneMemory& memory_;
  InstanceTable& instances_;
  std::vector<Entry> meshes_;
  Ranges groups_, clusters_, vertices_, triangles_;
  bool slots_ = false, textured_ = false;
};

}  // namespace gnosphere
