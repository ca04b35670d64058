// SPDX-License-Identifier: Apache-2.0
// The file is written without tinygltf, which would hold two more copies of every byte in memory.
#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>

#include "gnosphere/error.hpp"
#include "gnosphere/scene.hpp"

namespace gnosphere {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr int kFloat = 5126, kUnsignedInt = 5125;
constexpr int kVertexTarget = 34962, kIndexTarget = 34963;
constexpr int kPoints = 0;

Json toJson(const Material& material) {
  Json json = {{"pbrMetallicRoughness",
                {{"baseColorFactor", material.baseColor},
                 {"metallicFactor", material.metallic},
                 {"roughnessFactor", material.roughness}}},
               {"doubleSided", material.doubleSided}};
  if (!material.name.empty()) json["name"] = material.name;
  if (material.alphaMode == AlphaMode::blend) json["alphaMode"] = "BLEND";
  if (material.alphaMode == AlphaMode::mask) {
    json["alphaMode"] = "MASK";
    json["alphaCutoff"] = material.alphaCutoff;
  }
  if (material.transmission > 0)
    json["extensions"]["KHR_materials_transmission"]["transmissionFactor"] = material.transmission;
  return json;
}

/// Adds the bounds of the positions, which glTF requires. They ignore NaN and infinity, which JSON cannot express.
void addBounds(Json& accessor, std::span<const float> positions) {
  constexpr float kHuge = std::numeric_limits<float>::max();
  std::array<float, 3> low = {kHuge, kHuge, kHuge}, high = {-kHuge, -kHuge, -kHuge};
  for (size_t i = 0; i < positions.size(); ++i) {
    const float value = positions[i];
    if (!std::isfinite(value)) continue;
    low[i % 3] = std::min(low[i % 3], value);
    high[i % 3] = std::max(high[i % 3], value);
  }
  for (size_t c = 0; c < 3; ++c)
    if (low[c] > high[c]) low[c] = high[c] = 0;
  accessor["min"] = low;
  accessor["max"] = high;
}

/// The positions as they are deformed. `storage` holds them if they are not those of the mesh.
const std::vector<float>& positionsOf(const Mesh& mesh, std::vector<float>& storage) {
  if (mesh.deformation.empty()) return mesh.positions;
  return storage = deformedPositions(mesh, mesh.deformation);
}

class Document {
 public:
  explicit Document(const Scene& scene) {
    json_["asset"] = {{"version", "2.0"}, {"generator", "GnoSphere"}};
    json_["scene"] = 0;
    for (const Material& material : scene.materials) {
      json_["materials"].push_back(toJson(material));
      if (material.transmission > 0) json_["extensionsUsed"] = {"KHR_materials_transmission"};
    }
    for (const Mesh& mesh : scene.meshes) add(mesh);
    Json roots = Json::array();
    for (size_t i = 0; i < scene.instances.size(); ++i) {
      json_["nodes"].push_back(node(scene, scene.instances[i]));
      roots.push_back(i);
    }
    json_["scenes"] = Json::array({Json::object()});
    if (!roots.empty()) json_["scenes"][0]["nodes"] = std::move(roots);
    if (byteLength_ > 0) json_["buffers"] = Json::array({{{"byteLength", byteLength_}}});
  }

  uint64_t byteLength() const { return byteLength_; }
  /// The JSON text, padded with spaces to whole words as GLB requires.
  std::string text() const {
    std::string text = json_.dump(-1, ' ', false, Json::error_handler_t::replace);
    text.resize((text.size() + 3) / 4 * 4, ' ');
    return text;
  }

 private:
  size_t push(const char* array, Json&& item) {
    json_[array].push_back(std::move(item));
    return json_[array].size() - 1;
  }

  size_t addView(uint64_t bytes, int target) {
    const size_t view =
        push("bufferViews", {{"buffer", 0}, {"byteOffset", byteLength_}, {"byteLength", bytes}, {"target", target}});
    byteLength_ += bytes;
    return view;
  }

  void add(const Mesh& mesh) {
    Json primitives = Json::array();
    if (mesh.triangleCount() > 0) {
      Json positions = {{"componentType", kFloat}, {"type", "VEC3"}, {"count", mesh.vertexCount()}};
      positions["bufferView"] = addView(mesh.positions.size() * sizeof(float), kVertexTarget);
      std::vector<float> storage;
      addBounds(positions, positionsOf(mesh, storage));
      const size_t vertices = push("accessors", std::move(positions));
      const size_t view = addView(mesh.indices.size() * sizeof(uint32_t), kIndexTarget);
      for (const MeshPart& part : mesh.parts) {
        if (part.triangleCount == 0) continue;
        const size_t indices = push("accessors", {{"bufferView", view},
                                                  {"byteOffset", size_t{part.firstTriangle} * 3 * sizeof(uint32_t)},
                                                  {"componentType", kUnsignedInt},
                                                  {"type", "SCALAR"},
                                                  {"count", size_t{part.triangleCount} * 3}});
        primitives.push_back(
            {{"attributes", {{"POSITION", vertices}}}, {"indices", indices}, {"material", part.material}});
      }
    } else {
      // glTF has no empty mesh. A single point, which has no area, takes its place, so that mesh and instance numbers
      // stay.
      const Json zero = {0, 0, 0};
      const size_t point =
          push("accessors", {{"componentType", kFloat}, {"type", "VEC3"}, {"count", 1}, {"min", zero}, {"max", zero}});
      primitives.push_back({{"attributes", {{"POSITION", point}}}, {"mode", kPoints}});
    }
    Json item = {{"primitives", std::move(primitives)}};
    if (!mesh.name.empty()) item["name"] = mesh.name;
    push("meshes", std::move(item));
  }

  static Json node(const Scene& scene, const Instance& instance) {
    const Vec3& origin = scene.meshes[instance.mesh].origin;
    const Transform toYUp = {{1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0}};
    const Transform matrix =
        toYUp * instance.transform * Transform{{1, 0, 0, origin.x, 0, 1, 0, origin.y, 0, 0, 1, origin.z}};
    for (double value : matrix.rows)
      if (!std::isfinite(value))
        throw Error(ErrorCode::invalidArgument, "the origin of mesh " + std::to_string(instance.mesh) +
                                                    " moves an instance of it beyond finite numbers");
    Json columns = Json::array();
    for (size_t column = 0; column < 4; ++column)
      for (size_t row = 0; row < 4; ++row)
        columns.push_back(row < 3 ? matrix.rows[4 * row + column] : column == 3 ? 1.0 : 0.0);
    Json json = {{"mesh", instance.mesh}, {"matrix", std::move(columns)}};
    if (!instance.name.empty()) json["name"] = instance.name;
    return json;
  }

  Json json_;
  uint64_t byteLength_ = 0;
};

/// A file that is written as `file.part`, renamed to `file` when it is complete and removed if it is not.
class PartFile {
 public:
  explicit PartFile(const fs::path& file) : file_(file), part_(file) {
    part_ += ".part";
    stream_.open(part_, std::ios::binary | std::ios::trunc);
    if (!stream_) fail();
  }
  ~PartFile() {
    if (done_) return;
    stream_.close();
    std::error_code ignored;
    fs::remove(part_, ignored);
  }
  void write(const void* bytes, size_t size) {
    if (size > 0 && !stream_.write(static_cast<const char*>(bytes), static_cast<std::streamsize>(size))) fail();
  }
  void finish() {
    stream_.close();
    if (!stream_) fail();
    std::error_code problem;
    fs::rename(part_, file_, problem);
    if (problem) throw Error(ErrorCode::file, "cannot write '" + file_.string() + "': " + problem.message());
    done_ = true;
  }

 private:
  [[noreturn]] void fail() const {
    throw Error(ErrorCode::file, "cannot write '" + part_.string() + "': " + std::strerror(errno));
  }

  fs::path file_, part_;
  std::ofstream stream_;
  bool done_ = false;
};

}  // namespace

void writeGlb(const Scene& scene, const fs::path& file) {
  static_assert(std::endian::native == std::endian::little, "GLB is little-endian, and arrays are written as they are");
  validate(scene);
  const Document document(scene);
  const std::string text = document.text();
  const uint64_t binary = document.byteLength();
  const uint64_t total = 12 + 8 + text.size() + (binary > 0 ? 8 + binary : 0);
  if (total > std::numeric_limits<uint32_t>::max())
    throw Error(ErrorCode::invalidArgument, "'" + file.string() + "' would have " + std::to_string(total) +
                                                " bytes; GLB ends at 4294967295, so split the scene");

  PartFile output(file);
  const auto words = [&](std::initializer_list<uint32_t> values) {
    output.write(values.begin(), values.size() * sizeof(uint32_t));
  };
  words({0x46546C67, 2, static_cast<uint32_t>(total)});     // "glTF"
  words({static_cast<uint32_t>(text.size()), 0x4E4F534A});  // "JSON"
  output.write(text.data(), text.size());
  if (binary > 0) {
    words({static_cast<uint32_t>(binary), 0x004E4942});  // "BIN"
    for (const Mesh& mesh : scene.meshes) {
      if (mesh.triangleCount() == 0) continue;
      std::vector<float> storage;
      const std::vector<float>& positions = positionsOf(mesh, storage);
      output.write(positions.data(), positions.size() * sizeof(float));
      output.write(mesh.indices.data(), mesh.indices.size() * sizeof(uint32_t));
    }
  }
  output.finish();
}

}  // namespace gnosphere
