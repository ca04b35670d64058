// SPDX-License-Identifier: Apache-2.0
// Stages of the glTF reader: file -> GltfFile (gltf_file.cpp) -> arrays (gltf_accessor.cpp) -> Scene (gltf_read.cpp).
#pragma once

// This configuration must be the one in third_party_files.cpp, which compiles tinygltf's implementation.
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_INCLUDE_JSON
#include <tiny_gltf.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "scene/readers.hpp"

namespace gnosphere {

/// A buffer, read when it is first needed.
struct GltfBuffer {
  std::string uri;        ///< empty: the binary chunk of a GLB, or a fallback of meshopt that nobody may read
  size_t byteLength = 0;  ///< the length that the file states
  Bytes bytes;            ///< the content, once loaded
  FileBytes owned;
  bool loaded = false;
};

/// Location of an image: a file, a data URI or a bufferView.
struct GltfImage {
  std::string uri;
  int bufferView = -1;
};

/// tinygltf's model, without the properties that only renderers need and without buffers, images, skins and animations.
/// tinygltf would drop channels without a word, copy the binary chunk and refuse whole files for a missing texture, for
/// a buffer without `uri` (which EXT_meshopt_compression requires) and for indices without bufferView (which
/// KHR_draco_mesh_compression requires). The types of all kept properties have been checked.
struct GltfFile {
  tinygltf::Model model;
  std::vector<GltfBuffer> buffers;
  std::vector<GltfImage> images;
  nlohmann::json skins, animations;  ///< arrays as in the file, or null
  LeftOut leftOut;
};

/// Name of the attribute under which parseGltf stores the accessor of a primitive's indices.
inline constexpr const char* kIndicesAttribute = "_GNOSPHERE_INDICES";

GltfFile parseGltf(Bytes bytes, const Source& source);

/// Whether a file may require an extension: we read it, or it only changes how a surface looks and moves no triangle.
bool isGltfExtensionKnown(const std::string& name);

}  // namespace gnosphere
