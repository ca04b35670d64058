// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "scene/gltf_accessor.hpp"

namespace gnosphere {
namespace {

constexpr int kNone = -1;

std::string label(const char* what, size_t index, const std::string& name) {
  std::string text = std::string(what) + " " + std::to_string(index);
  if (!name.empty()) text.append(" ").append(inQuotes(name));
  return text;
}

/// Extensions that change what geometry there is, and that we read. Those that only change how a surface looks may be
/// required as well: they cannot move a triangle.
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

/// Translation after rotation after scale. The quaternion need not be of unit length: it may be quantised.
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
      : model_(file.model), arrays_(file, bytes, source), source_(source) {}

  Scene read() {
    checkRequiredExtensions(model_, source_);
    for (const tinygltf::Material& material : model_.materials) scene_.materials.push_back(readMaterial(material));
    readNodes();
    readMeshes();
    return std::move(scene_);
  }

 private:
  /// Triangles of one mesh that index the vertices of one accessor (or of one Draco primitive, then negative).
  struct Run {
    int vertices = kNone;
    size_t firstIndex = 0, indexCount = 0;
  };

  Material readMaterial(const tinygltf::Material& from) const;
  std::vector<int> parents() const;
  std::vector<int> roots(const std::vector<int>& parents) const;
  void readNodes();
  void place(size_t node, const Transform& transform);
  void add(const tinygltf::Node& node, const Transform& transform, const std::string& who);
  void readMeshes();
  Mesh readMesh(size_t index);
  void readPrimitive(const tinygltf::Primitive& primitive, const std::string& who, Mesh& mesh);
  void appendTriangles(int mode, std::vector<uint32_t>&& list, std::vector<uint32_t>& indices) const;
  void checkRange(const Mesh& mesh, const Run& run, size_t vertexCount, const std::string& who) const;
  void appendVertices(Mesh& mesh, const std::string& who);
  void appendUsedVertices(Mesh& mesh, int accessor, const std::string& who);
  uint32_t materialIndex(int material, const std::string& who);

  const tinygltf::Model& model_;
  GltfArrays arrays_;
  const Source& source_;
  Scene scene_;
  uint32_t defaultMaterial_ = std::numeric_limits<uint32_t>::max();
  std::unordered_map<int, int> meshesOfAccessor_;                ///< how many meshes use a POSITION accessor
  std::unordered_map<int, std::vector<float>> sharedPositions_;  ///< those of more than one
  std::vector<Run> runs_;                                        ///< of the mesh being read
  std::vector<DracoMesh> draco_;                                 ///< of the mesh being read; run -2 - i
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

/// A primitive without material has the specification's default one, which is added once and last.
uint32_t Reader::materialIndex(int material, const std::string& who) {
  if (material >= 0) {
    if (static_cast<size_t>(material) >= model_.materials.size())
      source_.fail(who + ": material " + std::to_string(material) + " does not exist");
    return static_cast<uint32_t>(material);
  }
  if (defaultMaterial_ == std::numeric_limits<uint32_t>::max()) {
    defaultMaterial_ = static_cast<uint32_t>(scene_.materials.size());
    Material& added = scene_.materials.emplace_back();
    added.metallic = 1;
    added.doubleSided = false;
  }
  return defaultMaterial_;
}

std::vector<int> Reader::parents() const {
  const size_t count = model_.nodes.size();
  std::vector<int> parents(count, kNone);
  for (size_t i = 0; i < count; ++i)
    for (int child : model_.nodes[i].children) {
      if (child < 0 || static_cast<size_t>(child) >= count)
        source_.fail(label("node", i, model_.nodes[i].name) + ": child " + std::to_string(child) + " does not exist");
      int& parent = parents[static_cast<size_t>(child)];
      if (parent != kNone)
        source_.fail(label("node", static_cast<size_t>(child), model_.nodes[static_cast<size_t>(child)].name) +
                     " is listed as a child twice, by nodes " + std::to_string(parent) + " and " + std::to_string(i));
      parent = static_cast<int>(i);
    }
  // With one parent each, walking up either ends at a root or comes round.
  std::vector<size_t> walk(count, 0);
  for (size_t i = 0; i < count; ++i) {
    int at = static_cast<int>(i);
    while (at != kNone && walk[static_cast<size_t>(at)] == 0) {
      walk[static_cast<size_t>(at)] = i + 1;
      at = parents[static_cast<size_t>(at)];
    }
    if (at != kNone && walk[static_cast<size_t>(at)] == i + 1)
      source_.fail(label("node", static_cast<size_t>(at), model_.nodes[static_cast<size_t>(at)].name) +
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
  // An own stack: a chain of a million nodes must not end ours.
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
  const std::string who = label("node", index, node.name);
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

void Reader::readMeshes() {
  std::vector<uint32_t> newIndex(model_.meshes.size(), 0);
  for (const Instance& instance : scene_.instances) newIndex[instance.mesh] = 1;
  for (size_t i = 0; i < model_.meshes.size(); ++i) {
    if (newIndex[i] == 0) continue;
    std::vector<int> accessors;
    for (const tinygltf::Primitive& primitive : model_.meshes[i].primitives)
      if (const auto found = primitive.attributes.find("POSITION"); found != primitive.attributes.end())
        accessors.push_back(found->second);
    std::sort(accessors.begin(), accessors.end());
    accessors.erase(std::unique(accessors.begin(), accessors.end()), accessors.end());
    for (int accessor : accessors) ++meshesOfAccessor_[accessor];
  }
  for (size_t i = 0; i < model_.meshes.size(); ++i) {
    if (newIndex[i] == 0) continue;
    newIndex[i] = static_cast<uint32_t>(scene_.meshes.size());
    scene_.meshes.push_back(readMesh(i));
  }
  for (Instance& instance : scene_.instances) instance.mesh = newIndex[instance.mesh];
}

Mesh Reader::readMesh(size_t index) {
  const tinygltf::Mesh& from = model_.meshes[index];
  const std::string who = label("mesh", index, from.name);
  Mesh mesh;
  mesh.name = from.name;
  runs_.clear();
  draco_.clear();
  for (size_t p = 0; p < from.primitives.size(); ++p)
    readPrimitive(from.primitives[p], who + ", primitive " + std::to_string(p), mesh);
  appendVertices(mesh, who);
  return mesh;
}

/// Appends the triangles of a primitive, still indexing the vertices of its own accessor.
void Reader::readPrimitive(const tinygltf::Primitive& primitive, const std::string& who, Mesh& mesh) {
  if (primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN)
    source_.fail(who + ": mode " + std::to_string(primitive.mode) + " does not exist");
  const auto position = primitive.attributes.find("POSITION");
  // Points and lines have no area, and without positions there is nothing to see.
  if (primitive.mode < TINYGLTF_MODE_TRIANGLES || position == primitive.attributes.end()) return;

  Run run;
  run.firstIndex = mesh.indices.size();
  size_t vertexCount = 0;
  const auto compression = primitive.extensions.find("KHR_draco_mesh_compression");
  if (compression != primitive.extensions.end()) {
    const tinygltf::Value& attributes = compression->second.Get("attributes");
    if (!attributes.Has("POSITION")) source_.fail(who + ": its Draco data has no POSITION");
    const Bytes bytes = arrays_.view(compression->second.Get("bufferView").GetNumberAsInt(), who);
    DracoMesh& draco =
        draco_.emplace_back(decodeDraco(bytes, attributes.Get("POSITION").GetNumberAsInt(), who, source_));
    arrays_.charge(draco.positions.size() + draco.indices.size(), 4, who);
    run.vertices = -1 - static_cast<int>(draco_.size());
    vertexCount = draco.positions.size() / 3;
    mesh.indices.insert(mesh.indices.end(), draco.indices.begin(), draco.indices.end());
  } else {
    run.vertices = position->second;
    vertexCount = arrays_.count(position->second, who);
    const auto indices = primitive.attributes.find(kIndicesAttribute);
    if (indices != primitive.attributes.end() && primitive.mode == TINYGLTF_MODE_TRIANGLES) {
      arrays_.appendIndices(indices->second, who, mesh.indices);
    } else {
      std::vector<uint32_t> list;
      if (indices != primitive.attributes.end()) {
        arrays_.appendIndices(indices->second, who, list);
      } else {
        arrays_.charge(vertexCount, 4, who);
        list.resize(vertexCount);
        for (size_t i = 0; i < vertexCount; ++i) list[i] = static_cast<uint32_t>(i);
      }
      appendTriangles(primitive.mode, std::move(list), mesh.indices);
    }
  }
  // What is left of an incomplete last triangle is not drawn, as on a GPU.
  run.indexCount = (mesh.indices.size() - run.firstIndex) / 3 * 3;
  mesh.indices.resize(run.firstIndex + run.indexCount);
  checkRange(mesh, run, vertexCount, who);
  if (run.indexCount == 0) return;
  runs_.push_back(run);
  mesh.parts.push_back({static_cast<uint32_t>(run.firstIndex / 3), static_cast<uint32_t>(run.indexCount / 3),
                        materialIndex(primitive.material, who)});
}

/// glTF 2.0, 3.7.2.1: every second triangle of a strip is turned round so that all face the same way.
void Reader::appendTriangles(int mode, std::vector<uint32_t>&& list, std::vector<uint32_t>& indices) const {
  if (mode == TINYGLTF_MODE_TRIANGLES) {
    if (indices.empty())
      indices = std::move(list);
    else
      indices.insert(indices.end(), list.begin(), list.end());
    return;
  }
  if (list.size() < 3) return;
  indices.reserve(indices.size() + (list.size() - 2) * 3);
  for (size_t i = 0; i + 2 < list.size(); ++i) {
    const bool fan = mode == TINYGLTF_MODE_TRIANGLE_FAN;
    const size_t a = fan ? i + 1 : i;
    const size_t b = fan ? i + 2 : i + 1 + i % 2;
    const size_t c = fan ? 0 : i + 2 - i % 2;
    indices.insert(indices.end(), {list[a], list[b], list[c]});
  }
}

void Reader::checkRange(const Mesh& mesh, const Run& run, size_t vertexCount, const std::string& who) const {
  for (size_t i = run.firstIndex; i < mesh.indices.size(); ++i)
    if (mesh.indices[i] >= vertexCount)
      source_.fail(who + ": index " + std::to_string(mesh.indices[i]) + " is out of range, " +
                   (run.vertices >= 0 ? "accessor " + std::to_string(run.vertices) : std::string("its Draco data")) +
                   " has " + std::to_string(vertexCount) + " vertices");
}

/// Primitives that share an accessor share its vertices, which are in the mesh once.
void Reader::appendVertices(Mesh& mesh, const std::string& who) {
  std::unordered_map<int, uint32_t> firstVertex;
  for (const Run& run : runs_) {
    if (run.vertices >= 0 && meshesOfAccessor_[run.vertices] > 1) {
      if (firstVertex.emplace(run.vertices, 0).second) appendUsedVertices(mesh, run.vertices, who);
      continue;
    }
    const auto [found, isNew] = firstVertex.emplace(run.vertices, static_cast<uint32_t>(mesh.vertexCount()));
    if (isNew) {
      std::vector<float> positions = run.vertices >= 0
                                         ? arrays_.positions(run.vertices, who)
                                         : std::move(draco_[static_cast<size_t>(-2 - run.vertices)].positions);
      if ((mesh.positions.size() + positions.size()) / 3 > std::numeric_limits<uint32_t>::max())
        source_.fail(who + " has more than 4294967295 vertices");
      if (mesh.positions.empty())
        mesh.positions = std::move(positions);
      else
        mesh.positions.insert(mesh.positions.end(), positions.begin(), positions.end());
    }
    if (found->second == 0) continue;
    for (size_t i = 0; i < run.indexCount; ++i) mesh.indices[run.firstIndex + i] += found->second;
  }
}

/// Some exporters put the vertices of every mesh into one accessor. Each mesh then takes those that it uses: a thousand
/// meshes must not hold a thousand copies of all.
void Reader::appendUsedVertices(Mesh& mesh, int accessor, const std::string& who) {
  const auto cached = sharedPositions_.find(accessor);
  const std::vector<float>& all =
      cached != sharedPositions_.end()
          ? cached->second
          : sharedPositions_.emplace(accessor, arrays_.positions(accessor, who)).first->second;
  std::vector<uint32_t> used;
  for (const Run& run : runs_)
    if (run.vertices == accessor)
      used.insert(used.end(), &mesh.indices[run.firstIndex], &mesh.indices[run.firstIndex] + run.indexCount);
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  arrays_.charge(used.size(), 12, who);

  const auto base = static_cast<uint32_t>(mesh.vertexCount());
  mesh.positions.reserve(mesh.positions.size() + 3 * used.size());
  for (uint32_t vertex : used)
    mesh.positions.insert(mesh.positions.end(), &all[3 * size_t{vertex}], &all[3 * size_t{vertex}] + 3);
  for (const Run& run : runs_) {
    if (run.vertices != accessor) continue;
    for (size_t i = run.firstIndex; i < run.firstIndex + run.indexCount; ++i)
      mesh.indices[i] =
          base + static_cast<uint32_t>(std::lower_bound(used.begin(), used.end(), mesh.indices[i]) - used.begin());
  }
}

}  // namespace

Scene readGltf(Bytes bytes, const Source& source) {
  GltfFile file = parseGltf(bytes, source);
  return Reader(file, bytes, source).read();
}

}  // namespace gnosphere
