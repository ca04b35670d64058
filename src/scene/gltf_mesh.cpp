// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <span>
#include <unordered_map>

#include "base/lasting.hpp"
#include "scene/gltf_follow.hpp"

namespace gnosphere {
namespace {

/// The sources of a run of vertices: the accessor of the positions (negative: a Draco primitive) and that of the
/// texture coordinates, with the material whose transform applies to them. Most vertices have no texture coordinates.
struct Vertices {
  int positions = 0;
  int uvs = -1;
  int material = -1;
  GltfFollow follow;
  auto operator<=>(const Vertices&) const = default;
};

/// Triangles of one mesh that index the same vertices.
struct Run {
  Vertices vertices;
  size_t firstIndex = 0, indexCount = 0;
};

class MeshReader {
 public:
  MeshReader(const tinygltf::Model& model, GltfArrays& arrays, const Source& source,
             const std::vector<std::optional<GltfTexture>>& textures, std::vector<Material>& materials,
             LeftOut& leftOut)
      : model_(model),
        arrays_(arrays),
        source_(source),
        textures_(textures),
        materials_(materials),
        leftOut_(leftOut),
        follow_(arrays, source, leftOut) {}

  std::vector<Mesh> read(const std::vector<GltfMeshUse>& uses);

 private:
  Mesh readMesh(size_t index, bool skinned);
  bool isPlaceholder(int mode, int positions) const;
  void readPrimitive(const tinygltf::Primitive& primitive, bool skinned, const std::string& who, Mesh& mesh);
  void appendTriangles(int mode, std::vector<uint32_t>&& list, std::vector<uint32_t>& indices) const;
  void checkRange(const Mesh& mesh, const Run& run, size_t vertexCount, const std::string& who) const;
  void appendVertices(Mesh& mesh, const std::string& who);
  void appendUsedVertices(Mesh& mesh, const std::vector<const Run*>& runs, const std::string& who);
  const std::vector<float>& uvsOf(const Vertices& vertices, size_t vertexCount, const std::string& who);
  void appendUvs(Mesh& mesh, const Vertices& vertices, std::span<const float> uvs);
  const GltfTexture* textureOf(const tinygltf::Primitive& primitive) const;
  uint32_t materialIndex(int material, const std::string& who);

  const tinygltf::Model& model_;
  GltfArrays& arrays_;
  const Source& source_;
  const std::vector<std::optional<GltfTexture>>& textures_;  ///< by material
  std::vector<Material>& materials_;
  LeftOut& leftOut_;
  GltfFollowReader follow_;
  uint32_t defaultMaterial_ = std::numeric_limits<uint32_t>::max();
  std::unordered_map<int, int> meshesOfAccessor_;  ///< key: accessor of POSITION; value: how many meshes use it
  std::vector<Run> runs_;                          ///< runs of the mesh being read
  std::vector<DracoMesh> draco_;  ///< of the mesh being read; Vertices::positions is -2 - i for entry i
};

/// Returns the index of a material. A primitive without one gets glTF's default material, which is added once, as the
/// last.
uint32_t MeshReader::materialIndex(int material, const std::string& who) {
  if (material >= 0) {
    if (static_cast<size_t>(material) >= model_.materials.size())
      source_.fail(who + ": material " + std::to_string(material) + " does not exist");
    return static_cast<uint32_t>(material);
  }
  if (defaultMaterial_ == std::numeric_limits<uint32_t>::max()) {
    defaultMaterial_ = static_cast<uint32_t>(materials_.size());
    Material& added = materials_.emplace_back();
    added.metallic = 1;
    added.doubleSided = false;
  }
  return defaultMaterial_;
}

std::vector<Mesh> MeshReader::read(const std::vector<GltfMeshUse>& uses) {
  for (size_t i = 0; i < model_.meshes.size(); ++i) {
    if (!uses[i].placed) continue;
    std::vector<int> accessors;
    for (const tinygltf::Primitive& primitive : model_.meshes[i].primitives)
      if (const auto found = primitive.attributes.find("POSITION"); found != primitive.attributes.end())
        accessors.push_back(found->second);
    std::sort(accessors.begin(), accessors.end());
    accessors.erase(std::unique(accessors.begin(), accessors.end()), accessors.end());
    for (int accessor : accessors) ++meshesOfAccessor_[accessor];
  }
  std::vector<Mesh> meshes;
  for (size_t i = 0; i < model_.meshes.size(); ++i)
    if (uses[i].placed) meshes.push_back(readMesh(i, uses[i].skinned));
  return meshes;
}

Mesh MeshReader::readMesh(size_t index, bool skinned) {
  const tinygltf::Mesh& from = model_.meshes[index];
  const std::string who = gltfLabel("mesh", index, from.name);
  Mesh mesh;
  mesh.name = from.name;
  runs_.clear();
  draco_.clear();
  for (size_t p = 0; p < from.primitives.size(); ++p)
    readPrimitive(from.primitives[p], skinned, who + ", primitive " + std::to_string(p), mesh);
  size_t sets = 0, targets = 0;
  for (const Run& run : runs_) {
    sets = std::max(sets, run.vertices.follow.joints.size());
    targets = std::max(targets, run.vertices.follow.targets.size());
  }
  mesh.influences = static_cast<uint32_t>(4 * sets);
  mesh.morphTargets.resize(targets);
  appendVertices(mesh, who);
  return mesh;
}

/// Whether a primitive is the point without data that writeGlb() puts in place of an empty mesh.
bool MeshReader::isPlaceholder(int mode, int positions) const {
  if (mode != TINYGLTF_MODE_POINTS || positions < 0 || static_cast<size_t>(positions) >= model_.accessors.size())
    return false;
  const tinygltf::Accessor& accessor = model_.accessors[static_cast<size_t>(positions)];
  return accessor.count == 1 && accessor.bufferView < 0 && !accessor.sparse.isSparse;
}

/// Appends the triangles of a primitive, with indices into its own accessor.
void MeshReader::readPrimitive(const tinygltf::Primitive& primitive, bool skinned, const std::string& who, Mesh& mesh) {
  if (primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN)
    source_.fail(who + ": mode " + std::to_string(primitive.mode) + " does not exist");
  const auto position = primitive.attributes.find("POSITION");
  if (position == primitive.attributes.end()) return;  // it has no surface
  if (primitive.mode < TINYGLTF_MODE_TRIANGLES) {
    if (!isPlaceholder(primitive.mode, position->second)) leftOut_.add(kLinesAndPoints);
    return;
  }

  Run run;
  run.firstIndex = mesh.indices.size();
  size_t vertexCount = 0;
  const GltfTexture* texture = textureOf(primitive);
  const std::string uvName = texture ? "TEXCOORD_" + std::to_string(texture->texCoord) : "";
  const auto uvs = primitive.attributes.find(uvName);
  if (uvs != primitive.attributes.end()) run.vertices.uvs = uvs->second;
  if (texture) run.vertices.material = primitive.material;
  run.vertices.follow = follow_.follow(primitive, skinned, who);
  const auto compression = primitive.extensions.find("KHR_draco_mesh_compression");
  if (compression != primitive.extensions.end()) {
    const tinygltf::Value& attributes = compression->second.Get("attributes");
    if (!attributes.Has("POSITION")) source_.fail(who + ": its Draco data has no POSITION");
    const Bytes bytes = arrays_.view(compression->second.Get("bufferView").GetNumberAsInt(), who);
    DracoIds ids;
    ids.positions = attributes.Get("POSITION").GetNumberAsInt();
    if (attributes.Has(uvName)) ids.uvs = attributes.Get(uvName).GetNumberAsInt();
    follow_.addDracoIds(attributes, run.vertices.follow, who, ids);
    DracoMesh& draco = draco_.emplace_back(decodeDraco(bytes, ids, who, source_));
    arrays_.charge(draco.joints.size() * draco.positions.size(), 11, who);
    arrays_.charge(draco.positions.size() + draco.uvs.size() + draco.indices.size(), 4, who);
    run.vertices.positions = -1 - static_cast<int>(draco_.size());
    vertexCount = draco.positions.size() / 3;
    mesh.indices.insert(mesh.indices.end(), draco.indices.begin(), draco.indices.end());
  } else {
    run.vertices.positions = position->second;
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
  // An incomplete last triangle is dropped, as on a GPU.
  run.indexCount = (mesh.indices.size() - run.firstIndex) / 3 * 3;
  mesh.indices.resize(run.firstIndex + run.indexCount);
  checkRange(mesh, run, vertexCount, who);
  if (run.indexCount == 0) return;
  runs_.push_back(run);
  mesh.parts.push_back({static_cast<uint32_t>(run.firstIndex / 3), static_cast<uint32_t>(run.indexCount / 3),
                        materialIndex(primitive.material, who)});
}

/// Appends a list, strip or fan as single triangles. Every second triangle of a strip is reversed so that all face the
/// same way (glTF 2.0, 3.7.2.1).
void MeshReader::appendTriangles(int mode, std::vector<uint32_t>&& list, std::vector<uint32_t>& indices) const {
  if (mode == TINYGLTF_MODE_TRIANGLES) {
    if (indices.empty()) {
      indices = std::move(list);
    } else {
      indices.resize(indices.size() + list.size());
      std::copy(list.begin(), list.end(), indices.end() - static_cast<ptrdiff_t>(list.size()));
    }
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

void MeshReader::checkRange(const Mesh& mesh, const Run& run, size_t vertexCount, const std::string& who) const {
  for (size_t i = run.firstIndex; i < mesh.indices.size(); ++i)
    if (mesh.indices[i] >= vertexCount)
      source_.fail(who + ": index " + std::to_string(mesh.indices[i]) + " is out of range, " +
                   (run.vertices.positions >= 0 ? "accessor " + std::to_string(run.vertices.positions)
                                                : std::string("its Draco data")) +
                   " has " + std::to_string(vertexCount) + " vertices");
}

/// Returns how the alpha image of the primitive's material is mapped; null if it has none.
const GltfTexture* MeshReader::textureOf(const tinygltf::Primitive& primitive) const {
  const auto material = static_cast<size_t>(primitive.material);
  return primitive.material >= 0 && material < textures_.size() && textures_[material] ? &*textures_[material]
                                                                                       : nullptr;
}

/// Appends the vertices of all runs. Primitives that share accessors share their vertices; those that share only the
/// accessor of positions, as with holes and without, have the vertices that each uses.
void MeshReader::appendVertices(Mesh& mesh, const std::string& who) {
  std::map<Vertices, uint32_t> firstVertex;
  std::map<int, Vertices> ofAccessor;
  std::map<Vertices, std::vector<const Run*>> runsOf;
  std::set<int> shared;
  for (const Run& run : runs_) {
    runsOf[run.vertices].push_back(&run);
    if (ofAccessor.emplace(run.vertices.positions, run.vertices).first->second != run.vertices)
      shared.insert(run.vertices.positions);
  }
  for (const Run& run : runs_) {
    const int accessor = run.vertices.positions;
    if (accessor >= 0 && (meshesOfAccessor_[accessor] > 1 || shared.contains(accessor))) {
      if (const auto& runs = runsOf[run.vertices]; runs.front() == &run) appendUsedVertices(mesh, runs, who);
      continue;
    }
    const auto [found, isNew] = firstVertex.emplace(run.vertices, static_cast<uint32_t>(mesh.vertexCount()));
    if (isNew) {
      DracoMesh* draco = accessor < 0 ? &draco_[static_cast<size_t>(-2 - accessor)] : nullptr;
      std::vector<float> positions =
          draco ? std::move(draco->positions) : arrays_.floats(accessor, 3, "positions", who);
      const size_t count = positions.size() / 3;
      if (mesh.vertexCount() + count > std::numeric_limits<uint32_t>::max())
        source_.fail(who + " has more than 4294967295 vertices");
      if (mesh.positions.empty())
        mesh.positions = std::move(positions);
      else
        mesh.positions.insert(mesh.positions.end(), positions.begin(), positions.end());
      if (run.vertices.material >= 0)
        appendUvs(mesh, run.vertices, draco && !draco->uvs.empty() ? draco->uvs : uvsOf(run.vertices, count, who));
      follow_.append(mesh, run.vertices.follow, draco, nullptr, count, who);
    }
    if (found->second == 0) continue;
    for (size_t i = 0; i < run.indexCount; ++i) mesh.indices[run.firstIndex + i] += found->second;
  }
  if (!mesh.uvs.empty()) mesh.uvs.resize(2 * mesh.vertexCount());
}

/// Returns the texture coordinates of an accessor as the file has them; empty if there is none.
const std::vector<float>& MeshReader::uvsOf(const Vertices& vertices, size_t vertexCount, const std::string& who) {
  static const auto& kNoUvs = lasting(std::vector<float>());
  if (vertices.uvs < 0) return kNoUvs;
  const std::vector<float>& uvs = arrays_.keptFloats(vertices.uvs, 2, "texture coordinates", who);
  if (uvs.size() != 2 * vertexCount)
    source_.fail(who + ": accessor " + std::to_string(vertices.uvs) + " has texture coordinates for " +
                 std::to_string(uvs.size() / 2) + " vertices, there are " + std::to_string(vertexCount));
  return uvs;
}

/// Sets texture coordinates of the last vertices of the mesh, transformed by their material. Vertices without any get
/// 0, as on a GPU.
void MeshReader::appendUvs(Mesh& mesh, const Vertices& vertices, std::span<const float> uvs) {
  const std::array<double, 6>& m = textures_[static_cast<size_t>(vertices.material)]->transform;
  mesh.uvs.resize(2 * mesh.vertexCount());
  float* out = mesh.uvs.data() + mesh.uvs.size() - uvs.size();
  for (size_t i = 0; i < uvs.size(); i += 2) {
    const double u = uvs[i], v = uvs[i + 1];
    out[i] = static_cast<float>(m[0] * u + m[1] * v + m[2]);
    out[i + 1] = static_cast<float>(m[3] * u + m[4] * v + m[5]);
  }
}

/// Copies the vertices that the runs, all of the same sources, use, and no others. Some exporters put the vertices of
/// all meshes into one accessor, and a thousand meshes must not hold a thousand copies of it.
void MeshReader::appendUsedVertices(Mesh& mesh, const std::vector<const Run*>& runs, const std::string& who) {
  const Vertices& vertices = runs.front()->vertices;
  const std::vector<float>& all = arrays_.keptFloats(vertices.positions, 3, "positions", who);
  std::vector<uint32_t> used;
  for (const Run* run : runs)
    used.insert(used.end(), &mesh.indices[run->firstIndex], &mesh.indices[run->firstIndex] + run->indexCount);
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  arrays_.charge(used.size(), 12, who);

  const auto base = static_cast<uint32_t>(mesh.vertexCount());
  for (uint32_t vertex : used)
    mesh.positions.insert(mesh.positions.end(), &all[3 * size_t{vertex}], &all[3 * size_t{vertex}] + 3);
  if (vertices.material >= 0) {
    const std::vector<float>& uvs = uvsOf(vertices, all.size() / 3, who);
    std::vector<float> usedUvs;
    if (!uvs.empty())
      for (uint32_t vertex : used)
        usedUvs.insert(usedUvs.end(), {uvs[2 * size_t{vertex}], uvs[2 * size_t{vertex} + 1]});
    appendUvs(mesh, vertices, usedUvs);
  }
  follow_.append(mesh, vertices.follow, nullptr, &used, all.size() / 3, who);
  for (const Run* run : runs)
    for (size_t i = run->firstIndex; i < run->firstIndex + run->indexCount; ++i)
      mesh.indices[i] =
          base + static_cast<uint32_t>(std::lower_bound(used.begin(), used.end(), mesh.indices[i]) - used.begin());
}

}  // namespace

std::string gltfLabel(const char* what, size_t index, const std::string& name) {
  std::string text = std::string(what) + " " + std::to_string(index);
  if (!name.empty()) text.append(" ").append(inQuotes(name));
  return text;
}

std::vector<Mesh> readGltfMeshes(const tinygltf::Model& model, GltfArrays& arrays, const Source& source,
                                 const std::vector<GltfMeshUse>& uses,
                                 const std::vector<std::optional<GltfTexture>>& textures,
                                 std::vector<Material>& materials, LeftOut& leftOut) {
  return MeshReader(model, arrays, source, textures, materials, leftOut).read(uses);
}

}  // namespace gnosphere
