// SPDX-License-Identifier: Apache-2.0
#include "geometry/flatten.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/shared.h"
#include "geometry/partition.hpp"

namespace gnosphere {
namespace {

// The work for a cluster in triangles, and for a group in clusters. On lavapipe a cluster takes as long as 20
// triangles. Scans take the same time within 5 % for 8 to 64, and for 2 to 32.
constexpr float kClusterCost = 32, kGroupCost = 8;

class MeshFlattener {
 public:
  MeshFlattener(const Mesh& mesh, const std::vector<Material>& materials)
      : mesh_(mesh), materials_(materials), cluster_(mesh.vertexCount()), number_(mesh.vertexCount()) {}

  FlatMesh run() {
    flat_.deformable = mesh_.deformable();
    sorted_.reserve(mesh_.triangleCount());
    for (const MeshPart& part : mesh_.parts) divide(part);
    flat_.triangles.reserve(mesh_.triangleCount());
    flat_.clusters.reserve(runs_.size() + 1);
    const Partition groups = partition(std::move(boxes_), gpu::kGroupClusters, kGroupCost);
    size_t first = 0;
    for (const size_t end : groups.ends) {
      for (size_t i = first; i < end; ++i) addCluster(runs_[groups.items[i].index]);
      addGroup(first, end);
      first = end;
    }
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
  /// The triangles that become a cluster, in `sorted_`.
  struct Run {
    size_t first, count;
    uint32_t material;
  };

  const float* position(uint32_t vertex) const { return &mesh_.positions[3 * size_t{vertex}]; }

  bool usable(uint32_t triangle) const {
    const uint32_t* corner = &mesh_.indices[3 * size_t{triangle}];
    return flat_.keeps(fateOf(position(corner[0]), position(corner[1]), position(corner[2])));
  }

  // The box of a triangle that cannot be used is empty, so it makes no cluster larger.
  BoundingBox boxOf(uint32_t triangle) const {
    BoundingBox box;
    if (usable(triangle))
      for (int k = 0; k < 3; ++k) box.add(position(mesh_.indices[3 * size_t{triangle} + k]));
    return box;
  }

  // Divides the triangles of a part into runs of neighbours.
  void divide(const MeshPart& part) {
    std::vector<Boxed> items;
    items.reserve(part.triangleCount);
    for (uint32_t k = part.firstTriangle; k < part.firstTriangle + part.triangleCount; ++k)
      items.push_back({boxOf(k), k});
    const Partition triangles = partition(std::move(items), gpu::kClusterTriangles, kClusterCost);
    size_t first = 0;
    for (const size_t end : triangles.ends) {
      boxes_.push_back({{}, static_cast<uint32_t>(runs_.size())});
      runs_.push_back({sorted_.size(), end - first, part.material});
      for (; first < end; ++first) {
        sorted_.push_back(triangles.items[first].index);
        boxes_.back().box.add(triangles.items[first].box);
      }
    }
  }

  void addCluster(const Run& run) {
    FlatCluster cluster;
    cluster.firstVertex = flat_.positions.size() / 3;
    cluster.firstTriangle = flat_.triangles.size();
    cluster.doubleSided = materials_[run.material].doubleSided;
    cluster.material = run.material;
    const uint32_t stamp = static_cast<uint32_t>(flat_.clusters.size()) + 1;
    uint32_t vertexCount = 0;
    for (const uint32_t triangle : std::span(sorted_).subspan(run.first, run.count)) {
      uint32_t packed = 0;
      for (int k = 0; k < 3; ++k) {
        const uint32_t vertex = mesh_.indices[3 * size_t{triangle} + k];
        if (cluster_[vertex] != stamp) {
          cluster_[vertex] = stamp;
          number_[vertex] = static_cast<uint8_t>(vertexCount++);
          flat_.positions.insert(flat_.positions.end(), position(vertex), position(vertex) + 3);
          flat_.vertices.push_back(vertex);
        }
        packed |= uint32_t{number_[vertex]} << (8 * k);
      }
      flat_.triangles.push_back({packed, triangle});
    }
    fit(cluster, &flat_.positions[3 * cluster.firstVertex], std::span(flat_.triangles).last(run.count), flat_);
    flat_.clusters.push_back(cluster);
  }

  void addGroup(size_t first, size_t end) {
    FlatGroup group;
    group.firstCluster = static_cast<uint32_t>(first);
    group.clusterCount = static_cast<uint32_t>(end - first);
    fit(group, std::span(flat_.clusters).subspan(first, group.clusterCount));
    flat_.groups.push_back(group);
  }

  const Mesh& mesh_;
  const std::vector<Material>& materials_;
  FlatMesh flat_;
  std::vector<uint32_t> sorted_;  // triangles, neighbour by neighbour
  std::vector<Run> runs_;
  std::vector<Boxed> boxes_;       // of the runs
  std::vector<uint32_t> cluster_;  // by vertex: the last cluster that uses it, plus one
  std::vector<uint8_t> number_;    // by vertex: its number in that cluster
};

}  // namespace

bool inLimits(const float* point) {
  return std::all_of(point, point + 3, [](float value) { return std::abs(value) <= gpu::kCoordinateLimit; });
}

Fate fateOf(const float* a, const float* b, const float* c) {
  if (!inLimits(a) || !inLimits(b) || !inLimits(c)) return Fate::nonFinite;
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
