// SPDX-License-Identifier: Apache-2.0
#include "geometry/packed_geometry.hpp"

#include <algorithm>
#include <glm/gtc/packing.hpp>

namespace gnosphere {
namespace {

gpu::vec3 vec3Of(const float* v) {
  return {v[0], v[1], v[2]};
}

gpu::Group packed(const FlatGroup& group) {
  return {vec3Of(group.low), group.firstCluster, vec3Of(group.high), group.clusterCount};
}

// `next` is the cluster that follows it.
gpu::Cluster packed(const FlatCluster& cluster, const FlatCluster& next) {
  return {vec3Of(cluster.low),
          static_cast<uint32_t>(cluster.firstVertex),
          vec3Of(cluster.high),
          static_cast<uint32_t>(cluster.firstTriangle),
          {cluster.cone.axis[0], cluster.cone.axis[1], cluster.cone.axis[2]},
          glm::packHalf2x16({cluster.cone.sine, cluster.cone.thinness}),
          static_cast<uint32_t>(next.firstVertex - cluster.firstVertex),
          cluster.triangleCount,
          cluster.doubleSided,
          cluster.material};
}

template <typename T>
std::span<const std::byte> bytesOf(const std::vector<T>& values) {
  return std::as_bytes(std::span(values));
}

}  // namespace

std::vector<gpu::Group> PackedGeometry::groups() const {
  std::vector<gpu::Group> result;
  for (size_t i = 0; i + 1 < flat_.groups.size(); ++i) result.push_back(packed(flat_.groups[i]));
  return result;
}

std::vector<gpu::Cluster> PackedGeometry::clusters() const {
  std::vector<gpu::Cluster> result;
  for (size_t i = 0; i < clusterCount(); ++i) result.push_back(packed(flat_.clusters[i], flat_.clusters[i + 1]));
  return result;
}

// Has one entry more than there are meshes: the empty mesh of removed instances.
std::vector<uint32_t> PackedGeometry::meshTriangles() const {
  std::vector<uint32_t> result = {0};
  for (const FlatMesh& mesh : flat_.meshes) {
    const size_t first = flat_.groups[mesh.firstGroup].firstCluster;
    const size_t end = flat_.groups[mesh.firstGroup + mesh.groupCount].firstCluster;
    result.push_back(
        static_cast<uint32_t>(result.back() + flat_.clusters[end].firstTriangle - flat_.clusters[first].firstTriangle));
  }
  return result;
}

std::vector<uint32_t> PackedGeometry::triangleSlots() const {
  const std::vector<uint32_t> firsts = meshTriangles();
  std::vector<uint32_t> result(firsts.back());
  for (size_t i = 0; i < flat_.meshes.size(); ++i) {
    const size_t cluster = flat_.groups[flat_.meshes[i].firstGroup].firstCluster, count = firsts[i + 1] - firsts[i];
    findSlots(i, std::span(flat_.triangles).subspan(flat_.clusters[cluster].firstTriangle, count),
              std::span(result).subspan(firsts[i], count));
  }
  return result;
}

std::vector<float> PackedGeometry::textureCoordinates(const Scene& scene) const {
  std::vector<float> result(2 * flat_.vertices.size());
  for (size_t i = 0; i < flat_.meshes.size(); ++i) {
    const FlatMesh& mesh = flat_.meshes[i];
    const std::vector<float>& uvs = scene.meshes[i].uvs;
    if (uvs.empty()) continue;
    const size_t first = flat_.clusters[flat_.groups[mesh.firstGroup].firstCluster].firstVertex;
    const size_t end = flat_.clusters[flat_.groups[mesh.firstGroup + mesh.groupCount].firstCluster].firstVertex;
    for (size_t k = first; k < end; ++k) std::copy_n(&uvs[2 * size_t{flat_.vertices[k]}], 2, &result[2 * k]);
  }
  return result;
}

// `triangles` are all triangles of the mesh, in the order of its clusters.
void PackedGeometry::findSlots(size_t mesh, std::span<const FlatTriangle> triangles, std::span<uint32_t> slots) const {
  size_t cluster = flat_.groups[flat_.meshes[mesh].firstGroup].firstCluster;
  const size_t first = flat_.clusters[cluster].firstTriangle;
  for (size_t i = 0; i < triangles.size(); ++i) {
    if (first + i == flat_.clusters[cluster + 1].firstTriangle) ++cluster;
    slots[triangles[i].index] =
        static_cast<uint32_t>(cluster * gpu::kClusterTriangles + first + i - flat_.clusters[cluster].firstTriangle);
  }
}

void PackedGeometry::dropArrays() {
  flat_.positions = {};
  flat_.triangles = {};
}

void PackedGeometry::addTo(InstanceTable& instances, const Scene& scene) const {
  for (size_t i = 0; i < scene.meshes.size(); ++i) {
    const FlatMesh& mesh = flat_.meshes[i];
    MeshSummary summary;
    summary.origin = scene.meshes[i].origin;
    summary.triangles = static_cast<uint32_t>(scene.meshes[i].triangleCount());
    summary.firstGroup = mesh.firstGroup;
    summary.groups = mesh.groupCount;
    summary.clusters =
        flat_.groups[mesh.firstGroup + mesh.groupCount].firstCluster - flat_.groups[mesh.firstGroup].firstCluster;
    summarize(i, summary);
    instances.addMesh(std::move(summary));
  }
  for (size_t i = 0; i < scene.instances.size(); ++i)
    instances.set(i, scene.instances[i].mesh, scene.instances[i].transform);
}

// Updates the parts of a mesh's summary that depend on its positions.
void PackedGeometry::summarize(size_t index, MeshSummary& summary) const {
  const FlatMesh& mesh = flat_.meshes[index];
  summary.nonFinite = mesh.nonFinite;
  summary.degenerate = mesh.degenerate;
  summary.low = glm::dvec3(gpu::kCoordinateLimit);
  summary.high = -summary.low;
  for (size_t i = mesh.firstGroup; i < size_t{mesh.firstGroup} + mesh.groupCount; ++i)
    for (int axis = 0; axis < 3; ++axis) {
      summary.low[axis] = std::min<double>(summary.low[axis], flat_.groups[i].low[axis]);
      summary.high[axis] = std::max<double>(summary.high[axis], flat_.groups[i].high[axis]);
    }
}

void PackedGeometry::setPositions(size_t index, std::span<const float> positions, bool slots, InstanceTable& instances,
                                  SceneMemory& memory) {
  MeshSummary summary = instances.mesh(index);
  FlatMesh& mesh = flat_.meshes[index];
  mesh.nonFinite = mesh.degenerate = 0;
  const size_t groupEnd = mesh.firstGroup + mesh.groupCount;
  const size_t first = flat_.groups[mesh.firstGroup].firstCluster, end = flat_.groups[groupEnd].firstCluster;
  const size_t vertexFirst = flat_.clusters[first].firstVertex, triangleFirst = flat_.clusters[first].firstTriangle;

  std::vector<float> moved;
  for (size_t i = vertexFirst; i < flat_.clusters[end].firstVertex; ++i) {
    const float* position = &positions[3 * size_t{flat_.vertices[i]}];
    moved.insert(moved.end(), position, position + 3);
  }
  std::vector<FlatTriangle> triangles(flat_.clusters[end].firstTriangle - triangleFirst);
  const uint64_t trianglePlace = triangleFirst * sizeof(FlatTriangle);
  memory.read(gpu::Array::triangleCorners, trianglePlace, std::as_writable_bytes(std::span(triangles)));
  std::vector<gpu::Cluster> clusters;
  for (size_t i = first; i < end; ++i) {
    FlatCluster& cluster = flat_.clusters[i];
    const size_t count = flat_.clusters[i + 1].firstTriangle - cluster.firstTriangle;
    fit(cluster, &moved[3 * (cluster.firstVertex - vertexFirst)],
        std::span(triangles).subspan(cluster.firstTriangle - triangleFirst, count), mesh);
    clusters.push_back(packed(cluster, flat_.clusters[i + 1]));
  }
  std::vector<gpu::Group> groups;
  for (size_t i = mesh.firstGroup; i < groupEnd; ++i) {
    FlatGroup& group = flat_.groups[i];
    fit(group, std::span(flat_.clusters).subspan(group.firstCluster, group.clusterCount));
    groups.push_back(packed(group));
  }
  memory.write(gpu::Array::positions, 3 * sizeof(float) * vertexFirst, bytesOf(moved));
  memory.write(gpu::Array::triangleCorners, trianglePlace, bytesOf(triangles));
  memory.write(gpu::Array::clusters, sizeof(gpu::Cluster) * first, bytesOf(clusters));
  memory.write(gpu::Array::groups, sizeof(gpu::Group) * mesh.firstGroup, bytesOf(groups));
  if (slots) {
    std::vector<uint32_t> found(triangles.size());
    findSlots(index, triangles, found);
    memory.write(gpu::Array::triangleSlots, sizeof(uint32_t) * meshTriangles()[index], bytesOf(found));
  }
  summarize(index, summary);
  instances.setMesh(index, std::move(summary));
}

}  // namespace gnosphere
