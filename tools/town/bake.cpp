// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "gnosphere/error.hpp"
#include "town/geometry.hpp"
#include "town/town.hpp"

namespace gnosphere {
namespace {

using namespace town;

constexpr double kTile = 64;                   ///< metres
constexpr size_t kMostTriangles = 1'000'000;   ///< of one mesh, except for instances that have more by themselves
constexpr uint64_t kMostBytes = 0xF000'0000u;  ///< of vertices and indices, because a GLB ends at 2^32 bytes

uint64_t bytesOf(const Mesh& mesh) {
  return mesh.positions.size() * sizeof(float) + mesh.indices.size() * sizeof(uint32_t);
}

void checkSize(const Scene& scene) {
  uint64_t bytes = 0;
  for (const Instance& instance : scene.instances) bytes += bytesOf(scene.meshes[instance.mesh]);
  if (bytes <= kMostBytes) return;
  const double share = static_cast<double>(kMostBytes) / static_cast<double>(bytes);
  const double millions = std::floor(share * static_cast<double>(scene.placedTriangleCount()) / 1e6);
  throw Error(ErrorCode::invalidArgument,
              std::to_string(scene.placedTriangleCount()) + " triangles take " + std::to_string(bytes) +
                  " bytes when baked, and a .glb file ends at 4294967295; bake up to " +
                  std::to_string(static_cast<int>(millions)) + " million, or leave them instanced");
}

/// The instances that become one mesh.
using Tile = std::vector<const Instance*>;

Mesh merged(const Scene& scene, const Tile& tile, const Vec3& centre) {
  Mesh mesh;
  size_t coordinates = 0, indices = 0;
  std::vector<size_t> counts(scene.materials.size());
  for (const Instance* instance : tile) {
    const Mesh& source = scene.meshes[instance->mesh];
    coordinates += source.positions.size();
    indices += source.indices.size();
    for (const MeshPart& part : source.parts) counts[part.material] += part.triangleCount;
  }
  mesh.positions.reserve(coordinates);
  mesh.indices.resize(indices);
  std::vector<size_t> next(counts.size());  // by material: the position of its next index
  size_t first = 0;
  for (size_t material = 0; material < counts.size(); ++material) {
    next[material] = 3 * first;
    if (counts[material] > 0)
      mesh.parts.push_back(
          {static_cast<uint32_t>(first), static_cast<uint32_t>(counts[material]), static_cast<uint32_t>(material)});
    first += counts[material];
  }
  for (const Instance* instance : tile) {
    const Mesh& source = scene.meshes[instance->mesh];
    const uint32_t base = static_cast<uint32_t>(mesh.vertexCount());
    for (size_t v = 0; v < source.vertexCount(); ++v) {
      const float* p = &source.positions[3 * v];
      const Vec3 q = instance->transform * (source.origin + Vec3{p[0], p[1], p[2]}) - centre;
      mesh.positions.insert(mesh.positions.end(),
                            {static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z)});
    }
    for (const MeshPart& part : source.parts)
      for (size_t i = 0; i < size_t{3} * part.triangleCount; ++i)
        mesh.indices[next[part.material]++] = base + source.indices[size_t{3} * part.firstTriangle + i];
  }
  return mesh;
}

}  // namespace

Scene bake(const Scene& scene) {
  checkSize(scene);
  std::map<std::pair<int64_t, int64_t>, Tile> tiles;
  for (const Instance& instance : scene.instances) {
    const auto& rows = instance.transform.rows;
    tiles[{std::llround(rows[3] / kTile), std::llround(rows[7] / kTile)}].push_back(&instance);
  }
  Scene baked;
  baked.materials = scene.materials;
  for (const auto& [key, tile] : tiles) {
    const std::string name = "tile " + std::to_string(key.first) + " " + std::to_string(key.second);
    const Vec3 centre = {kTile * static_cast<double>(key.first), kTile * static_cast<double>(key.second),
                         std::round(tile.front()->transform.rows[11])};
    for (size_t begin = 0, end = 0; begin < tile.size(); begin = end) {
      size_t count = 0;
      do count += scene.meshes[tile[end++]->mesh].triangleCount();
      while (end < tile.size() && count + scene.meshes[tile[end]->mesh].triangleCount() <= kMostTriangles);
      const auto first = tile.begin();
      Mesh mesh = merged(scene, {first + static_cast<ptrdiff_t>(begin), first + static_cast<ptrdiff_t>(end)}, centre);
      mesh.name = name;
      baked.instances.push_back({name, static_cast<uint32_t>(baked.meshes.size()), place(centre)});
      baked.meshes.push_back(std::move(mesh));
    }
  }
  return baked;
}

}  // namespace gnosphere
