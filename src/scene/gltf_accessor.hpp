// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>

#include "scene/gltf_file.hpp"

namespace gnosphere {

/// The arrays of a glTF file: accessors into bufferViews into buffers, checked before every use. `user` is the object
/// that needs the array ("mesh 3 'wall'"); messages name it.
class GltfArrays {
 public:
  GltfArrays(GltfFile& file, Bytes bytes, const Source& source);

  /// Number of elements of an accessor. Throws unless all of them lie inside its bufferView.
  size_t count(int accessor, const std::string& user);
  /// Reads vectors of any component type; normalised integers become -1..1 or 0..1. `what` names them in messages.
  std::vector<float> floats(int accessor, size_t components, const char* what, const std::string& user);
  /// Returns the same numbers, which are read once and kept by this object.
  const std::vector<float>& keptFloats(int accessor, size_t components, const char* what, const std::string& user);
  /// Reads SCALAR of unsigned integers and appends them to `indices`.
  void appendIndices(int accessor, const std::string& user, std::vector<uint32_t>& indices);
  /// Reads attributes of instances, keys and matrices: `components` doubles per element.
  std::vector<double> vectors(int accessor, int components, const std::string& user);
  /// Bytes of a bufferView, decompressed if it uses EXT_meshopt_compression.
  Bytes view(int bufferView, const std::string& user);

  /// Returns the bytes of a data URI, which are in `decoded` then, or those of a file beside the glTF file, which is
  /// read once and kept by this object. Throws Error(file) if the file does not exist.
  Bytes uriBytes(const std::string& uri, const std::string& user, FileBytes& decoded);

  /// Counts bytes that the file makes us allocate. A few kilobytes of compressed, sparse or shared data can ask for
  /// terabytes: more than 256 MiB + 256 times the size of the file is an error.
  void charge(uint64_t count, uint64_t bytesEach, const std::string& user);

 private:
  /// Location of the elements of an accessor. `first` is null if all are zero (no bufferView).
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
  /// Calls set(element, component, value) for every component, including sparse ones.
  template <typename Set>
  void forEachValue(int accessor, const Layout& layout, const std::string& user, Set&& set);

  GltfFile& file_;
  const Source& source_;
  std::map<int, FileBytes> decompressed_;                      ///< key: index of the bufferView
  std::map<std::pair<int, size_t>, std::vector<float>> kept_;  ///< key: accessor and components
  std::map<std::string, FileBytes> siblings_;                  ///< key: path without dots, as RFC 3986 removes them
  uint64_t inputBytes_;                                        ///< of the file and its siblings
  uint64_t charged_ = 0;
};

/// A decoded primitive of KHR_draco_mesh_compression.
struct DracoMesh {
  std::vector<float> positions;
  std::vector<float> uvs;                           ///< empty: not requested
  std::vector<std::vector<float>> joints, weights;  ///< by set, 4 per vertex
  std::vector<uint32_t> indices;
};
/// Ids of the attributes in Draco data. A negative `uvs` requests no texture coordinates.
struct DracoIds {
  int positions = 0, uvs = -1;
  std::vector<int> joints, weights;  ///< by set
};
DracoMesh decodeDraco(Bytes bytes, const DracoIds& ids, const std::string& user, const Source& source);

/// Maps texture coordinates to a material's alpha image: u v of TEXCOORD_n times the 2x3 matrix (row-major) of
/// KHR_texture_transform.
struct GltfTexture {
  int texCoord = 0;
  std::array<double, 6> transform = {1, 0, 0, 0, 1, 0};
};
/// Returns an entry per material of the file, empty if it has no alpha image. Fills the scene's alpha images, and
/// counts the cut-out materials whose image has colours.
std::vector<std::optional<GltfTexture>> readGltfImages(const GltfFile& file, GltfArrays& arrays, const Source& source,
                                                       Scene& scene, LeftOut& leftOut);

/// How the nodes of a scene use a mesh of the file.
struct GltfMeshUse {
  bool placed = false, skinned = false;
};

/// Reads the meshes that are placed, in the order of the file. Adds glTF's default material if a primitive has none.
/// Vertices of a skinned mesh have joints and weights; where a primitive has none, the weights are 0 and stay to be
/// set.
std::vector<Mesh> readGltfMeshes(const tinygltf::Model& model, GltfArrays& arrays, const Source& source,
                                 const std::vector<GltfMeshUse>& uses,
                                 const std::vector<std::optional<GltfTexture>>& textures,
                                 std::vector<Material>& materials, LeftOut& leftOut);

/// Returns a label such as "mesh 3 'wall'" for messages.
std::string gltfLabel(const char* what, size_t index, const std::string& name);

}  // namespace gnosphere
