// SPDX-License-Identifier: Apache-2.0
// The implementation macros of the header-only libraries that read and write files, and nothing else.

// Before tinygltf, which uses it.
#include <nlohmann/json.hpp>

#include "scene/stb_memory.hpp"

#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_INCLUDE_JSON
#include <tiny_gltf.h>

#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#define STBI_NO_STDIO
#define STBI_MALLOC(bytes) gnosphere::stbReallocate(nullptr, bytes)
#define STBI_REALLOC(array, bytes) gnosphere::stbReallocate(array, bytes)
#define STBI_FREE(array) std::free(array)
#include <stb_image.h>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb_image_write.h>
