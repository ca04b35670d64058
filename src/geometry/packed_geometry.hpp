// SPDX-License-Identifier: Apache-2.0
// The flattened meshes in the arrays that a device reads.
#pragma once

#include <span>
#include <vector>

#include "geometry/deformables.hpp"
#include "geometry/flatten.hpp"
#include "geometry/instance_table.hpp"
#include "geometry/ranges.hpp"
#include "geometry/scene_memory.hpp"
#include "geometry/vertex_sources.hpp"

namespace gnosphere {

/// All meshes share the arrays. A mesh owns a run of entries in each array and gives it back when it is removed.
class PackedGeometry {
 public:
  /// Writes into `memory` and adds the meshes to `instances`; both must outlive this object.
  PackedGeometry(SceneMemory& memory, InstanceTable& instances)
      : memory_(memory), instances_(instances), deformables_(memory), vertexSources_(memory) {}

  /// Adds meshes after the existing ones. If it throws, none is added; the same holds for the other changes.
  void add(std::span<const Mesh> meshes, const std::vector<Material>& materials);
  /// Adds a mesh at the index of a removed one.
  void replace(size_t index, const Mesh& mesh, const std::vector<Material>& materials);
  /// Removes a mesh; no instance may place it.
  void remove(size_t index);
  /// Moves all vertices of a mesh; `positions` has 3 values per vertex.
  void setPositions(size_t index, std::span<const float> positions);
  /// Deforms a mesh that is deformable.
  void setDeformation(size_t index, const Deformation& deformation);
  /// From now on a device takes the vertices of a mesh, which is not deformable, from a buffer, until setPositions().
  void setVertices(size_t index, const CallerVertices& vertices);
  VertexSources& vertexSources() { return vertexSources_; }  ///< the meshes of setVertices()

  /// From now on also keeps meshTriangles and triangleSlots, by which a triangle is found from its mesh and index.
  void addSlots();
  /// From now on also keeps the texture coordinates of every vertex.
  void addTextureCoordinates();

  const Deformables& deformables() const { return deformables_; }
  size_t clusterCount() const;
  size_t meshCount() const { return meshes_.size(); }  ///< including removed meshes

 private:
  /// A mesh, and the first entries of its runs.
  struct Entry {
    FlatMesh flat;  // without positions and triangles, which only the memory has
    uint64_t group = 0, cluster = 0, vertex = 0, triangle = 0;
    Vec3 origin;
    std::vector<float> uvs;  // 2 per vertex of the Mesh; empty if it has none
  };

  void place(size_t first, std::span<const Mesh> meshes, std::span<Entry> entries);
  void giveBack(const Entry& entry) noexcept;
  void reserve();
  void write(std::span<Entry> entries);
  void releaseVertices(size_t index);
  void writeMeshTriangles(size_t first, std::span<const Entry> entries);
  std::vector<uint32_t> slotsOf(const Entry& entry, std::span<const FlatTriangle> triangles) const;
  std::vector<FlatTriangle> trianglesOf(const Entry& entry) const;
  std::vector<gpu::Group> packedGroups(const Entry& entry) const;
  static void pack(const Entry& entry, std::span<gpu::Group> to);
  std::vector<gpu::Cluster> packedClusters(const Entry& entry, std::span<const FlatCluster> clusters) const;
  std::vector<float> textureCoordinates(const Entry& entry) const;

  SceneMemory& memory_;
  InstanceTable& instances_;
  Deformables deformables_;
  VertexSources vertexSources_;
  std::vector<Entry> meshes_;
  Ranges groups_, clusters_, vertices_, triangles_;
  bool slots_ = false, textured_ = false;
};

}  // namespace gnosphere
