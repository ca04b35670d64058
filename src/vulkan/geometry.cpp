// SPDX-License-Identifier: Apache-2.0
#include "vulkan/geometry.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

namespace gnosphere::vulkan {
namespace {

// Runs of clusters, vertices and triangles that belong to groups first..end.
struct Run {
  size_t clusterFirst, clusterEnd, vertexFirst, vertexEnd, triangleFirst, triangleEnd;
};

Run runOf(const FlatScene& flat, size_t first, size_t end) {
  Run run = {
      flat.groups[first].firstCluster, flat.clusters.size(), 0, flat.positions.size() / 3, 0, flat.triangles.size()};
  run.vertexFirst = flat.clusters[run.clusterFirst].firstVertex;
  run.triangleFirst = flat.clusters[run.clusterFirst].firstTriangle;
  if (end == flat.groups.size()) return run;
  run.clusterEnd = flat.groups[end].firstCluster;
  run.vertexEnd = flat.clusters[run.clusterEnd].firstVertex;
  run.triangleEnd = flat.clusters[run.clusterEnd].firstTriangle;
  return run;
}

// The end of the longest run of groups from `first` on whose arrays all fit into one buffer each.
size_t chunkEnd(const FlatScene& flat, size_t first, uint64_t limit) {
  size_t end = first;
  while (end < flat.groups.size()) {
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
  const size_t word = (cluster.firstTriangle - run.triangleFirst) | size_t{cluster.triangleCount - 1} << 25 |
                      size_t{cluster.doubleSided} << 31;
  return {{cluster.low[0], cluster.low[1], cluster.low[2], bits(cluster.firstVertex - run.vertexFirst)},
          {cluster.high[0], cluster.high[1], cluster.high[2], bits(word)}};
}

glm::dmat3 linear(const Transform& t) {
  const auto& m = t.rows;
  return glm::dmat3(m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10]);
}

}  // namespace

Geometry::Geometry(const Device& device, const Scene& scene) {
  const FlatScene flat = flatten(scene);
  clusterCount_ = flat.clusters.size();
  addPlacements(scene, flat);
  Uploader uploader(device);
  for (size_t first = 0; first < flat.groups.size();) {
    const size_t end = chunkEnd(flat, first, device.maxBufferBytes());
    addChunk(uploader, scene, flat, first, end);
    first = end;
  }
}

void Geometry::addPlacements(const Scene& scene, const FlatScene& flat) {
  uint32_t firstTriangle = 0;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    const Transform origin = {{1, 0, 0, mesh.origin.x, 0, 1, 0, mesh.origin.y, 0, 0, 1, mesh.origin.z}};
    instances_.push_back(
        {instance.transform * origin, firstTriangle, glm::determinant(linear(instance.transform)) < 0});
    firstTriangle += static_cast<uint32_t>(mesh.triangleCount());
    dropped_.nonFinite += flat.meshes[instance.mesh].nonFinite;
    dropped_.degenerate += flat.meshes[instance.mesh].degenerate;
  }
  dropped_.triangles = firstTriangle;
}

void Geometry::addChunk(Uploader& uploader, const Scene& scene, const FlatScene& flat, size_t first, size_t end) {
  const Run run = runOf(flat, first, end);
  std::vector<gpu::Group> groups;
  for (size_t i = first; i < end; ++i) groups.push_back(packed(flat.groups[i], run));
  std::vector<gpu::Cluster> clusters;
  for (size_t i = run.clusterFirst; i < run.clusterEnd; ++i) clusters.push_back(packed(flat.clusters[i], run));
  GeometryChunk chunk;
  std::vector<uint32_t> placed;
  for (uint32_t i = 0; i < scene.instances.size(); ++i) {
    const FlatMesh& mesh = flat.meshes[scene.instances[i].mesh];
    const size_t from = std::max<size_t>(first, mesh.firstGroup);
    const size_t to = std::min<size_t>(end, mesh.firstGroup + mesh.groupCount);
    for (size_t group = from; group < to; ++group) {
      placed.insert(placed.end(), {i, static_cast<uint32_t>(group - first)});
      chunk.placedClusters += flat.groups[group].clusterCount;
    }
  }
  chunk.placedGroups = static_cast<uint32_t>(placed.size() / 2);
  chunk.placed = uploader.upload<uint32_t>("placed", placed);
  chunk.groups = uploader.upload<gpu::Group>("groups", groups);
  chunk.clusters = uploader.upload<gpu::Cluster>("clusters", clusters);
  chunk.positions = uploader.upload(
      "positions", std::span(flat.positions).subspan(3 * run.vertexFirst, 3 * (run.vertexEnd - run.vertexFirst)));
  chunk.triangleCorners = uploader.upload(
      "triangleCorners", std::span(flat.triangles).subspan(run.triangleFirst, run.triangleEnd - run.triangleFirst));
  chunks_.push_back(std::move(chunk));
}

uint32_t Geometry::maxPlacedGroups() const {
  uint32_t most = 0;
  for (const GeometryChunk& chunk : chunks_) most = std::max(most, chunk.placedGroups);
  return most;
}

uint32_t Geometry::maxPlacedClusters() const {
  uint32_t most = 0;
  for (const GeometryChunk& chunk : chunks_) most = std::max(most, chunk.placedClusters);
  return most;
}

uint64_t Geometry::bytes() const {
  uint64_t sum = 0;
  for (const GeometryChunk& chunk : chunks_)
    sum += chunk.placed.bytes() + chunk.groups.bytes() + chunk.clusters.bytes() + chunk.positions.bytes() +
           chunk.triangleCorners.bytes();
  return sum;
}

void Geometry::placeInstances(const Pose& pose, gpu::Instance* out) const {
  const Quaternion& q = pose.orientation;
  const glm::dmat3 toSensor = glm::transpose(glm::mat3_cast(glm::normalize(glm::dquat(q.w, q.x, q.y, q.z))));
  const glm::dvec3 sensor(pose.position.x, pose.position.y, pose.position.z);
  for (size_t i = 0; i < instances_.size(); ++i) {
    const Placement& placement = instances_[i];
    const auto& m = placement.transform.rows;
    const glm::dmat3 toWorld = linear(placement.transform);
    // The world subtraction comes first, in double: what is left is small wherever in the world the scene lies.
    const glm::dvec3 translation = glm::dvec3(m[3], m[7], m[11]) - sensor;
    // The pivot is the sensor's place in the mesh frame. A transform that flattens the mesh has none: zero then.
    glm::dvec3 pivot(0);
    if (const double volume = glm::determinant(toWorld); std::abs(volume) > 1e-30)
      pivot = -(glm::inverse(toWorld) * translation);
    const glm::vec3 rounded(pivot);
    const bool usable = glm::all(glm::lessThanEqual(glm::abs(rounded), glm::vec3(gpu::kCoordinateLimit)));
    const glm::vec3 pivot32 = usable ? rounded : glm::vec3(0);
    const glm::dmat3 rows = glm::transpose(toSensor * toWorld);
    const glm::vec3 offset(toSensor * (toWorld * glm::dvec3(pivot32) + translation));
    gpu::Instance& instance = out[i];
    const auto row = [&](int r) {
      return gpu::vec4{static_cast<float>(rows[r].x), static_cast<float>(rows[r].y), static_cast<float>(rows[r].z),
                       pivot32[r]};
    };
    instance.row0 = row(0);
    instance.row1 = row(1);
    instance.row2 = row(2);
    const uint32_t first = placement.firstTriangle | (placement.mirrored ? 1u << 31 : 0u);
    instance.offset = {offset.x, offset.y, offset.z, std::bit_cast<float>(first)};
  }
}

}  // namespace gnosphere::vulkan
