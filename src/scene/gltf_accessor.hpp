// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>

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
  /// VEC2 likewise.
  std::vector<float> uvs(int accessor, const std::string& user);
  /// SCALAR of unsigned integers, appended.
  void appendIndices(int accessor, const std::string& user, std::vector<uint32_t>& indices);
  /// Instance attributes: `components` doubles per element.
  std::vector<double> vectors(int accessor, int components, const std::string& user);
  /// Bytes of a bufferView, decompressed where it is EXT_meshopt_compression's.
  Bytes view(int bufferView, const std::string& user);

  /// The whole of a data URI or of a file beside this one. Throws Error(file) where there is none.
  FileBytes uriBytes(const std::string& uri, const std::string& user);

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
  /// Elements of `components` floats; `what` they are, for messages.
  std::vector<float> floats(int accessor, size_t components, const char* what, const std::string& user);
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
  std::vector<float> uvs;  ///< empty: not asked for
  std::vector<uint32_t> indices;
};
/// The ids are those of Draco's attributes; `uvId` is negative where no texture coordinates are wanted.
DracoMesh decodeDraco(Bytes bytes, int positionId, int uvId, const std::string& user, const Source& source);

/// How a material lays its alpha image over a mesh: u v of TEXCOORD_n through KHR_texture_transform's 2x3 matrix, in
/// rows.
struct GltfTexture {
  int texCoord = 0;
  std::array<double, 6> transform = {1, 0, 0, 0, 1, 0};
};
/// One per material of the file, none where it has no alpha image. Fills the scene's alpha images.
std::vector<std::optional<GltfTexture>> readGltfImages(const GltfFile& file, GltfArrays& arrays, const Source& source,
                                                       Scene& scene);

/// The meshes that are used, in the order of the file. Adds glTF's default material if a primitive has none.
std::vector<Mesh> readGltfMeshes(const tinygltf::Model& model, GltfArrays& arrays, const Source& source,
                                 const std::vector<bool>& isUsed,
                                 const std::vector<std::optional<GltfTexture>>& textures,
                                 std::vector<Material>& materials);

/// "mesh 3 'wall'", for messages.
std::string gltfLabel(const char* what, size_t index, const std::string& name);

}  // namespace gnosphere
