// SPDX-License-Identifier: Apache-2.0
#include "geometry/flatten.hpp"

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "shared.h"

namespace gnosphere {
namespace {

class MeshFlattener {
 public:
  MeshFlattener(const Mesh& mesh, const std::vector<Material>& materials)
      : mesh_(mesh), materials_(materials), cluster_(mesh.vertexCount()), number_(mesh.vertexCount()) {}

  FlatMesh run() {
    flat_.deformable = mesh_.deformable();
    flat_.triangles.reserve(mesh_.triangleCount());
    flat_.clusters.reserve(mesh_.triangleCount() / gpu::kClusterTriangles + mesh_.parts.size() + 1);
    for (const MeshPart& part : mesh_.parts) flattenPart(part);
    for (size_t from = 0; from < flat_.clusters.size(); from += gpu::kGroupClusters) addGroup(from);
    FlatGroup endGroup;
    endGroup.firstCluster = static_cast<uint32_t>(flat_.clusters.size());
    flat_.groups.push_back(endGroup);
    FlatCluster endCluster;
    endCluster.firstVertex = flat_.vertices.size();
    endCluster.firstTriangle = flat_.triangles.size();
    flat_.clusters.push_back(endCluster);
    return std::move(flat_);
  }

 private:
  const float* position(uint32_t vertex) const { return &mesh_.positions[3 * size_t{vertex}]; }

  bool usable(uint32_t triangle) const {
    const uint32_t* corner = &mesh_.indices[3 * size_t{triangle}];
    return flat_.keeps(fateOf(position(corner[0]), position(corner[1]), position(corner[2])));
  }

  // Triangles that lie close together share a cluster: they are sorted along a space-filling curve, which is then cut.
  void flattenPart(const MeshPart& part) {
    std::vector<uint32_t> triangles, others;
    triangles.reserve(part.triangleCount);
    for (uint32_t k = part.firstTriangle; k < part.firstTriangle + part.triangleCount; ++k)
      (usable(k) ? triangles : others).push_back(k);
    std::vector<float> centres(3 * triangles.size());
    for (size_t i = 0; i < triangles.size(); ++i)
      for (int axis = 0; axis < 3; ++axis) {
        const uint32_t* corner = &mesh_.indices[3 * size_t{triangles[i]}];
        centres[3 * i + axis] =
            position(corner[0])[axis] / 3 + position(corner[1])[axis] / 3 + position(corner[2])[axis] / 3;
      }
    std::vector<uint32_t> place(triangles.size());
    meshopt_spatialSortRemap(place.data(), centres.data(), triangles.size(), 3 * sizeof(float));
    std::vector<uint32_t> sorted(triangles.size());
    for (size_t i = 0; i < triangles.size(); ++i) sorted[place[i]] = triangles[i];
    sorted.insert(sorted.end(), others.begin(), others.end());
    for (size_t first = 0; first < sorted.size(); first += gpu::kClusterTriangles)
      addCluster(&sorted[first], std::min<size_t>(gpu::kClusterTriangles, sorted.size() - first), part.material);
  }

  void addCluster(const uint32_t* triangles, size_t count, uint32_t material) {
    FlatCluster cluster;
    cluster.firstVertex = flat_.positions.size() / 3;
    cluster.firstTriangle = flat_.triangles.size();
    cluster.doubleSided = materials_[material].doubleSided;
    cluster.material = material;
    const uint32_t stamp = static_cast<uint32_t>(flat_.clusters.size()) + 1;
    uint32_t vertexCount = 0;
    for (size_t i = 0; i < count; ++i) {
      uint32_t packed = 0;
      for (int k = 0; k < 3; ++k) {
        const uint32_t vertex = mesh_.indices[3 * size_t{triangles[i]} + k];
        if (cluster_[vertex] != stamp) {
          cluster_[vertex] = stamp;
          number_[vertex] = static_cast<uint8_t>(vertexCount++);
          flat_.positions.insert(flat_.positions.end(), position(vertex), position(vertex) + 3);
          flat_.vertices.push_back(vertex);
        }
        packed |= uint32_t{number_[vertex]} << (8 * k);
      }
      flat_.triangles.push_back({packed, triangles[i]});
    }
    fit(cluster, &flat_.positions[3 * cluster.firstVertex], std::span(flat_.triangles).last(count), flat_);
    flat_.clusters.push_back(cluster);
  }

  void addGroup(size_t first) {
    FlatGroup group;
    group.firstCluster = static_cast<uint32_t>(first);
    group.clusterCount = static_cast<uint32_t>(std::min<size_t>(gpu::kGroupClusters, flat_.clusters.size() - first));
    fit(group, std::span(flat_.clusters).subspan(first, group.clusterCount));
    flat_.groups.push_back(group);
  }

  const Mesh& mesh_;
  const std::vector<Material>& materials_;
  FlatMesh flat_;
  std::vector<uint32_t> cluster_;  // by vertex: the last cluster that uses it, plus one
  std::vector<uint8_t> number_;    // by vertex: its number in that cluster
};

}  // namespace

Fate fateOf(const float* a, const float* b, const float* c) {
  for (const float* corner : {a, b, c})
    for (int axis = 0; axis < 3; ++axis)
      if (!(std::abs(corner[axis]) <= gpu::kCoordinateLimit)) return Fate::nonFinite;
  const bool same = std::equal(a, a + 3, b) || std::equal(b, b + 3, c) || std::equal(c, c + 3, a);
  return same ? Fate::degenerate : Fate::usable;
}

void fit(FlatCluster& cluster, const float* positions, std::span<FlatTriangle> triangles, FlatMesh& dropped) {
  std::fill(cluster.low, cluster.low + 3, gpu::kCoordinateLimit);
  std::fill(cluster.high, cluster.high + 3, -gpu::kCoordinateLimit);
  const auto usable = [&](const FlatTriangle& triangle) {
    const auto corner = [&](int k) { return positions + 3 * (triangle.corners >> (8 * k) & 0xff); };
    const Fate fate = fateOf(corner(0), corner(1), corner(2));
    if (!dropped.keeps(fate)) {
      dropped.nonFinite += fate == Fate::nonFinite;
      dropped.degenerate += fate == Fate::degenerate;
      return false;
    }
    for (int k = 0; k < 3; ++k)
      for (int axis = 0; axis < 3; ++axis) {
        cluster.low[axis] = std::min(cluster.low[axis], corner(k)[axis]);
        cluster.high[axis] = std::max(cluster.high[axis], corner(k)[axis]);
      }
    return true;
  };
  cluster.triangleCount =
      static_cast<uint32_t>(std::partition(triangles.begin(), triangles.end(), usable) - triangles.begin());
  cluster.cone = dropped.deformable ? Cone() : coneOf(positions, triangles.first(cluster.triangleCount));
}

void fit(FlatGroup& group, std::span<const FlatCluster> clusters) {
  std::copy_n(clusters.front().low, 3, group.low);
  std::copy_n(clusters.front().high, 3, group.high);
  for (const FlatCluster& cluster : clusters)
    for (int axis = 0; axis < 3; ++axis) {
      group.low[axis] = std::min(group.low[axis], cluster.low[axis]);
      group.high[axis] = std::max(group.high[axis], cluster.high[axis]);
    }
}

FlatMesh flatten(const Mesh& mesh, const std::vector<Material>& materials) {
  return MeshFlattener(mesh, materials).run();
}

}  // namespace gnosphere
