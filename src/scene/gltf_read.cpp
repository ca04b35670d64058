// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "scene/gltf_accessor.hpp"

namespace gnosphere {
namespace {

constexpr int kNone = -1;

/// Refuses a required extension that changes the geometry unless we read it. Extensions that only change how a surface
/// looks are accepted, because they move no triangle.
void checkRequiredExtensions(const tinygltf::Model& model, const Source& source) {
  const auto known = [](const std::string& name) {
    static constexpr const char* kRead[] = {"KHR_mesh_quantization", "KHR_draco_mesh_compression",
                                            "EXT_meshopt_compression", "EXT_mesh_gpu_instancing"};
    static constexpr const char* kHarmless[] = {"KHR_materials_", "KHR_texture_",  "EXT_texture_", "KHR_lights_",
                                                "EXT_lights_",    "MSFT_texture_", "KHR_xmp",      "KHR_animation_"};
    return std::any_of(std::begin(kRead), std::end(kRead), [&](const char* read) { return name == read; }) ||
           std::any_of(std::begin(kHarmless), std::end(kHarmless),
                       [&](const char* prefix) { return name.starts_with(prefix); });
  };
  for (const std::string& name : model.extensionsRequired)
    if (!known(name))
      source.fail("it requires the extension " + inQuotes(name) +
                  ", which GnoSphere does not read; export it without that extension");
}

/// Composes translation * rotation * scale. The quaternion may have any length, because it may be quantised.
Transform composed(const double* t, const double* q, const double* s) {
  const double x = q[0], y = q[1], z = q[2], w = q[3];
  const double norm = x * x + y * y + z * z + w * w;
  const double k = norm > 0 ? 2 / norm : 0;
  return {{(1 - k * (y * y + z * z)) * s[0], k * (x * y - z * w) * s[1], k * (x * z + y * w) * s[2], t[0],
           k * (x * y + z * w) * s[0], (1 - k * (x * x + z * z)) * s[1], k * (y * z - x * w) * s[2], t[1],
           k * (x * z - y * w) * s[0], k * (y * z + x * w) * s[1], (1 - k * (x * x + y * y)) * s[2], t[2]}};
}

Transform localTransform(const tinygltf::Node& node) {
  if (!node.matrix.empty()) {  // column-major
    Transform transform;
    for (size_t row = 0; row < 3; ++row)
      for (size_t column = 0; column < 4; ++column) transform.rows[4 * row + column] = node.matrix[4 * column + row];
    return transform;
  }
  static constexpr double kZero[] = {0, 0, 0}, kUnit[] = {0, 0, 0, 1}, kOne[] = {1, 1, 1};
  return composed(node.translation.empty() ? kZero : node.translation.data(),
                  node.rotation.empty() ? kUnit : node.rotation.data(), node.scale.empty() ? kOne : node.scale.data());
}

class Reader {
 public:
  Reader(GltfFile& file, Bytes bytes, const Source& source)
      : file_(file), model_(file.model), arrays_(file, bytes, source), source_(source) {}

  Scene read() {
    checkRequiredExtensions(model_, source_);
    for (const tinygltf::Material& material : model_.materials) scene_.materials.push_back(readMaterial(material));
    readNodes();
    readMeshes();
    return std::move(scene_);
  }

 private:
  Material readMaterial(const tinygltf::Material& from) const;
  std::vector<int> parents() const;
  std::vector<int> roots(const std::vector<int>& parents) const;
  void readNodes();
  void place(size_t node, const Transform& transform);
  void add(const tinygltf::Node& node, const Transform& transform, const std::string& who);
  void readMeshes();

  const GltfFile& file_;
  const tinygltf::Model& model_;
  GltfArrays arrays_;
  const Source& source_;
  Scene scene_;
};

Material Reader::readMaterial(const tinygltf::Material& from) const {
  const auto unit = [](double value) { return static_cast<float>(std::clamp(value, 0.0, 1.0)); };
  Material material;
  material.name = from.name;
  const tinygltf::PbrMetallicRoughness& pbr = from.pbrMetallicRoughness;
  for (size_t i = 0; i < 4 && i < pbr.baseColorFactor.size(); ++i) material.baseColor[i] = unit(pbr.baseColorFactor[i]);
  material.metallic = unit(pbr.metallicFactor);
  material.roughness = unit(pbr.roughnessFactor);
  material.alphaMode = from.alphaMode == "MASK"    ? AlphaMode::mask
                       : from.alphaMode == "BLEND" ? AlphaMode::blend
                                                   : AlphaMode::opaque;
  material.alphaCutoff = static_cast<float>(from.alphaCutoff);
  material.doubleSided = from.doubleSided;
  const auto transmission = from.extensions.find("KHR_materials_transmission");
  if (transmission != from.extensions.end() && transmission->second.Has("transmissionFactor"))
    material.transmission = unit(transmission->second.Get("transmissionFactor").GetNumberAsDouble());
  return material;
}

std::vector<int> Reader::parents() const {
  const size_t count = model_.nodes.size();
  std::vector<int> parents(count, kNone);
  for (size_t i = 0; i < count; ++i)
    for (int child : model_.nodes[i].children) {
      if (child < 0 || static_cast<size_t>(child) >= count)
        source_.fail(gltfLabel("node", i, model_.nodes[i].name) + ": child " + std::to_string(child) +
                     " does not exist");
      int& parent = parents[static_cast<size_t>(child)];
      if (parent != kNone)
        source_.fail(gltfLabel("node", static_cast<size_t>(child), model_.nodes[static_cast<size_t>(child)].name) +
                     " is listed as a child twice, by nodes " + std::to_string(parent) + " and " + std::to_string(i));
      parent = static_cast<int>(i);
    }
  // Every node has at most one parent, so a walk upwards ends at a root or returns to its start (a cycle).
  std::vector<size_t> walk(count, 0);
  for (size_t i = 0; i < count; ++i) {
    int at = static_cast<int>(i);
    while (at != kNone && walk[static_cast<size_t>(at)] == 0) {
      walk[static_cast<size_t>(at)] = i + 1;
      at = parents[static_cast<size_t>(at)];
    }
    if (at != kNone && walk[static_cast<size_t>(at)] == i + 1)
      source_.fail(gltfLabel("node", static_cast<size_t>(at), model_.nodes[static_cast<size_t>(at)].name) +
                   " is its own ancestor: the node tree has a cycle");
  }
  return parents;
}

std::vector<int> Reader::roots(const std::vector<int>& parents) const {
  std::vector<int> roots;
  if (model_.scenes.empty()) {
    for (size_t i = 0; i < parents.size(); ++i)
      if (parents[i] == kNone) roots.push_back(static_cast<int>(i));
    return roots;
  }
  const int chosen = std::max(model_.defaultScene, 0);
  if (static_cast<size_t>(chosen) >= model_.scenes.size())
    source_.fail("scene " + std::to_string(chosen) + " does not exist");
  std::vector<bool> seen(parents.size());
  for (int root : model_.scenes[static_cast<size_t>(chosen)].nodes) {
    const std::string who = "scene " + std::to_string(chosen) + ": node " + std::to_string(root);
    if (root < 0 || static_cast<size_t>(root) >= parents.size()) source_.fail(who + " does not exist");
    if (parents[static_cast<size_t>(root)] != kNone)
      source_.fail(who + " is not a root, it is a child of node " + std::to_string(parents[static_cast<size_t>(root)]));
    if (seen[static_cast<size_t>(root)]) source_.fail(who + " is listed twice");
    seen[static_cast<size_t>(root)] = true;
    roots.push_back(root);
  }
  return roots;
}

void Reader::readNodes() {
  // An explicit stack: recursion through a chain of a million nodes would overflow the call stack.
  struct Visit {
    int node;
    Transform parent;
  };
  std::vector<Visit> stack;
  const std::vector<int> roots = this->roots(parents());
  for (auto root = roots.rbegin(); root != roots.rend(); ++root) stack.push_back({*root, {}});
  while (!stack.empty()) {
    const Visit visit = stack.back();
    stack.pop_back();
    const tinygltf::Node& node = model_.nodes[static_cast<size_t>(visit.node)];
    const Transform transform = visit.parent * localTransform(node);
    if (node.mesh >= 0) place(static_cast<size_t>(visit.node), transform);
    for (auto child = node.children.rbegin(); child != node.children.rend(); ++child)
      stack.push_back({*child, transform});
  }
}

void Reader::add(const tinygltf::Node& node, const Transform& transform, const std::string& who) {
  if (!std::all_of(transform.rows.begin(), transform.rows.end(), [](double value) { return std::isfinite(value); }))
    source_.fail(who + ": its transform is not finite");
  scene_.instances.push_back({node.name, static_cast<uint32_t>(node.mesh), transform});
}

void Reader::place(size_t index, const Transform& transform) {
  const tinygltf::Node& node = model_.nodes[index];
  const std::string who = gltfLabel("node", index, node.name);
  if (static_cast<size_t>(node.mesh) >= model_.meshes.size())
    source_.fail(who + ": mesh " + std::to_string(node.mesh) + " does not exist");
  const auto instancing = node.extensions.find("EXT_mesh_gpu_instancing");
  if (instancing == node.extensions.end()) return add(node, transform, who);

  const tinygltf::Value& attributes = instancing->second.Get("attributes");
  size_t count = 0;
  bool first = true;
  const auto attribute = [&](const char* name, int components) {
    std::vector<double> values;
    if (!attributes.Has(name)) return values;
    values = arrays_.vectors(attributes.Get(name).GetNumberAsInt(), components, who + ", instances, " + name);
    const size_t elements = values.size() / static_cast<size_t>(components);
    if (!first && elements != count)
      source_.fail(who + ": " + name + " has " + std::to_string(elements) + " instances, another attribute has " +
                   std::to_string(count));
    count = elements;
    first = false;
    return values;
  };
  const std::vector<double> translations = attribute("TRANSLATION", 3);
  const std::vector<double> rotations = attribute("ROTATION", 4);
  const std::vector<double> scales = attribute("SCALE", 3);
  arrays_.charge(count, sizeof(Instance), who);
  static constexpr double kZero[] = {0, 0, 0}, kUnit[] = {0, 0, 0, 1}, kOne[] = {1, 1, 1};
  for (size_t i = 0; i < count; ++i)
    add(node,
        transform * composed(translations.empty() ? kZero : &translations[3 * i],
                             rotations.empty() ? kUnit : &rotations[4 * i], scales.empty() ? kOne : &scales[3 * i]),
        who + ", instance " + std::to_string(i));
}

/// Reads only the meshes that the scene places, in the order of the file.
void Reader::readMeshes() {
  std::vector<uint32_t> newIndex(model_.meshes.size(), 0);
  std::vector<bool> isUsed(model_.meshes.size());
  for (const Instance& instance : scene_.instances) isUsed[instance.mesh] = true;
  const auto textures = readGltfImages(file_, arrays_, source_, scene_);
  scene_.meshes = readGltfMeshes(model_, arrays_, source_, isUsed, textures, scene_.materials);
  for (size_t i = 0, next = 0; i < isUsed.size(); ++i)
    if (isUsed[i]) newIndex[i] = static_cast<uint32_t>(next++);
  for (Instance& instance : scene_.instances) instance.mesh = newIndex[instance.mesh];
}

}  // namespace

Scene readGltf(Bytes bytes, const Source& source) {
  GltfFile file = parseGltf(bytes, source);
  return Reader(file, bytes, source).read();
}

}  // namespace gnosphere
