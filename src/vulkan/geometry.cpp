// SPDX-License-Identifier: Apache-2.0
#include "vulkan/geometry.hpp"

#include <algorithm>
#include <bit>
#include <glm/gtc/packing.hpp>

namespace gnosphere::vulkan {
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
    const size_t triangles = run.triangleEnd - run.triangleFirst;
    const uint64_t largest =
        std::max({(run.vertexEnd - run.vertexFirst) * 3 * sizeof(float), triangles * sizeof(FlatTriangle),
                  (run.clusterEnd - run.clusterFirst) * sizeof(gpu::Cluster)});
    if (largest > limit || triangles > gpu::kChunkTriangles) break;
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

gpu::Cluster packed(const FlatCluster& cluster, const Run& run) {
  const size_t word = (cluster.firstTriangle - run.triangleFirst) | size_t{cluster.triangleCount} << 24 |
                      size_t{cluster.doubleSided} << 31;
  return {{cluster.low[0], cluster.low[1], cluster.low[2], bits(cluster.firstVertex - run.vertexFirst)},
          {cluster.high[0], cluster.high[1], cluster.high[2], bits(word)},
          {cluster.cone.axis[0], cluster.cone.axis[1], cluster.cone.axis[2],
           bits(glm::packHalf2x16({cluster.cone.sine, cluster.cone.thinness}))}};
}

// Where each of a run's triangles is among the clusters of its chunk, which begins at cluster `chunkFirst`.
void placeTriangles(const FlatScene& flat, size_t clusterFirst, size_t clusterEnd, size_t chunkFirst,
                    std::span<const FlatTriangle> triangles, std::span<uint32_t> places) {
  const size_t firstTriangle = flat.clusters[clusterFirst].firstTriangle;
  for (size_t cluster = clusterFirst; cluster < clusterEnd; ++cluster) {
    const size_t first = flat.clusters[cluster].firstTriangle;
    for (size_t i = first; i < flat.clusters[cluster + 1].firstTriangle; ++i)
      places[triangles[i - firstTriangle].index] =
          static_cast<uint32_t>((cluster - chunkFirst) * gpu::kClusterTriangles + (i - first));
  }
}

}  // namespace

Geometry::Geometry(const Device& device, const Scene& scene, bool surfaces)
    : device_(device), flat_(flatten(scene)), instances_(device, surfaces) {
  FlatCluster end;
  end.firstVertex = flat_.vertices.size();
  end.firstTriangle = flat_.triangles.size();
  FlatGroup endGroup;
  endGroup.firstCluster = static_cast<uint32_t>(flat_.clusters.size());
  flat_.clusters.push_back(end);
  flat_.groups.push_back(endGroup);
  Uploader uploader(device);
  chunkFirsts_.push_back(0);
  while (chunkFirsts_.back() + 1 < flat_.groups.size()) {
    const size_t first = chunkFirsts_.back();
    chunkFirsts_.push_back(chunkEnd(flat_, first, device.maxBufferBytes()));
    addChunk(uploader, first, chunkFirsts_.back());
    if (surfaces) addSurfaces(uploader, scene, chunks_.size() - 1);
  }
  flat_.positions = {};
  flat_.triangles = {};
  addInstances(scene);
}

void Geometry::addInstances(const Scene& scene) {
  for (size_t i = 0; i < scene.meshes.size(); ++i) {
    const FlatMesh& mesh = flat_.meshes[i];
    MeshSummary summary;
    summary.origin = scene.meshes[i].origin;
    summary.triangles = static_cast<uint32_t>(scene.meshes[i].triangleCount());
    summarize(i, summary);
    for (uint32_t chunk = 0; chunk < chunks_.size(); ++chunk) {
      const size_t from = std::max<size_t>(chunkFirsts_[chunk], mesh.firstGroup);
      const size_t to = std::min<size_t>(chunkFirsts_[chunk + 1], mesh.firstGroup + mesh.groupCount);
      if (from >= to) continue;
      const uint32_t clusters = flat_.groups[to].firstCluster - flat_.groups[from].firstCluster;
      summary.runs.push_back(
          {chunk, static_cast<uint32_t>(from - chunkFirsts_[chunk]), static_cast<uint32_t>(to - from), clusters});
    }
    instances_.addMesh(std::move(summary));
  }
  for (size_t i = 0; i < scene.instances.size(); ++i)
    instances_.set(i, scene.instances[i].mesh, scene.instances[i].transform);
}

// What changes with the positions.
void Geometry::summarize(size_t index, MeshSummary& summary) const {
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

void Geometry::setPositions(size_t index, std::span<const float> positions) {
  MeshSummary summary = instances_.mesh(index);
  flat_.meshes[index].nonFinite = flat_.meshes[index].degenerate = 0;
  Uploader uploader(device_);
  std::vector<float> moved;
  for (const MeshSummary::Run& piece : summary.runs) {
    GeometryChunk& chunk = chunks_[piece.chunk];
    const size_t chunkFirst = chunkFirsts_[piece.chunk], first = chunkFirst + piece.first, end = first + piece.count;
    const Run all = runOf(flat_, chunkFirst, chunkFirsts_[piece.chunk + 1]), run = runOf(flat_, first, end);
    moved.clear();
    for (size_t i = run.vertexFirst; i < run.vertexEnd; ++i) {
      const float* position = &positions[3 * size_t{flat_.vertices[i]}];
      moved.insert(moved.end(), position, position + 3);
    }
    const size_t triangleFirst = run.triangleFirst - all.triangleFirst;
    auto triangles =
        uploader.read<FlatTriangle>(chunk.triangleCorners, triangleFirst, run.triangleEnd - run.triangleFirst);
    std::vector<gpu::Cluster> clusters;
    for (size_t i = run.clusterFirst; i < run.clusterEnd; ++i) {
      FlatCluster& cluster = flat_.clusters[i];
      const size_t count = flat_.clusters[i + 1].firstTriangle - cluster.firstTriangle;
      fit(cluster, &moved[3 * (cluster.firstVertex - run.vertexFirst)],
          std::span(triangles).subspan(cluster.firstTriangle - run.triangleFirst, count), flat_.meshes[index]);
      clusters.push_back(packed(cluster, all));
    }
    std::vector<gpu::Group> groups;
    for (size_t i = first; i < end; ++i) {
      FlatGroup& group = flat_.groups[i];
      fit(group, std::span(flat_.clusters).subspan(group.firstCluster, group.clusterCount));
      groups.push_back(packed(group, all));
    }
    uploader.write<gpu::Group>(groups, chunk.groups, piece.first);
    uploader.write<gpu::Cluster>(clusters, chunk.clusters, run.clusterFirst - all.clusterFirst);
    uploader.write<float>(moved, chunk.positions, 3 * (run.vertexFirst - all.vertexFirst));
    uploader.write<FlatTriangle>(triangles, chunk.triangleCorners, triangleFirst);
    if (!meshPlaces_.empty()) {
      const uint32_t firstPlace = meshPlaces_[piece.chunk][index];
      auto places = uploader.read<uint32_t>(chunk.trianglePlaces, firstPlace, instances_.mesh(index).triangles);
      placeTriangles(flat_, run.clusterFirst, run.clusterEnd, all.clusterFirst, triangles, places);
      uploader.write<uint32_t>(places, chunk.trianglePlaces, firstPlace);
    }
  }
  summarize(index, summary);
  instances_.setMesh(index, std::move(summary));
}

void Geometry::addChunk(Uploader& uploader, size_t first, size_t end) {
  const Run run = runOf(flat_, first, end);
  std::vector<gpu::Group> groups;
  for (size_t i = first; i < end; ++i) groups.push_back(packed(flat_.groups[i], run));
  std::vector<gpu::Cluster> clusters;
  for (size_t i = run.clusterFirst; i < run.clusterEnd; ++i) clusters.push_back(packed(flat_.clusters[i], run));
  GeometryChunk chunk;
  chunk.groups = uploader.upload<gpu::Group>("groups", groups);
  chunk.clusters = uploader.upload<gpu::Cluster>("clusters", clusters);
  chunk.positions = uploader.upload(
      "positions",
      std::span<const float>(flat_.positions).subspan(3 * run.vertexFirst, 3 * (run.vertexEnd - run.vertexFirst)));
  chunk.triangleCorners = uploader.upload(
      "triangleCorners",
      std::span<const FlatTriangle>(flat_.triangles).subspan(run.triangleFirst, run.triangleEnd - run.triangleFirst));
  chunks_.push_back(std::move(chunk));
}

void Geometry::addSurfaces(Uploader& uploader, const Scene& scene, size_t index) {
  const size_t first = chunkFirsts_[index], end = chunkFirsts_[index + 1];
  const Run run = runOf(flat_, first, end);
  std::vector<uint32_t> materials;
  for (size_t i = run.clusterFirst; i < run.clusterEnd; ++i) materials.push_back(flat_.clusters[i].material);
  std::vector<uint32_t> meshPlaces(scene.meshes.size() + 1, gpu::kNone), places;  // the last: of a removed instance
  for (size_t i = 0; i < scene.meshes.size(); ++i) {
    const FlatMesh& mesh = flat_.meshes[i];
    const size_t from = std::max<size_t>(first, mesh.firstGroup);
    const size_t to = std::min<size_t>(end, size_t{mesh.firstGroup} + mesh.groupCount);
    if (from >= to) continue;
    meshPlaces[i] = static_cast<uint32_t>(places.size());
    places.resize(places.size() + scene.meshes[i].triangleCount(), gpu::kNone);
    const Run piece = runOf(flat_, from, to);
    placeTriangles(flat_, piece.clusterFirst, piece.clusterEnd, run.clusterFirst,
                   std::span(flat_.triangles).subspan(piece.triangleFirst, piece.triangleEnd - piece.triangleFirst),
                   std::span(places).subspan(meshPlaces[i]));
  }
  if (places.size() * sizeof(uint32_t) > device_.maxBufferBytes())
    throw Error(ErrorCode::outOfMemory, "effects that look at surfaces need a table of " +
                                            std::to_string(places.size() * sizeof(uint32_t)) +
                                            " bytes, the device allows " + std::to_string(device_.maxBufferBytes()) +
                                            "; split the scene's largest mesh");
  GeometryChunk& chunk = chunks_[index];
  chunk.clusterMaterials = uploader.upload<uint32_t>("clusterMaterials", materials);
  chunk.meshPlaces = uploader.upload<uint32_t>("meshPlaces", meshPlaces);
  chunk.trianglePlaces = uploader.upload<uint32_t>("trianglePlaces", places);
  meshPlaces_.push_back(std::move(meshPlaces));
}

uint64_t Geometry::bytes() const {
  uint64_t sum = 0;
  for (const GeometryChunk& chunk : chunks_)
    sum += chunk.groups.bytes() + chunk.clusters.bytes() + chunk.positions.bytes() + chunk.triangleCorners.bytes() +
           chunk.clusterMaterials.bytes() + chunk.meshPlaces.bytes() + chunk.trianglePlaces.bytes();
  return sum;
}

}  // namespace gnosphere::vulkan
