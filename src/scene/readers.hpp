// SPDX-License-Identifier: Apache-2.0
// What the scene readers share. Readers work on bytes in memory, so that the fuzzer reaches them without a file system.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "gnosphere/error.hpp"
#include "gnosphere/scene.hpp"

namespace gnosphere {

using Bytes = std::span<const uint8_t>;

/// The whole content of a file. Not a vector, which would write every byte twice.
struct FileBytes {
  std::unique_ptr<uint8_t[]> data;
  size_t size = 0;
  operator Bytes() const { return {data.get(), size}; }
};

/// Throws Error(file) with the system's reason.
FileBytes readFile(const std::filesystem::path& file);

/// Where the bytes come from: the name that messages begin with, and the files beside it (buffers, material libraries).
/// `sibling` throws Error(file) where there is none.
struct Source {
  std::string name;
  std::function<FileBytes(const std::string& relativePath)> sibling;

  [[noreturn]] void fail(const std::string& what) const { throw Error(ErrorCode::format, name + ": " + what); }
};

enum class SceneFormat { gltf, obj, ply, stl };

/// Scene as the file states it: no turn, no scale. glTF text and GLB are told apart by their first bytes.
Scene readGltf(Bytes bytes, const Source& source);
Scene readObj(Bytes bytes, const Source& source);
Scene readPly(Bytes bytes, const Source& source);
Scene readStl(Bytes bytes, const Source& source);

/// The reader of a format; whatever third-party code throws becomes Error(format), want of memory Error(outOfMemory).
Scene readScene(SceneFormat format, Bytes bytes, const Source& source);

/// Fills positions (and origin) from x y z doubles. The origin is 0 where floats hold every coordinate exactly, else
/// the centre of the finite coordinates rounded to a metre, so that a georeferenced file keeps its millimetres.
void storePositions(Mesh& mesh, std::span<const double> coordinates);

/// Appends the triangles of one polygon, counter-clockwise as its corners are. Concave polygons are cut by their ears.
void appendPolygon(std::vector<uint32_t>& indices, std::span<const uint32_t> corners,
                   std::span<const double> coordinates);

/// `text` for a message: at most 60 characters, control characters replaced.
std::string inQuotes(std::string_view text);

}  // namespace gnosphere
