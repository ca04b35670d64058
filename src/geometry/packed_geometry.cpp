// SPDX-License-Identifier: Apache-2.0
#include "geometry/packed_geometry.hpp"

#include <algorithm>
#include <glm/gtc/packing.hpp>
#include <utility>

#include "base/room.hpp"
#include "base/threads.hpp"

namespace gnosphere {
namespace {

using gpu::Array;

gpu::vec3 vec3Of(const float* v) {
  return {v[0], v[1], v[2]};
}

/// Collects consecutive writes to an array, because a transfer of few bytes to a device takes as long as one of many.
class Writer {
 public:
  Writer(SceneMemory& memory, Array array) : memory_(memory), array_(array) {}

  /// Writes entries from index `first` on.
  template <typename T>
  void write(uint64_t first, const std::vector<T>& entries) {
    const uint64_t place = first * sizeof(T);
    if (place != place_ + pending_.size() || pending_.size() > kMost) flush();
    if (pending_.empty()) place_ = place;
    const auto bytes = std::as_bytes(std::span(entries));
    pending_.insert(pending_.end(), bytes.begin(), bytes.end());
  }
  void flush() {
    if (!pending_.empty()) memory_.write(array_, place_, pending_);
    pending_.clear();
  }

 private:
  static constexpr size_t kMost = 8 << 20;
  SceneMemory& memory_;
  Array array_;
  uint64_t place_ = 0;
  std::vector<std::byte> pending_;
};

MeshSummary summaryOf(const FlatMesh& flat, uint64_t firstGroup, const Vec3& origin) {
  MeshSummary summary;
  summary.origin = origin;
  summary.triangles = static_cast<uint32_t>(flat.clusters.back().firstTriangle);
  summary.firstGroup = static_cast<uint32_t>(firstGroup);
  summary.groups = flat.groupCount();
  summary.clusters = flat.clusterCount();
  summary.nonFinite = flat.nonFinite;
  summary.degenerate = flat.degenerate;
  summary.low = glm::dvec3(gpu::kCoordinateLimit);
  summary.high = -summary.low;
  for (const FlatGroup& group : std::span(flat.groups).first(flat.groupCount()))
    for (int axis = 0; axis < 3; ++axis) {
      summary.low[axis] = std::min<double>(summary.low[axis], group.low[axis]);
      summary.high[axis] = std::max<double>(summary.high[axis], group.high[axis]);
    }
  return summary;
}

}  // namespace

void PackedGeometry::pack(const Entry& entry, std::span<gpu::Group> to) {
  for (size_t i = 0; i < to.size(); ++i) {
    const FlatGroup& group = entry.flat.groups[i];
    to[i] = {vec3Of(group.low), static_cast<uint32_t>(entry.cluster + group.firstCluster), vec3Of(group.high),
             group.clusterCount};
  }
}

std::vector<gpu::Group> PackedGeometry::packedGroups(const Entry& entry) const {
  std::vector<gpu::Group> result(entry.flat.groupCount());
  pack(entry, result);
  return result;
}

std::vector<gpu::Cluster> PackedGeometry::packedClusters(const Entry& entry,
                                                         std::span<const FlatCluster> clusters) const {
  std::vector<gpu::Cluster> result;
  result.reserve(clusters.size());
  for (size_t i = 0; i + 1 < clusters.size(); ++i) {
    const FlatCluster &cluster = clusters[i], &next = clusters[i + 1];
    result.push_back({vec3Of(cluster.low),
                      static_cast<uint32_t>(entry.vertex + cluster.firstVertex),
                      vec3Of(cluster.high),
                      static_cast<uint32_t>(entry.triangle + cluster.firstTriangle),
                      {cluster.cone.axis[0], cluster.cone.axis[1], cluster.cone.axis[2]},
                      glm::packHalf2x16({cluster.cone.sine, cluster.cone.thinness}),
                      static_cast<uint32_t>(next.firstVertex - cluster.firstVertex),
                      cluster.triangleCount,
                      cluster.doubleSided,
                      cluster.material});
  }
  return result;
}

// Returns for each triangle of the mesh: cluster * kClusterTriangles + number of the triangle in the cluster.
std::vector<uint32_t> PackedGeometry::slotsOf(const Entry& entry, std::span<const FlatTriangle> triangles) const {
  std::vector<uint32_t> slots(triangles.size());
  size_t cluster = 0;
  for (size_t i = 0; i < triangles.size(); ++i) {
    if (i == entry.flat.clusters[cluster + 1].firstTriangle) ++cluster;
    const size_t number = i - entry.flat.clusters[cluster].firstTriangle;
    slots[triangles[i].index] = static_cast<uint32_t>((entry.cluster + cluster) * gpu::kClusterTriangles + number);
  }
  return slots;
}

std::vector<FlatTriangle> PackedGeometry::trianglesOf(const Entry& entry) const {
  std::vector<FlatTriangle> triangles(entry.flat.clusters.back().firstTriangle);
  memory_.read(Array::triangleCorners, entry.triangle * sizeof(FlatTriangle),
               std::as_writable_bytes(std::span(triangles)));
  return triangles;
}

std::vector<float> PackedGeometry::textureCoordinates(const Entry& entry) const {
  std::vector<float> result(2 * entry.flat.vertices.size());
  if (!entry.uvs.empty())
    for (size_t k = 0; k < entry.flat.vertices.size(); ++k)
      std::copy_n(&entry.uvs[2 * size_t{entry.flat.vertices[k]}], 2, &result[2 * k]);
  return result;
}

size_t PackedGeometry::clusterCount() const {
  size_t count = 0;
  for (const Entry& entry : meshes_) count += entry.flat.clusterCount();
  return count;
}

// Gives the meshes that will have the indices from `first` on their runs in the arrays, writes them, and makes room for
// their entries. Only free runs are written, so that nothing has changed if this throws.
void PackedGeometry::place(size_t first, std::span<const Mesh> meshes, std::span<Entry> entries) {
  TakenRuns runs;
  for (Entry& entry : entries) {
    entry.group = runs.take(groups_, entry.flat.groupCount());
    entry.cluster = runs.take(clusters_, entry.flat.clusterCount());
    entry.vertex = runs.take(vertices_, entry.flat.vertices.size());
    entry.triangle = runs.take(triangles_, entry.flat.clusters.back().firstTriangle);
  }
  const size_t count = std::max(meshes_.size(), first + entries.size());
  makeRoom(meshes_, count);
  instances_.reserveMeshes(count - meshes_.size());
  deformables_.setMeshCount(count);
  try {
    reserve();
    for (size_t i = 0; i < entries.size(); ++i) {
      if (!meshes[i].deformable()) continue;
      deformables_.add(first + i, meshes[i], entries[i].flat, entries[i].vertex, entries[i].cluster);
      deformables_.deform(first + i, meshes[i].deformation, entries[i].flat);
    }
    write(entries);
    if (slots_) writeMeshTriangles(first, entries);
  } catch (...) {
    for (size_t i = 0; i < entries.size(); ++i) deformables_.remove(first + i);
    deformables_.setMeshCount(meshes_.size());
    throw;
  }
  runs.keep();
}

void PackedGeometry::giveBack(const Entry& entry) noexcept {
  groups_.giveBack(entry.group, entry.flat.groupCount());
  clusters_.giveBack(entry.cluster, entry.flat.clusterCount());
  vertices_.giveBack(entry.vertex, entry.flat.vertices.size());
  triangles_.giveBack(entry.triangle, entry.flat.clusters.back().firstTriangle);
}

void PackedGeometry::reserve() {
  memory_.reserve(Array::groups, groups_.end() * sizeof(gpu::Group));
  memory_.reserve(Array::clusters, clusters_.end() * sizeof(gpu::Cluster));
  memory_.reserve(Array::positions, vertices_.end() * 3 * sizeof(float));
  memory_.reserve(Array::triangleCorners, triangles_.end() * sizeof(FlatTriangle));
  if (slots_) memory_.reserve(Array::triangleSlots, triangles_.end() * sizeof(uint32_t));
  if (textured_) memory_.reserve(Array::textureCoordinates, vertices_.end() * 2 * sizeof(float));
}

// Writes meshes to the memory. Positions and triangles are then freed on the host; only the memory has them.
void PackedGeometry::write(std::span<Entry> entries) {
  Writer groups(memory_, Array::groups), clusters(memory_, Array::clusters), positions(memory_, Array::positions),
      corners(memory_, Array::triangleCorners), slots(memory_, Array::triangleSlots),
      coordinates(memory_, Array::textureCoordinates);
  for (Entry& entry : entries) {
    groups.write(entry.group, packedGroups(entry));
    clusters.write(entry.cluster, packedClusters(entry, entry.flat.clusters));
    positions.write(3 * entry.vertex, entry.flat.positions);
    corners.write(entry.triangle, entry.flat.triangles);
    if (slots_) slots.write(entry.triangle, slotsOf(entry, entry.flat.triangles));
    if (textured_) coordinates.write(2 * entry.vertex, textureCoordinates(entry));
    entry.flat.positions = {};
    entry.flat.triangles = {};
  }
  for (Writer* writer : {&groups, &clusters, &positions, &corners, &slots, &coordinates}) writer->flush();
}

// Writes for each mesh its first entry in triangleSlots, and a last entry for removed instances. `entries` are those
// that the meshes from `first` on will have.
void PackedGeometry::writeMeshTriangles(size_t first, std::span<const Entry> entries) {
  std::vector<uint32_t> firsts(std::max(meshes_.size(), first + entries.size()) + 1);
  for (size_t i = 0; i < meshes_.size(); ++i) firsts[i] = static_cast<uint32_t>(meshes_[i].triangle);
  for (size_t i = 0; i < entries.size(); ++i) firsts[first + i] = static_cast<uint32_t>(entries[i].triangle);
  memory_.reserve(Array::meshTriangles, firsts.size() * sizeof(uint32_t));
  memory_.write(Array::meshTriangles, 0, std::as_bytes(std::span(firsts)));
}

void PackedGeometry::add(std::span<const Mesh> meshes, const std::vector<Material>& materials) {
  const size_t first = meshes_.size();
  std::vector<Entry> entries(meshes.size());
  inRuns(meshes.size(), 1, threadCount(), [&](size_t from, size_t end) {
    for (size_t i = from; i < end; ++i) {
      entries[i].flat = flatten(meshes[i], materials);
      entries[i].origin = meshes[i].origin;
      entries[i].uvs = meshes[i].uvs;
    }
  });
  place(first, meshes, entries);
  for (Entry& entry : entries) {
    instances_.addMesh(summaryOf(entry.flat, entry.group, entry.origin));
    meshes_.push_back(std::move(entry));
  }
}

void PackedGeometry::replace(size_t index, const Mesh& mesh, const std::vector<Material>& materials) {
  Entry entry = {flatten(mesh, materials), 0, 0, 0, 0, mesh.origin, mesh.uvs};
  place(index, {&mesh, 1}, {&entry, 1});
  meshes_[index] = std::move(entry);
  instances_.setMesh(index, summaryOf(meshes_[index].flat, meshes_[index].group, meshes_[index].origin));
}

void PackedGeometry::remove(size_t index) {
  Entry none = {flatten({}, {}), 0, 0, 0, 0, {}, {}};
  giveBack(meshes_[index]);
  deformables_.remove(index);
  vertexSources_.remove(index);
  meshes_[index] = std::move(none);
  instances_.setMesh(index, {});
}

void PackedGeometry::addSlots() {
  if (slots_) return;
  memory_.reserve(Array::triangleSlots, triangles_.end() * sizeof(uint32_t));
  Writer slots(memory_, Array::triangleSlots);
  for (const Entry& entry : meshes_) slots.write(entry.triangle, slotsOf(entry, trianglesOf(entry)));
  slots.flush();
  writeMeshTriangles(0, {});
  slots_ = true;
}

void PackedGeometry::addTextureCoordinates() {
  if (textured_) return;
  memory_.reserve(Array::textureCoordinates, vertices_.end() * 2 * sizeof(float));
  Writer coordinates(memory_, Array::textureCoordinates);
  for (const Entry& entry : meshes_) coordinates.write(2 * entry.vertex, textureCoordinates(entry));
  coordinates.flush();
  textured_ = true;
}

void PackedGeometry::setDeformation(size_t index, const Deformation& deformation) {
  Entry& entry = meshes_[index];
  std::vector<gpu::Group> groups = packedGroups(entry);  // allocated before anything changes
  memory_.prepareWrite(Array::groups, entry.group * sizeof(gpu::Group), groups.size() * sizeof(gpu::Group));
  deformables_.deform(index, deformation, entry.flat);
  pack(entry, groups);
  memory_.write(Array::groups, entry.group * sizeof(gpu::Group), std::as_bytes(std::span(groups)));
  instances_.setMesh(index, summaryOf(entry.flat, entry.group, entry.origin));
}

// Prepares a mesh for vertices that only the device knows. All its triangles may become usable, and their normals may
// point anywhere. The instances of the mesh may be anywhere, too; the device culls by the boxes of groups.
void PackedGeometry::releaseVertices(size_t index) {
  Entry& entry = meshes_[index];
  std::vector<FlatCluster> released = entry.flat.clusters;
  for (size_t i = 0; i + 1 < released.size(); ++i) {
    released[i].triangleCount = static_cast<uint32_t>(released[i + 1].firstTriangle - released[i].firstTriangle);
    released[i].cone = {};
  }
  const std::vector<gpu::Cluster> clusters = packedClusters(entry, released);
  memory_.prepareWrite(Array::clusters, entry.cluster * sizeof(gpu::Cluster), clusters.size() * sizeof(gpu::Cluster));
  vertexSources_.add(index, entry.flat, entry.group, entry.vertex);
  FlatMesh& flat = entry.flat;
  flat.clusters = std::move(released);
  flat.nonFinite = flat.degenerate = 0;
  memory_.write(Array::clusters, entry.cluster * sizeof(gpu::Cluster), std::as_bytes(std::span(clusters)));
  MeshSummary summary = summaryOf(flat, entry.group, entry.origin);
  summary.low = glm::dvec3(-gpu::kCoordinateLimit);
  summary.high = -summary.low;
  instances_.setMesh(index, summary);
}

void PackedGeometry::setVertices(size_t index, const CallerVertices& vertices) {
  if (!vertexSources_.has(index)) releaseVertices(index);
  vertexSources_.set(index, vertices);
}

// Everything is computed and allocated first; then it is written.
void PackedGeometry::setPositions(size_t index, std::span<const float> positions) {
  Entry& entry = meshes_[index];
  FlatMesh moved;
  moved.groups = entry.flat.groups;
  moved.clusters = entry.flat.clusters;
  moved.deformable = entry.flat.deformable;
  moved.positions.reserve(3 * entry.flat.vertices.size());
  for (const uint32_t vertex : entry.flat.vertices)
    moved.positions.insert(moved.positions.end(), &positions[3 * size_t{vertex}], &positions[3 * size_t{vertex}] + 3);
  moved.triangles = trianglesOf(entry);
  for (size_t i = 0; i < moved.clusterCount(); ++i) {
    FlatCluster& cluster = moved.clusters[i];
    const size_t count = moved.clusters[i + 1].firstTriangle - cluster.firstTriangle;
    fit(cluster, &moved.positions[3 * cluster.firstVertex],
        std::span(moved.triangles).subspan(cluster.firstTriangle, count), moved);
  }
  for (FlatGroup& group : std::span(moved.groups).first(moved.groupCount()))
    fit(group, std::span(moved.clusters).subspan(group.firstCluster, group.clusterCount));
  std::vector<uint32_t> slots;
  if (slots_) slots = slotsOf(entry, moved.triangles);
  std::vector<gpu::Group> groups(moved.groupCount());
  const std::vector<gpu::Cluster> clusters = packedClusters(entry, moved.clusters);
  const auto each = [&](const auto& call) {
    call(Array::clusters, entry.cluster, std::span(clusters));
    call(Array::positions, 3 * entry.vertex, std::span<const float>(moved.positions));
    call(Array::triangleCorners, entry.triangle, std::span<const FlatTriangle>(moved.triangles));
    if (slots_) call(Array::triangleSlots, entry.triangle, std::span<const uint32_t>(slots));
    call(Array::groups, entry.group, std::span<const gpu::Group>(groups));
  };
  each([&](Array array, uint64_t first, auto content) {
    memory_.prepareWrite(array, first * sizeof content[0], content.size_bytes());
  });
  vertexSources_.remove(index);
  FlatMesh& flat = entry.flat;
  flat.groups = std::move(moved.groups);
  flat.clusters = std::move(moved.clusters);
  flat.nonFinite = moved.nonFinite;
  flat.degenerate = moved.degenerate;
  pack(entry, groups);
  each([&](Array array, uint64_t first, auto content) {
    if (!content.empty()) memory_.write(array, first * sizeof content[0], std::as_bytes(content));
  });
  instances_.setMesh(index, summaryOf(flat, entry.group, entry.origin));
}

}  // namespace gnosphere
