// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>

#include "scene/gltf_file.hpp"

namespace gnosphere {

/// The arrays of a glTF file: accessors over bufferViews over buffers, checked before every use. `user` is who asks
/// ("mesh 3 'wall'"), and what messages name.
class GltfArrays {
 public:
  GltfArrays(GltfFile& file, Bytes bytes, const Source& source);

  /// Elements of an accessor; throws unless all of them lie inside its bufferView.
  size_t count(int accessor, const std::string& user);
  /// VEC3 of any component type; normalised integers become -1..1 or 0..1.
  std::vector<float> positions(int accessor, const std::string& user);
  /// SCALAR of unsigned integers, appended.
  void appendIndices(int accessor, const std::string& user, std::vector<uint32_t>& indices);
  /// Instance attributes: `components` doubles per element.
  std::vector<double> vectors(int accessor, int components, const std::string& user);
  /// Bytes of a bufferView, decompressed where it is EXT_meshopt_compression's.
  Bytes view(int bufferView, const std::string& user);

  /// Accounts for bytes that the file makes us allocate. A few kilobytes of compressed, sparse or shared data can ask
  /// for terabytes: beyond 256 MiB + 256 times the size of the file it is an error.
  void charge(uint64_t count, uint64_t bytesEach, const std::string& user);

 private:
  /// Where the elements of an accessor are. `first` is null where all are zero (no bufferView).
  struct Layout {
    const uint8_t* first = nullptr;
    size_t stride = 0;
    size_t count = 0;
    size_t components = 0;
    int componentType = 0;
    bool normalized = false;
  };

  Layout layout(int accessor, const std::string& user);
  const uint8_t* elements(int bufferView, size_t byteOffset, size_t count, size_t size, size_t stride,
                          const std::string& user);
  Bytes bufferRange(int buffer, size_t byteOffset, size_t byteLength, const std::string& user);
  void load(GltfBuffer& buffer, const std::string& user);
  Bytes decompress(int bufferView, const tinygltf::Value& extension, const std::string& user);
  /// Calls set(element, component, value) for every component, sparse ones included.
  template <typename Set>
  void forEachValue(int accessor, const Layout& layout, const std::string& user, Set&& set);

  GltfFile& file_;
  const Source& source_;
  std::map<int, FileBytes> decompressed_;  ///< by bufferView
  uint64_t inputBytes_;
  uint64_t charged_ = 0;
};

/// One primitive of KHR_draco_mesh_compression.
struct DracoMesh {
  std::vector<float> positions;
  std::vector<uint32_t> indices;
};
DracoMesh decodeDraco(Bytes bytes, int positionId, const std::string& user, const Source& source);

/// The meshes that are used, in the order of the file. Adds glTF's default material if a primitive has none.
std::vector<Mesh> readGltfMeshes(const tinygltf::Model& model, GltfArrays& arrays, const Source& source,
                                 const std::vector<bool>& isUsed, std::vector<Material>& materials);

/// "mesh 3 'wall'", for messages.
std::string gltfLabel(const char* what, size_t index, const std::string& name);

}  // namespace gnosphere
