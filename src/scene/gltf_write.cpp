// SPDX-License-Identifier: Apache-2.0
// The file is written without tinygltf, which would hold two more copies of every byte in memory.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <deque>
#include <initializer_list>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <span>

#include "base/file.hpp"
#include "base/json_text.hpp"
#include "base/text.hpp"
#include "base/transform.hpp"
#include "gnosphere/error.hpp"
#include "gnosphere/scene.hpp"
#include "scene/readers.hpp"

namespace gnosphere {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr int kFloat = 5126, kUnsignedInt = 5125, kUnsignedShort = 5123;
constexpr int kVertexTarget = 34962, kIndexTarget = 34963;
constexpr int kPoints = 0;
constexpr int kWraps[] = {10497, 33648, 33071};  // by AlphaImage::Wrap: repeat, mirrored repeat, clamp to edge

/// Adds the class of a material or an instance: its number, or else its name.
void addClass(Json& item, uint16_t id, const std::string& name) {
  if (id != 0)
    item["extras"]["class"] = id;
  else if (!name.empty())
    item["extras"]["class"] = name;
}

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
    if (material.alphaImage != kNoImage)
      json["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", material.alphaImage}};
  }
  if (material.transmission > 0)
    json["extensions"]["KHR_materials_transmission"]["transmissionFactor"] = material.transmission;
  addClass(json, material.classId, material.className);
  if (material.retro > 0) json["extras"]["retro"] = material.retro;
  return json;
}

/// Adds bounds of the positions, which glTF requires. The bounds ignore NaN and infinity, which JSON cannot express.
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

Transform translation(const Vec3& to) {
  return {{1, 0, 0, to.x, 0, 1, 0, to.y, 0, 0, 1, to.z}};
}

/// The columns of a 4x4 matrix.
std::array<double, 16> columnsOf(const Transform& map) {
  std::array<double, 16> columns;
  for (size_t column = 0; column < 4; ++column)
    for (size_t row = 0; row < 4; ++row)
      columns[4 * column + row] = row < 3 ? map.rows[4 * row + column] : column == 3 ? 1.0 : 0.0;
  return columns;
}

/// The JSON of a scene, and the arrays that follow it.
class Document {
 public:
  explicit Document(const Scene& scene) : scene_(scene), followed_(scene.meshes.size()) {
    json_["asset"] = {{"version", "2.0"}, {"generator", "GnoSphere"}};
    json_["scene"] = 0;
    for (const Material& material : scene.materials) {
      json_["materials"].push_back(toJson(material));
      if (material.transmission > 0) json_["extensionsUsed"] = {"KHR_materials_transmission"};
    }
    for (const AlphaImage& image : scene.alphaImages) add(image);
    for (const AnimatedInstance& animated : scene.animation.instances)
      followed_[scene.instances[animated.instance].mesh] = true;
    for (size_t i = 0; i < scene.meshes.size(); ++i) add(scene.meshes[i], followed_[i]);
    addNodes();
    for (const Clip& clip : scene.animation.clips) add(clip);
    if (byteLength_ > 0) json_["buffers"] = Json::array({{{"byteLength", byteLength_}}});
  }

  uint64_t byteLength() const { return byteLength_; }
  /// The binary chunk, array by array.
  const std::vector<std::pair<const void*, size_t>>& arrays() const { return arrays_; }
  /// The JSON text, padded with spaces to whole words as GLB requires.
  std::string text() const {
    std::string text = jsonText(json_);
    text.resize((text.size() + 3) / 4 * 4, ' ');
    return text;
  }

 private:
  size_t push(const char* array, Json&& item) {
    json_[array].push_back(std::move(item));
    return json_[array].size() - 1;
  }

  void addBytes(const void* bytes, size_t size) {
    arrays_.emplace_back(bytes, size);
    byteLength_ += size;
  }
  /// The values must live as long as the document.
  template <typename T>
  size_t addView(const std::vector<T>& values, int target) {
    Json view = {{"buffer", 0}, {"byteOffset", byteLength_}, {"byteLength", values.size() * sizeof(T)}};
    if (target != 0) view["target"] = target;
    addBytes(values.data(), values.size() * sizeof(T));
    // The next array begins at a whole word, as glTF requires.
    static constexpr std::array<uint8_t, 4> kPadding = {};
    addBytes(kPadding.data(), (4 - byteLength_ % 4) % 4);
    return push("bufferViews", std::move(view));
  }

  template <typename T>
  size_t addAccessor(const std::vector<T>& values, const char* type, size_t components, int target = 0) {
    const size_t view = addView(values, target);
    return push("accessors", {{"bufferView", view},
                              {"componentType", std::is_same_v<T, uint16_t> ? kUnsignedShort : kFloat},
                              {"type", type},
                              {"count", values.size() / components}});
  }
  size_t addPositions(const std::vector<float>& positions) {
    const size_t accessor = addAccessor(positions, "VEC3", 3, kVertexTarget);
    addBounds(json_["accessors"][accessor], positions);
    return accessor;
  }

  void add(const AlphaImage& image);
  void add(const Mesh& mesh, bool followed);
  size_t stillMesh(uint32_t mesh);
  void addJoints(const Mesh& mesh, Json& attributes);
  void addNodes();
  void addFollower(const AnimatedInstance& animated, Json&& item, Json& roots);
  void setMatrix(Json& node, const Transform& matrix, uint32_t mesh) const;
  static Json nodeOf(const Node& node);
  size_t addSkin(const Skin& skin, const Vec3& origin);
  void add(const Clip& clip);

  const Scene& scene_;
  std::vector<bool> followed_;                // by mesh: whether an animated instance places it
  std::map<uint32_t, size_t> stillMeshes_;    // the results of stillMesh() that are other meshes
  std::vector<std::vector<size_t>> placers_;  // by node of the animation: nodes of the file that place meshes for it
  Json json_;
  uint64_t byteLength_ = 0;
  std::vector<std::pair<const void*, size_t>> arrays_;
  std::deque<std::vector<float>> floats_;      // arrays that the scene does not have
  std::deque<std::vector<uint16_t>> shorts_;   // the same
  std::deque<std::vector<uint32_t>> indices_;  // the same
  std::deque<std::vector<uint8_t>> images_;    // the same
};

/// Adds a texture of the number that the image has in the scene.
void Document::add(const AlphaImage& image) {
  const size_t view = addView(images_.emplace_back(pngOf(image)), 0);
  const size_t source = push("images", {{"bufferView", view}, {"mimeType", "image/png"}});
  const size_t sampler = push("samplers", {{"wrapS", kWraps[static_cast<size_t>(image.wrapU)]},
                                           {"wrapT", kWraps[static_cast<size_t>(image.wrapV)]}});
  push("textures", {{"source", source}, {"sampler", sampler}});
}

/// With `followed` a deformable mesh is written with its joints and morph targets, otherwise as it is deformed.
void Document::add(const Mesh& mesh, bool followed) {
  Json primitives = Json::array();
  if (mesh.triangleCount() > 0) {
    const bool baked = !followed && !mesh.deformation.empty();
    Json attributes, targets = Json::array();
    attributes["POSITION"] =
        addPositions(baked ? floats_.emplace_back(deformedPositions(mesh, mesh.deformation)) : mesh.positions);
    if (!mesh.uvs.empty()) attributes["TEXCOORD_0"] = addAccessor(mesh.uvs, "VEC2", 2, kVertexTarget);
    if (followed) addJoints(mesh, attributes);
    if (followed)
      for (const std::vector<float>& offsets : mesh.morphTargets)
        targets.push_back({{"POSITION", addPositions(offsets)}});
    const bool mirrored = followed && !mesh.deformation.joints.empty() && determinant(mesh.deformation.joints[0]) < 0;
    if (mirrored) turnAround(indices_.emplace_back(mesh.indices));  // as in the file that the mesh comes from
    const size_t view = addView(mirrored ? indices_.back() : mesh.indices, kIndexTarget);
    for (const MeshPart& part : mesh.parts) {
      if (part.triangleCount == 0) continue;
      const size_t indices = push("accessors", {{"bufferView", view},
                                                {"byteOffset", size_t{part.firstTriangle} * 3 * sizeof(uint32_t)},
                                                {"componentType", kUnsignedInt},
                                                {"type", "SCALAR"},
                                                {"count", size_t{part.triangleCount} * 3}});
      primitives.push_back({{"attributes", attributes}, {"indices", indices}, {"material", part.material}});
      if (!targets.empty()) primitives.back()["targets"] = targets;
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

/// Returns the mesh of the file for an instance that no clip moves. A deformable mesh that animated instances place is
/// written once more for it, as it is deformed.
size_t Document::stillMesh(uint32_t mesh) {
  if (!followed_[mesh] || !scene_.meshes[mesh].deformable()) return mesh;
  const auto [found, isNew] = stillMeshes_.try_emplace(mesh, json_["meshes"].size());
  if (isNew) add(scene_.meshes[mesh], false);
  return found->second;
}

/// Adds the joints in sets of four. A joint without weight is 0, as glTF wants it.
void Document::addJoints(const Mesh& mesh, Json& attributes) {
  for (size_t first = 0; first < mesh.influences; first += 4) {
    std::vector<uint16_t>& joints = shorts_.emplace_back(4 * mesh.vertexCount());
    std::vector<float>& weights = floats_.emplace_back(4 * mesh.vertexCount());
    const size_t count = std::min<size_t>(4, mesh.influences - first);
    for (size_t vertex = 0; vertex < mesh.vertexCount(); ++vertex)
      for (size_t i = 0; i < count; ++i) {
        const size_t from = vertex * mesh.influences + first + i;
        weights[4 * vertex + i] = mesh.jointWeights[from];
        if (mesh.jointWeights[from] > 0) joints[4 * vertex + i] = mesh.joints[from];
      }
    const std::string set = std::to_string(first / 4);
    attributes["JOINTS_" + set] = addAccessor(joints, "VEC4", 4, kVertexTarget);
    attributes["WEIGHTS_" + set] = addAccessor(weights, "VEC4", 4, kVertexTarget);
  }
}

void Document::setMatrix(Json& node, const Transform& matrix, uint32_t mesh) const {
  for (double value : matrix.rows)
    if (!std::isfinite(value))
      throw Error(ErrorCode::invalidArgument,
                  "the origin of mesh " + std::to_string(mesh) + " moves an instance of it beyond finite numbers");
  node["matrix"] = columnsOf(matrix);
}

/// Adds the nodes of the animation, below one that turns them, and a node per instance.
void Document::addNodes() {
  const SceneAnimation& animation = scene_.animation;
  const Transform toYUp = {{1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0}};
  Json roots = Json::array();
  for (const Node& node : animation.nodes) push("nodes", nodeOf(node));
  if (!animation.nodes.empty()) {
    Json turned = {{"children", Json::array()}, {"matrix", columnsOf(toYUp * animation.root)}};
    for (size_t i = 0; i < animation.nodes.size(); ++i) {
      const uint32_t parent = animation.nodes[i].parent;
      (parent == kNoNode ? turned : json_["nodes"][parent])["children"].push_back(i);
    }
    roots.push_back(push("nodes", std::move(turned)));
  }
  placers_.resize(animation.nodes.size());
  std::vector<const AnimatedInstance*> followers(scene_.instances.size());
  for (const AnimatedInstance& animated : animation.instances) followers[animated.instance] = &animated;
  for (size_t i = 0; i < scene_.instances.size(); ++i) {
    const Instance& instance = scene_.instances[i];
    Json item = {{"mesh", instance.mesh}};
    if (!instance.name.empty()) item["name"] = instance.name;
    addClass(item, instance.classId, instance.className);
    // The tree of the animation decides on the order of the nodes, so each says which instance it is.
    if (!animation.instances.empty()) item["extras"][kInstanceExtra] = i;
    if (followers[i] != nullptr) {
      addFollower(*followers[i], std::move(item), roots);
      continue;
    }
    item["mesh"] = stillMesh(instance.mesh);
    setMatrix(item, toYUp * instance.transform * translation(scene_.meshes[instance.mesh].origin), instance.mesh);
    roots.push_back(push("nodes", std::move(item)));
  }
  json_["scenes"] = Json::array({Json::object()});
  if (!roots.empty()) json_["scenes"][0]["nodes"] = std::move(roots);
}

/// Adds the node of an instance that follows a node, below that, or a skin.
void Document::addFollower(const AnimatedInstance& animated, Json&& item, Json& roots) {
  const uint32_t number = scene_.instances[animated.instance].mesh;
  const Mesh& mesh = scene_.meshes[number];
  const Node& node = scene_.animation.nodes[animated.node];
  if (!mesh.morphTargets.empty()) {
    std::vector<float> weights = node.morphWeights;
    weights.resize(mesh.morphTargets.size());
    item["weights"] = std::move(weights);
  }
  const bool skinned = animated.skin != kNoSkin;
  if (skinned)
    item["skin"] = addSkin(scene_.animation.skins[animated.skin], mesh.origin);
  else
    setMatrix(item, animated.offset * translation(mesh.origin), number);
  const size_t index = push("nodes", std::move(item));
  (skinned ? roots : json_["nodes"][animated.node]["children"]).push_back(index);
  if (!mesh.morphTargets.empty()) placers_[animated.node].push_back(index);
}

Json Document::nodeOf(const Node& node) {
  const Vec3 &t = node.translation, &s = node.scale;
  const Quaternion& r = node.rotation;
  Json json =
      node.matrix
          ? Json{{"matrix", columnsOf(*node.matrix)}}
          : Json{{"translation", {t.x, t.y, t.z}}, {"rotation", {r.x, r.y, r.z, r.w}}, {"scale", {s.x, s.y, s.z}}};
  if (!node.name.empty()) json["name"] = node.name;
  return json;
}

size_t Document::addSkin(const Skin& skin, const Vec3& origin) {
  std::vector<float>& binds = floats_.emplace_back();
  for (const Transform& bind : skin.inverseBinds)
    for (double value : columnsOf(bind * translation(origin))) {
      if (!(std::abs(value) <= double{std::numeric_limits<float>::max()}))
        throw Error(ErrorCode::invalidArgument, "skin " + std::to_string(&skin - scene_.animation.skins.data()) +
                                                    ": an inverse bind map is beyond single precision, which glTF has");
      binds.push_back(static_cast<float>(value));
    }
  Json json = {{"joints", skin.joints}, {"inverseBindMatrices", addAccessor(binds, "MAT4", 16)}};
  if (!skin.name.empty()) json["name"] = skin.name;
  return push("skins", std::move(json));
}

void Document::add(const Clip& clip) {
  Json channels = Json::array(), samplers = Json::array();
  double lastKey = 0;
  for (const Track& track : clip.tracks) {
    const bool weights = track.property == Track::Property::morphWeights;
    const bool rotation = track.property == Track::Property::rotation;
    lastKey = std::max(lastKey, double{track.times.back()});
    const size_t input = addAccessor(track.times, "SCALAR", 1);
    json_["accessors"][input]["min"] = {track.times.front()};
    json_["accessors"][input]["max"] = {track.times.back()};
    const size_t output = addAccessor(track.values,
                                      weights    ? "SCALAR"
                                      : rotation ? "VEC4"
                                                 : "VEC3",
                                      weights    ? 1
                                      : rotation ? 4
                                                 : 3);
    samplers.push_back({{"input", input},
                        {"output", output},
                        {"interpolation", kInterpolations[static_cast<size_t>(track.interpolation)]}});
    const std::vector<size_t> nodes = weights ? placers_[track.node] : std::vector<size_t>{track.node};
    for (size_t node : nodes)
      channels.push_back({{"sampler", samplers.size() - 1},
                          {"target", {{"node", node}, {"path", kTrackPaths[static_cast<size_t>(track.property)]}}}});
  }
  const bool isStill = channels.empty();
  if (isStill) {
    // glTF has no animation without channels, so a clip that moves nothing is written with a channel without a node.
    const size_t input = addAccessor(floats_.emplace_back(1), "SCALAR", 1);
    json_["accessors"][input]["min"] = json_["accessors"][input]["max"] = {0};
    samplers.push_back({{"input", input}, {"output", addAccessor(floats_.emplace_back(3), "VEC3", 3)}});
    channels.push_back({{"sampler", 0}, {"target", {{"path", "translation"}}}});
  }
  Json item = {{"name", clip.name}, {"channels", std::move(channels)}, {"samplers", std::move(samplers)}};
  if (isStill || clip.duration != lastKey) item["extras"][kDurationExtra] = clip.duration;
  push("animations", std::move(item));
}

}  // namespace

void writeGlb(const Scene& scene, const fs::path& file) {
  static_assert(std::endian::native == std::endian::little, "GLB is little-endian, and arrays are written as they are");
  if (lower(file.extension().string()) != ".glb")
    throw Error(ErrorCode::invalidArgument, "'" + file.string() + "': scenes are written as .glb; give it that ending");
  validate(scene);
  const Document document(scene);
  const std::string text = document.text();
  const uint64_t binary = document.byteLength();
  const uint64_t total = 12 + 8 + text.size() + (binary > 0 ? 8 + binary : 0);
  if (total > std::numeric_limits<uint32_t>::max())
    throw Error(ErrorCode::invalidArgument, "'" + file.string() + "' would have " + std::to_string(total) +
                                                " bytes; GLB ends at 4294967295, so split the scene");

  AtomicFile output(file);
  const auto words = [&](std::initializer_list<uint32_t> values) {
    output.write(values.begin(), values.size() * sizeof(uint32_t));
  };
  words({0x46546C67, 2, static_cast<uint32_t>(total)});     // "glTF"
  words({static_cast<uint32_t>(text.size()), 0x4E4F534A});  // "JSON"
  output.write(text.data(), text.size());
  if (binary > 0) {
    words({static_cast<uint32_t>(binary), 0x004E4942});  // "BIN"
    for (const auto& [bytes, size] : document.arrays()) output.write(bytes, size);
  }
  output.commit();
}

}  // namespace gnosphere
