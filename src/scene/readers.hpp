// SPDX-License-Identifier: Apache-2.0
// Shared by the scene readers, which read bytes in memory, so that the fuzzer can call them without a file system.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/utf8.hpp"
#include "gnosphere/error.hpp"
#include "gnosphere/scene.hpp"

namespace gnosphere {

using Bytes = std::span<const uint8_t>;

/// The whole content of a file. A vector would also zero every byte first.
struct FileBytes {
  std::unique_ptr<uint8_t[]> data;
  size_t size = 0;
  operator Bytes() const { return {data.get(), size}; }
};

/// Reads a file into memory. Throws Error(file) with the system's reason.
FileBytes readFile(const std::filesystem::path& file);

/// Origin of the bytes: the name that starts every message, and access to files beside it (buffers, material
/// libraries). `sibling` throws Error(file) if a file does not exist.
struct Source {
  std::string name;
  std::function<FileBytes(const std::string& relativePath)> sibling;
  double unit = 1;  ///< the length of the file's unit in metres; positions stay as the file has them

  [[noreturn]] void fail(const std::string& what) const { throw Error(ErrorCode::format, name + ": " + toUtf8(what)); }
};

/// Counts, by kind, the content of a file that the scene leaves out.
class LeftOut {
 public:
  void add(const std::string& what, uint64_t count = 1) { counts_[what] += count; }
  std::vector<std::string> lines() const;

 private:
  std::map<std::string, uint64_t> counts_;
};

/// Names of content that readers of several formats leave out.
inline constexpr const char* kLinesAndPoints = "sets of lines or points, which have no area";
inline constexpr const char* kVertexColours = "sets of vertex colours";
inline constexpr const char* kTextureColours = "materials' colours of textures; the base colours alone count";
inline constexpr const char* kTextureMetals =
    "materials' metalness and roughness of textures; metalness 0 and the roughness factor count instead";
inline constexpr const char* kTextureTransmissions =
    "materials' transmission of textures; transmission 0 counts instead";
inline constexpr const char* kCrossedFaces =
    "outlines of faces that cross themselves or take too long to cut; a fan of triangles stands for each";
inline constexpr const char* kTextureAlphas = "materials' alpha of textures; only glTF's alpha mode MASK makes holes";

/// Names that glTF has for the values of Track::Property and Track::Interpolation, in their order.
inline constexpr std::array<std::string_view, 4> kTrackPaths = {"translation", "rotation", "scale", "weights"};
inline constexpr std::array<std::string_view, 3> kInterpolations = {"STEP", "LINEAR", "CUBICSPLINE"};

enum class SceneFormat { gltf, obj, ply, stl };

/// These return the scene as the file states it, without rotation and scale. glTF text and GLB differ in their first
/// bytes.
Scene readGltf(Bytes bytes, const Source& source);
Scene readObj(Bytes bytes, const Source& source);
Scene readPly(Bytes bytes, const Source& source);
Scene readStl(Bytes bytes, const Source& source);

/// Reads a file as the public loadScene() does, and appends to `beside` the paths, from its folder, of the other files
/// that it has read for it: buffers, images and material libraries.
Scene loadScene(const std::filesystem::path& file, const LoadOptions& options, std::vector<std::string>& beside);

/// Calls the reader of a format. Exceptions of third-party code become Error(format), lack of memory
/// Error(outOfMemory).
Scene readScene(SceneFormat format, Bytes bytes, const Source& source);

/// The PNG file of an alpha image: white pixels with this alpha. Throws Error(invalidArgument) if the image has more
/// pixels than the reader of glTF takes, or the library is built without PNG.
std::vector<uint8_t> pngOf(const AlphaImage& image);

/// In the extras of a node of glTF: the number of its instance in the scene that writeGlb() wrote.
inline constexpr const char* kInstanceExtra = "gnosphere_instance";
/// In the extras of an animation of glTF: the duration of the clip that writeGlb() wrote, in seconds, unless the clip
/// ends with its last key.
inline constexpr const char* kDurationExtra = "gnosphere_duration";

/// Lets every triangle show its other side.
inline void turnAround(std::vector<uint32_t>& indices) {
  for (size_t i = 0; i + 2 < indices.size(); i += 3) std::swap(indices[i + 1], indices[i + 2]);
}

/// The text of a file, without a mark of UTF-8. Throws Error(format) if it is in UTF-16.
inline std::string_view textOf(Bytes bytes, const Source& source) {
  return textOfFile({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, source.name);
}

/// Returns the scene of a file without materials, where each mesh is an instance with its name.
Scene sceneOf(std::vector<Mesh>&& meshes);

/// Appends the triangles of one polygon, in the orientation of its corners. Concave polygons are cut by ear clipping.
/// Returns false if triangles also cover area outside, because the outline crosses itself or the cutting took too long.
bool appendPolygon(std::vector<uint32_t>& indices, std::span<const uint32_t> corners,
                   std::span<const double> coordinates);

/// Returns `text` in quotes for a message: at most 60 characters, control characters replaced.
std::string inQuotes(std::string_view text);

}  // namespace gnosphere
