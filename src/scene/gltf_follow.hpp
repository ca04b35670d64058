// SPDX-License-Identifier: Apache-2.0
// The joints and morph targets that the vertices of a glTF primitive follow.
#pragma once

#include "scene/gltf_accessor.hpp"

namespace gnosphere {

/// The accessors of the joints, weights and morph targets of a primitive.
struct GltfFollow {
  std::vector<int> joints, weights;  ///< by set
  std::vector<int> targets;          ///< by morph target; -1: it moves no vertex
  auto operator<=>(const GltfFollow&) const = default;
};

class GltfFollowReader {
 public:
  GltfFollowReader(GltfArrays& arrays, const Source& source, LeftOut& leftOut)
      : arrays_(arrays), source_(source), leftOut_(leftOut) {}

  /// Without `skinned`, joints are not read.
  GltfFollow follow(const tinygltf::Primitive& primitive, bool skinned, const std::string& who);
  /// Adds the ids of the attributes of joints and weights in Draco data; none if the data has no joints.
  void addDracoIds(const tinygltf::Value& attributes, const GltfFollow& follow, const std::string& who,
                   DracoIds& ids) const;
  /// Appends joints, weights and offsets for the last vertices of the mesh, whose influences and morph targets have
  /// been set: those of the vertices `used` of the accessors, or of all `count` if it is null; `draco` may be null.
  void append(Mesh& mesh, const GltfFollow& follow, const DracoMesh* draco, const std::vector<uint32_t>* used,
              size_t count, const std::string& who);

 private:
  const std::vector<float>& values(int accessor, size_t components, const char* what, size_t count,
                                   const std::string& who);
  void appendSet(Mesh& mesh, size_t set, const std::vector<float>& joints, const std::vector<float>& weights,
                 const std::vector<uint32_t>* used, size_t first, const std::string& who) const;
  void normalizeWeights(Mesh& mesh, size_t first);

  GltfArrays& arrays_;
  const Source& source_;
  LeftOut& leftOut_;
};

}  // namespace gnosphere
