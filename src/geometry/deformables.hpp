// SPDX-License-Identifier: Apache-2.0
// The deformable meshes of a scene, in the arrays from which a device computes where their vertices are.
#pragma once

#include <array>
#include <map>
#include <span>
#include <vector>

#include "common/shared.h"
#include "geometry/flatten.hpp"
#include "geometry/ranges.hpp"
#include "geometry/scene_memory.hpp"

namespace gnosphere {

/// Encloses the vertices that follow a joint, where they are at rest.
struct JointBox {
  uint32_t joint;  ///< gpu::kNone: the mesh has no joints
  gpu::vec3 low, high;
};

class Deformables {
 public:
  explicit Deformables(SceneMemory& memory) : memory_(memory) {}

  /// Adds the mesh at an index, in its first deformation. `vertex` and `cluster` are its first entries in the arrays of
  /// all meshes. If it throws Error(outOfMemory), the mesh is not added.
  void add(size_t index, const Mesh& mesh, const FlatMesh& flat, uint64_t vertex, uint64_t cluster);
  void remove(size_t index) noexcept;
  /// Sets the number of meshes of the scene. A removed instance has the index after the last mesh.
  void setMeshCount(size_t count);
  /// Deforms a mesh, and sets the boxes of its groups.
  void deform(size_t index, const Deformation& deformation, FlatMesh& flat);

  /// Where joints and morph weights are at the end of a motion; entries have the places of jointRows() and
  /// morphWeights().
  struct End {
    std::vector<gpu::vec4> jointRows;
    std::vector<float> morphWeights;
  };
  /// Writes the end of a mesh's motion and returns the largest distance in metres, in the mesh frame, that it moves a
  /// vertex.
  double writeEnd(size_t index, const Deformation& deformation, End& to) const;

  bool any() const { return !meshes_.empty(); }

  /// Data that a scan reads: an entry per mesh of the scene and one more, three rows per joint, and the morph weights.
  uint64_t version() const { return version_; }  ///< goes up when one of the following changes
  std::span<const gpu::Deformer> deformers() const { return deformers_; }
  std::span<const gpu::vec4> jointRows() const { return jointRows_; }
  std::span<const float> morphWeights() const { return morphWeights_; }

 private:
  struct Entry {
    Vec3 origin;
    uint64_t vertices = 0, clusters = 0, bones = 0, firstBone = 0, weights = 0, firstWeight = 0;
    std::vector<std::vector<JointBox>> groups;           // by group
    std::vector<std::array<gpu::vec3, 2>> offsetBounds;  // by morph target: least and largest offset
    std::vector<FlatGroup> restGroups;
  };

  void reserve();
  static void writeMaps(const Entry& entry, const gpu::Deformer& deformer, const Deformation& deformation,
                        std::vector<gpu::vec4>& rows, std::vector<float>& weights);

  SceneMemory& memory_;
  std::map<size_t, Entry> meshes_;  // by index
  Ranges vertices_, offsets_, clusterBones_, bones_, boneWeights_, rows_, weights_;
  uint64_t version_ = 0;
  std::vector<gpu::Deformer> deformers_;
  std::vector<gpu::vec4> jointRows_;
  std::vector<float> morphWeights_;
};

}  // namespace gnosphere
