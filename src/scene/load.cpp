// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <new>
#include <system_error>

#include "base/finite.hpp"
#include "base/limits.hpp"
#include "base/os.hpp"
#include "base/path.hpp"
#include "base/text.hpp"
#include "scene/readers.hpp"

namespace gnosphere {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void failFile(const fs::path& file, const std::string& reason) {
  throw Error(ErrorCode::file, "cannot read '" + file.string() + "': " + reason);
}

SceneFormat formatOf(const fs::path& file) {
  const std::string ending = lower(file.extension().string());
  if (ending == ".gltf" || ending == ".glb") return SceneFormat::gltf;
  if (ending == ".obj") return SceneFormat::obj;
  if (ending == ".ply") return SceneFormat::ply;
  if (ending == ".stl") return SceneFormat::stl;
  const std::string which = std::string("'").append(file.string()) + "': ";
  for (const char* robotics : {".urdf", ".sdf", ".world", ".xml", ".mjcf", ".usd", ".usda", ".usdc", ".usdz"})
    if (ending == robotics)
      throw Error(ErrorCode::invalidArgument,
                  which + "the Python package reads such files: python -m gnosphere.robotics FILE -o scene.glb");
  throw Error(ErrorCode::invalidArgument,
              which + "unknown ending '" + ending + "' for a scene; known are .gltf, .glb, .obj, .ply and .stl");
}

/// Returns the transform above every instance: `scale`, and a rotation for y-up files. Vertices stay as the file has
/// them.
Transform rootTransform(SceneFormat format, const LoadOptions& options) {
  const bool yUp = options.up == UpAxis::y || (options.up == UpAxis::formatDefault && format == SceneFormat::gltf);
  const double s = options.scale;
  if (yUp) return {{s, 0, 0, 0, 0, 0, -s, 0, 0, s, 0, 0}};
  return {{s, 0, 0, 0, 0, s, 0, 0, 0, 0, s, 0}};
}

}  // namespace

FileBytes readFile(const fs::path& file) {
  std::error_code problem;
  const fs::file_status status = fs::status(file, problem);
  if (!fs::exists(status)) failFile(file, problem ? problem.message() : "there is no such file");
  if (fs::is_directory(status)) failFile(file, "it is a folder");
  // Reading a pipe or a device may never end.
  if (!fs::is_regular_file(status)) failFile(file, "it is not a regular file");

  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(os::openFile(file, "rb"), &std::fclose);
  if (!stream) failFile(file, os::reasonText(errno));
  const uintmax_t size = fs::file_size(file, problem);
  if (problem) failFile(file, problem.message());
  FileBytes bytes;
  bytes.data = std::make_unique_for_overwrite<uint8_t[]>(size);
  bytes.size = std::fread(bytes.data.get(), 1, size, stream.get());
  if (bytes.size != size) failFile(file, "it ended after " + std::to_string(bytes.size) + " bytes");
  return bytes;
}

std::string inQuotes(std::string_view text) {
  constexpr size_t kMost = 60;
  std::string shown = "'";
  while (!text.empty() && shown.size() <= kMost) {
    const size_t length = utf8Length(text);
    const bool isControl = static_cast<unsigned char>(text[0]) < 0x20 || text[0] == 0x7f;
    shown += isControl || length == 0 ? std::string("?") : std::string(text.substr(0, length));
    text.remove_prefix(length > 0 ? length : 1);
  }
  return shown + (text.empty() ? "'" : "…'");
}

std::vector<std::string> LeftOut::lines() const {
  std::vector<std::string> lines;
  for (const auto& [what, count] : counts_) lines.push_back(std::to_string(count) + " " + what);
  return lines;
}

Scene readScene(SceneFormat format, Bytes bytes, const Source& source) {
  if (bytes.empty()) source.fail("the file is empty");
  try {
    Scene scene = format == SceneFormat::gltf  ? readGltf(bytes, source)
                  : format == SceneFormat::obj ? readObj(bytes, source)
                  : format == SceneFormat::ply ? readPly(bytes, source)
                                               : readStl(bytes, source);
    if (const size_t placed = scene.placedTriangleCount(); placed > limits::kTriangles.most)
      source.fail("it places " + std::to_string(placed) + " triangles; the limit is " +
                  std::to_string(limits::kTriangles.most));
    return scene;
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::outOfMemory, source.name + ": its " + std::to_string(bytes.size()) +
                                            " bytes need more memory than there is; load a smaller file");
  } catch (const std::exception& error) {
    source.fail(error.what());
  }
}

Scene loadScene(const fs::path& file, const LoadOptions& options) {
  std::vector<std::string> beside;
  return loadScene(file, options, beside);
}

Scene loadScene(const fs::path& file, const LoadOptions& options, std::vector<std::string>& beside) {
  if (!(options.scale > 0) || !std::isfinite(options.scale))
    throw Error(ErrorCode::invalidArgument, "the scale must be a positive number");
  const SceneFormat format = formatOf(file);
  const FileBytes bytes = readFile(file);
  Source source;
  source.name = std::string("'").append(file.string()).append("'");
  source.unit = options.scale;
  source.sibling = [&beside, folder = file.parent_path()](const std::string& relativePath) {
    FileBytes read = readFile(folder / pathOf(relativePath));
    beside.push_back(relativePath);
    return read;
  };
  Scene scene = readScene(format, bytes, source);

  const Transform root = rootTransform(format, options);
  scene.animation.root = root;
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    Transform& transform = scene.instances[i].transform;
    transform = root * transform;
    if (!allFinite(transform.rows)) source.fail("instance " + std::to_string(i) + " is out of bounds at this scale");
  }
  return scene;
}

}  // namespace gnosphere
