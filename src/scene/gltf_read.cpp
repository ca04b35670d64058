// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>

#include "base/finite.hpp"
#include "base/transform.hpp"
#include "scene/gltf_animation.hpp"

namespace gnosphere {
namespace {

constexpr int kNone = -1;

/// Refuses a file that requires an extension which may change the geometry and which we do not read.
void checkRequiredExtensions(const tinygltf::Model& model, const Source& source) {
  for (const std::string& name : model.extensionsRequired)
    if (!isGltfExtensionKnown(name))
      source.fail("it requires the extension " + inQuotes(name) +
                  ", which GnoSphere does not read; export it without that extension");
}

Vec3 vector(const double* values) {
  return {values[0], values[1], values[2]};
}

Quaternion quaternion(const double* values) {
  return {values[0], values[1], values[2], values[3]};
}

Transform localTransform(const tinygltf::Node& node) {
  if (!node.matrix.empty()) return gltfMatrix(node.matrix.data());
  return composed(node.translation.empty() ? Vec3{} : vector(node.translation.data()),
                  node.rotation.empty() ? Quaternion{} : quaternion(node.rotation.data()),
                  node.scale.empty() ? Vec3{1, 1, 1} : vector(node.scale.data()));
}

/// A semantic class by its number or its name.
struct StatedClass {
  uint16_t id = 0;
  std::string name;

  bool operator==(const StatedClass&) const = default;
  bool stated() const { return *this != StatedClass(); }
};

/// The class that parseGltf() has left in extras.
StatedClass classIn(const tinygltf::Value& extras) {
  if (!extras.Has("class")) return {};
  const tinygltf::Value& stated = extras.Get("class");
  if (stated.IsString()) return {0, stated.Get<std::string>()};
  return {static_cast<uint16_t>(stated.GetNumberAsInt()), {}};
}

class Reader {
 public:
  Reader(GltfFile& file, Bytes bytes, const Source& source)
      : file_(file), model_(file.model), arrays_(file, bytes, source), source_(source), leftOut_(file.leftOut) {}

  Scene read() {
    checkRequiredExtensions(model_, source_);
    for (const tinygltf::Material& material : model_.materials) scene_.materials.push_back(readMaterial(material));
    parents_ = parents();
    readNodes();
    sortInstances();
    readMeshes();
    readGltfAnimation(file_, arrays_, source_, parents_, placements_, scene_, leftOut_);
    if (scene_.unreadImages > 0)
      leftOut_.add("images of cut-out materials, which are not there or not PNG; these materials have no holes",
                   scene_.unreadImages);
    scene_.leftOut = leftOut_.lines();
    return std::move(scene_);
  }

 private:
  Material readMaterial(const tinygltf::Material& from) const;
  std::vector<int> parents() const;
  std::vector<int> roots() const;
  void readNodes();
  void countOutside(const std::vector<int>& roots);
  void place(size_t node, const Transform& transform, const StatedClass& byNodes);
  void add(const GltfPlacement& placement, const Transform& transform, const StatedClass& stated,
           const std::string& who);
  void sortInstances();
  void readMeshes();

  const GltfFile& file_;
  const tinygltf::Model& model_;
  GltfArrays arrays_;
  const Source& source_;
  std::vector<int> parents_;  // by node; kNone: it is a root
  Scene scene_;
  std::vector<GltfPlacement> placements_;  // by instance
  LeftOut leftOut_;
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
  material.alphaCutoff =
      static_cast<float>(std::clamp(from.alphaCutoff, 0.0, double{std::numeric_limits<float>::max()}));
  material.doubleSided = from.doubleSided;
  const StatedClass stated = classIn(from.extras);
  material.classId = stated.id;
  material.className = stated.name;
  if (from.extras.Has("retro")) material.retro = static_cast<float>(from.extras.Get("retro").GetNumberAsDouble());
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

std::vector<int> Reader::roots() const {
  std::vector<int> roots;
  if (model_.scenes.empty()) {
    for (size_t i = 0; i < parents_.size(); ++i)
      if (parents_[i] == kNone) roots.push_back(static_cast<int>(i));
    return roots;
  }
  const int chosen = std::max(model_.defaultScene, 0);
  if (static_cast<size_t>(chosen) >= model_.scenes.size())
    source_.fail("scene " + std::to_string(chosen) + " does not exist");
  std::vector<bool> seen(parents_.size());
  for (int root : model_.scenes[static_cast<size_t>(chosen)].nodes) {
    const std::string who = "scene " + std::to_string(chosen) + ": node " + std::to_string(root);
    if (root < 0 || static_cast<size_t>(root) >= parents_.size()) source_.fail(who + " does not exist");
    if (parents_[static_cast<size_t>(root)] != kNone)
      source_.fail(who + " is not a root, it is a child of node " +
                   std::to_string(parents_[static_cast<size_t>(root)]));
    if (seen[static_cast<size_t>(root)]) source_.fail(who + " is listed twice");
    seen[static_cast<size_t>(root)] = true;
    roots.push_back(root);
  }
  return roots;
}

/// Counts the nodes with a mesh that are not below one of these roots.
void Reader::countOutside(const std::vector<int>& roots) {
  const auto hasMesh = [](const tinygltf::Node& node) { return node.mesh >= 0; };
  auto outside = static_cast<uint64_t>(std::ranges::count_if(model_.nodes, hasMesh));
  std::vector<int> below = roots;
  while (!below.empty()) {
    const tinygltf::Node& node = model_.nodes[static_cast<size_t>(below.back())];
    below.pop_back();
    outside -= hasMesh(node) ? 1 : 0;
    below.insert(below.end(), node.children.begin(), node.children.end());
  }
  if (outside > 0) leftOut_.add("nodes with a mesh that are not in the scene which the file shows", outside);
}

void Reader::readNodes() {
  // An explicit stack: recursion through a chain of a million nodes would overflow the call stack.
  struct Visit {
    int node;
    Transform parent;
    StatedClass stated;  // by the nearest node above
  };
  std::vector<Visit> stack;
  const std::vector<int> roots = this->roots();
  countOutside(roots);
  for (auto root = roots.rbegin(); root != roots.rend(); ++root) stack.push_back({*root, {}, {}});
  while (!stack.empty()) {
    const Visit visit = std::move(stack.back());
    stack.pop_back();
    const tinygltf::Node& node = model_.nodes[static_cast<size_t>(visit.node)];
    const Transform transform = visit.parent * localTransform(node);
    if (node.extras.IsObject() && node.extras.Has("hidden")) continue;
    const StatedClass own = classIn(node.extras), stated = own.stated() ? own : visit.stated;
    if (node.mesh >= 0) place(static_cast<size_t>(visit.node), transform, stated);
    for (auto child = node.children.rbegin(); child != node.children.rend(); ++child)
      stack.push_back({*child, transform, stated});
  }
}

void Reader::add(const GltfPlacement& placement, const Transform& transform, const StatedClass& stated,
                 const std::string& who) {
  if (!allFinite(transform.rows)) source_.fail(who + ": its transform is not finite");
  const tinygltf::Node& node = model_.nodes[placement.node];
  scene_.instances.push_back({node.name, static_cast<uint32_t>(node.mesh), transform, stated.id, stated.name});
  placements_.push_back(placement);
}

void Reader::place(size_t index, const Transform& transform, const StatedClass& byNodes) {
  const tinygltf::Node& node = model_.nodes[index];
  const std::string who = gltfLabel("node", index, node.name);
  if (static_cast<size_t>(node.mesh) >= model_.meshes.size())
    source_.fail(who + ": mesh " + std::to_string(node.mesh) + " does not exist");
  const StatedClass stated = byNodes.stated() ? byNodes : classIn(model_.meshes[static_cast<size_t>(node.mesh)].extras);
  const auto instancing = node.extensions.find("EXT_mesh_gpu_instancing");
  if (instancing == node.extensions.end()) return add({index}, transform, stated, who);

  const tinygltf::Value& attributes = instancing->second.Get("attributes");
  const std::vector<std::string> names = attributes.Keys();
  if (names.empty()) return add({index}, transform, stated, who);
  const auto user = [&](const std::string& name) { return who + ", instances, " + name; };
  const auto countOf = [&](const std::string& name) {
    return arrays_.count(attributes.Get(name).GetNumberAsInt(), user(name));
  };
  const size_t count = countOf(names[0]);
  for (const std::string& name : names)
    if (const size_t other = countOf(name); other != count)
      source_.fail(who + ": " + name + " has " + std::to_string(other) + " instances, " + names[0] + " has " +
                   std::to_string(count));
  const auto attribute = [&](const char* name, int components) {
    return attributes.Has(name) ? arrays_.vectors(attributes.Get(name).GetNumberAsInt(), components, user(name))
                                : std::vector<double>();
  };
  const std::vector<double> translations = attribute("TRANSLATION", 3);
  const std::vector<double> rotations = attribute("ROTATION", 4);
  const std::vector<double> scales = attribute("SCALE", 3);
  arrays_.charge(count, sizeof(Instance), who);
  for (size_t i = 0; i < count; ++i) {
    const Transform offset = composed(translations.empty() ? Vec3{} : vector(&translations[3 * i]),
                                      rotations.empty() ? Quaternion{} : quaternion(&rotations[4 * i]),
                                      scales.empty() ? Vec3{1, 1, 1} : vector(&scales[3 * i]));
    add({index, true, offset}, transform * offset, stated, who + ", instance " + std::to_string(i));
  }
}

/// Gives the instances the order that the nodes of a file of writeGlb() state. Others come after them, as they are.
void Reader::sortInstances() {
  constexpr int kLast = std::numeric_limits<int>::max();
  const auto numberOf = [&](size_t i) {
    const tinygltf::Value& extras = model_.nodes[placements_[i].node].extras;
    return extras.IsObject() && extras.Has(kInstanceExtra) ? extras.Get(kInstanceExtra).GetNumberAsInt() : kLast;
  };
  std::vector<std::pair<int, size_t>> order;
  for (size_t i = 0; i < placements_.size(); ++i) order.emplace_back(numberOf(i), i);
  if (std::is_sorted(order.begin(), order.end())) return;
  std::sort(order.begin(), order.end());
  std::vector<Instance> instances;
  std::vector<GltfPlacement> placements;
  for (const auto& [number, i] : order) {
    instances.push_back(std::move(scene_.instances[i]));
    placements.push_back(placements_[i]);
  }
  scene_.instances = std::move(instances);
  placements_ = std::move(placements);
}

/// Reads only the meshes that the scene places, in the order of the file.
void Reader::readMeshes() {
  std::vector<uint32_t> newIndex(model_.meshes.size(), 0);
  std::vector<GltfMeshUse> uses(model_.meshes.size());
  for (size_t i = 0; i < placements_.size(); ++i) {
    GltfMeshUse& use = uses[scene_.instances[i].mesh];
    use.placed = true;
    use.skinned = use.skinned || (model_.nodes[placements_[i].node].skin >= 0 && !placements_[i].instanced);
  }
  const auto textures = readGltfImages(file_, arrays_, source_, scene_, leftOut_);
  scene_.meshes = readGltfMeshes(model_, arrays_, source_, uses, textures, scene_.materials, leftOut_);
  for (size_t i = 0, next = 0; i < uses.size(); ++i)
    if (uses[i].placed) newIndex[i] = static_cast<uint32_t>(next++);
  for (Instance& instance : scene_.instances) instance.mesh = newIndex[instance.mesh];
}

}  // namespace

Scene readGltf(Bytes bytes, const Source& source) {
  GltfFile file = parseGltf(bytes, source);
  return Reader(file, bytes, source).read();
}

}  // namespace gnosphere
