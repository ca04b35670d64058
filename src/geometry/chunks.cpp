// SPDX-License-Identifier: Apache-2.0
#include "geometry/chunks.hpp"

#include <algorithm>
#include <bit>
#include <glm/gtc/packing.hpp>

#include "gnosphere/error.hpp"

namespace gnosphere {
namespace {

// Runs of clusters, vertices and triangles that belong to groups first..end.
struct Run {
  size_t clusterFirst, clusterEnd, vertexFirst, vertexEnd, triangleFirst, triangleEnd;
};

Run runOf(const FlatScene& flat, size_t first, size_t end) {
  const size_t clusterFirst = flat.groups[first].firstCluster, clusterEnd = flat.groups[end].firstCluster;
  const FlatCluster &from = flat.clusters[clusterFirst], &to = flat.clusters[clusterEnd];
  return {clusterFirst, clusterEnd, from.firstVertex, to.firstVertex, from.firstTriangle, to.firstTriangle};
}

// The end of the longest run of groups from `first` on whose arrays all fit into one buffer each.
size_t chunkEnd(const FlatScene& flat, size_t first, uint64_t limit) {
  size_t end = first;
  while (end + 1 < flat.groups.size()) {
    const Run run = runOf(flat, first, end + 1);
    const size_t triangles = run.triangleEnd - run.triangleFirst, vertices = run.vertexEnd - run.vertexFirst;
    const uint64_t largest = std::max({vertices * 3 * sizeof(float), triangles * sizeof(FlatTriangle),
                                       (run.clusterEnd - run.clusterFirst) * sizeof(gpu::Cluster)});
    if (largest > limit || triangles > gpu::kChunkTriangles || vertices > gpu::kChunkVertices) break;
    ++end;
  }
  if (end == first)
    throw Error(ErrorCode::outOfMemory,
                "the device allows buffers of " + std::to_string(limit) + " bytes, less than one group of triangles");
  return end;
}

float bits(size_t value) {
  return std::bit_cast<float>(static_cast<uint32_t>(value));
}

// A group and a cluster of the run, their places counted from the run's start.
gpu::Group packed(const FlatGroup& group, const Run& run) {
  return {{group.low[0], group.low[1], group.low[2], bits(group.firstCluster - run.clusterFirst)},
          {group.high[0], group.high[1], group.high[2], bits(group.clusterCount)}};
}

// `next` is the cluster after it.
gpu::Cluster packed(const FlatCluster& cluster, const FlatCluster& next, const Run& run) {
  const size_t vertices = (cluster.firstVertex - run.vertexFirst) | (next.firstVertex - cluster.firstVertex) << 25;
  const size_t triangles = (cluster.firstTriangle - run.triangleFirst) | size_t{cluster.triangleCount} << 24 |
                           size_t{cluster.doubleSided} << 31;
  return {{cluster.low[0], cluster.low[1], cluster.low[2], bits(vertices)},
          {cluster.high[0], cluster.high[1], cluster.high[2], bits(triangles)},
          {cluster.cone.axis[0], cluster.cone.axis[1], cluster.cone.axis[2],
           bits(glm::packHalf2x16({cluster.cone.sine, cluster.cone.thinness}))}};
}

}  // namespace

Chunks::Chunks(const Scene& scene, uint64_t maxBytes) : firsts_{0}, flat_(flatten(scene)) {
  FlatCluster end;
  end.firstVertex = flat_.vertices.size();
  end.firstTriangle = flat_.triangles.size();
  FlatGroup endGroup;
  endGroup.firstCluster = static_cast<uint32_t>(flat_.clusters.size());
  flat_.clusters.push_back(end);
  flat_.groups.push_back(endGroup);
  while (firsts_.back() + 1 < flat_.groups.size()) firsts_.push_back(chunkEnd(flat_, firsts_.back(), maxBytes));
}

ChunkArrays Chunks::arrays(size_t chunk) const {
  const size_t first = firsts_[chunk], end = firsts_[chunk + 1];
  const Run run = runOf(flat_, first, end);
  const auto slice = [](const auto& values, size_t from, size_t to) {
    return std::vector(values.begin() + static_cast<ptrdiff_t>(from), values.begin() + static_cast<ptrdiff_t>(to));
  };
  ChunkArrays arrays;
  for (size_t i = first; i < end; ++i) arrays.groups.push_back(packed(flat_.groups[i], run));
  for (size_t i = run.clusterFirst; i < run.clusterEnd; ++i)
    arrays.clusters.push_back(packed(flat_.clusters[i], flat_.clusters[i + 1], run));
  arrays.positions = slice(flat_.positions, 3 * run.vertexFirst, 3 * run.vertexEnd);
  arrays.triangleCorners = slice(flat_.triangles, run.triangleFirst, run.triangleEnd);
  return arrays;
}

ChunkSurfaces Chunks::surfaces(size_t chunk, const Scene& scene, bool holes) const {
  const size_t first = firsts_[chunk], end = firsts_[chunk + 1];
  const Run run = runOf(flat_, first, end);
  ChunkSurfaces result;
  for (size_t i = run.clusterFirst; i < run.clusterEnd; ++i)
    result.clusterMaterials.push_back(flat_.clusters[i].material);
  result.meshPlaces.assign(scene.meshes.size() + 1, gpu::kNone);  // the last: of a removed instance
  for (size_t i = 0; i < scene.meshes.size(); ++i) {
    const FlatMesh& mesh = flat_.meshes[i];
    const size_t from = std::max<size_t>(first, mesh.firstGroup);
    const size_t to = std::min<size_t>(end, size_t{mesh.firstGroup} + mesh.groupCount);
    if (from >= to) continue;
    std::vector<uint32_t>& places = result.trianglePlaces;
    result.meshPlaces[i] = static_cast<uint32_t>(places.size());
    places.resize(places.size() + scene.meshes[i].triangleCount(), gpu::kNone);
    const Run piece = runOf(flat_, from, to);
    placeTriangles({chunk, from - first, piece.clusterFirst - run.clusterFirst, piece.vertexFirst - run.vertexFirst,
                    piece.triangleFirst - run.triangleFirst},
                   std::span(flat_.triangles).subspan(piece.triangleFirst, piece.triangleEnd - piece.triangleFirst),
                   std::span(places).subspan(result.meshPlaces[i]));
    if (holes)
      for (size_t k = piece.vertexFirst; k < piece.vertexEnd; ++k)
        for (size_t axis = 0; axis < 2; ++axis)
          result.textureCoordinates.push_back(
              scene.meshes[i].uvs.empty() ? 0.0f : scene.meshes[i].uvs[2 * size_t{flat_.vertices[k]} + axis]);
  }
  return result;
}

void Chunks::placeTriangles(const ChunkPart& part, std::span<const FlatTriangle> triangles,
                            std::span<uint32_t> places) const {
  const size_t chunkFirst = flat_.groups[firsts_[part.chunk]].firstCluster;
  const size_t firstTriangle = flat_.clusters[chunkFirst + part.cluster].firstTriangle;
  size_t cluster = chunkFirst + part.cluster;
  for (size_t i = 0; i < triangles.size(); ++i) {
    if (firstTriangle + i == flat_.clusters[cluster + 1].firstTriangle) ++cluster;
    places[triangles[i].index] = static_cast<uint32_t>((cluster - chunkFirst) * gpu::kClusterTriangles + firstTriangle +
                                                       i - flat_.clusters[cluster].firstTriangle);
  }
}

void Chunks::dropArrays() {
  flat_.positions = {};
  flat_.triangles = {};
}

void Chunks::addTo(InstanceTable& instances, const Scene& scene) const {
  for (size_t i = 0; i < scene.meshes.size(); ++i) {
    const FlatMesh& mesh = flat_.meshes[i];
    MeshSummary summary;
    summary.origin = scene.meshes[i].origin;
    summary.triangles = static_cast<uint32_t>(scene.meshes[i].triangleCount());
    summarize(i, summary);
    for (uint32_t chunk = 0; chunk < count(); ++chunk) {
      const size_t from = std::max<size_t>(firsts_[chunk], mesh.firstGroup);
      const size_t to = std::min<size_t>(firsts_[chunk + 1], mesh.firstGroup + mesh.groupCount);
      if (from >= to) continue;
      const uint32_t clusters = flat_.groups[to].firstCluster - flat_.groups[from].firstCluster;
      summary.runs.push_back(
          {chunk, static_cast<uint32_t>(from - firsts_[chunk]), static_cast<uint32_t>(to - from), clusters});
    }
    instances.addMesh(std::move(summary));
  }
  for (size_t i = 0; i < scene.instances.size(); ++i)
    instances.set(i, scene.instances[i].mesh, scene.instances[i].transform);
}

// What changes with the positions.
void Chunks::summarize(size_t index, MeshSummary& summary) const {
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

void Chunks::setPositions(size_t index, std::span<const float> positions, InstanceTable& instances,
                          const std::function<std::vector<FlatTriangle>(const ChunkPart& part, size_t count)>& read,
                          const std::function<void(const ChunkPart& part, const ChunkArrays& arrays)>& write) {
  MeshSummary summary = instances.mesh(index);
  flat_.meshes[index].nonFinite = flat_.meshes[index].degenerate = 0;
  for (const MeshSummary::Run& piece : summary.runs) {
    const size_t chunkFirst = firsts_[piece.chunk], first = chunkFirst + piece.first, end = first + piece.count;
    const Run all = runOf(flat_, chunkFirst, firsts_[piece.chunk + 1]), run = runOf(flat_, first, end);
    const ChunkPart part = {piece.chunk, piece.first, run.clusterFirst - all.clusterFirst,
                            run.vertexFirst - all.vertexFirst, run.triangleFirst - all.triangleFirst};
    ChunkArrays moved;
    for (size_t i = run.vertexFirst; i < run.vertexEnd; ++i) {
      const float* position = &positions[3 * size_t{flat_.vertices[i]}];
      moved.positions.insert(moved.positions.end(), position, position + 3);
    }
    moved.triangleCorners = read(part, run.triangleEnd - run.triangleFirst);
    for (size_t i = run.clusterFirst; i < run.clusterEnd; ++i) {
      FlatCluster& cluster = flat_.clusters[i];
      const size_t count = flat_.clusters[i + 1].firstTriangle - cluster.firstTriangle;
      fit(cluster, &moved.positions[3 * (cluster.firstVertex - run.vertexFirst)],
          std::span(moved.triangleCorners).subspan(cluster.firstTriangle - run.triangleFirst, count),
          flat_.meshes[index]);
      moved.clusters.push_back(packed(cluster, flat_.clusters[i + 1], all));
    }
    for (size_t i = first; i < end; ++i) {
      FlatGroup& group = flat_.groups[i];
      fit(group, std::span(flat_.clusters).subspan(group.firstCluster, group.clusterCount));
      moved.groups.push_back(packed(group, all));
    }
    write(part, moved);
  }
  summarize(index, summary);
  instances.setMesh(index, std::move(summary));
}

}  // namespace gnosphere
