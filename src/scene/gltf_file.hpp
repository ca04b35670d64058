// SPDX-License-Identifier: Apache-2.0
// The inside of the glTF reader: file -> GltfFile (gltf_file.cpp) -> arrays (gltf_accessor.cpp) -> Scene
// (gltf_read.cpp).
#pragma once

// The configuration of third_party_files.cpp, which holds tinygltf's implementation.
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_INCLUDE_JSON
#include <tiny_gltf.h>

#include <nlohmann/json.hpp>

#include "scene/readers.hpp"

namespace gnosphere {

/// A buffer that is read when something in it is needed.
struct GltfBuffer {
  std::string uri;        ///< empty: the binary chunk of a GLB, or bytes that nothing may need (meshopt's fallback)
  size_t byteLength = 0;  ///< as declared
  Bytes bytes;            ///< what is there, once loaded
  FileBytes owned;
  bool loaded = false;
};

/// Where a picture is: a file or data URI, or a bufferView.
struct GltfImage {
  std::string uri;
  int bufferView = -1;
};

/// tinygltf's model, without what only pictures need and without the buffers and images. tinygltf would copy the binary
/// chunk and refuse whole files for a missing texture, for a buffer without `uri` (which EXT_meshopt_compression asks
/// for) and for indices without bufferView (which KHR_draco_mesh_compression asks for). Every property kept has its
/// right type.
struct GltfFile {
  tinygltf::Model model;
  std::vector<GltfBuffer> buffers;
  std::vector<GltfImage> images;
};

/// Where parseGltf puts the accessor of a primitive's indices: among its attributes.
inline constexpr const char* kIndicesAttribute = "_GNOSPHERE_INDICES";

GltfFile parseGltf(Bytes bytes, const Source& source);

}  // namespace gnosphere
