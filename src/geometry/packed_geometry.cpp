// SPDX-License-Identifier: Apache-2.0
#include "geometry/packed_geometry.hpp"

#include <algorithm>
#include <glm/gtc/packing.hpp>
#include <iterator>
#include <utility>

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

std::vector<gpu::Group> PackedGeometry::packedGroups(const Entry& entry) const {
  std::vector<gpu::Group> result;
  for (const FlatGroup& group : std::span(entry.flat.groups).first(entry.flat.groupCount()))
    result.push_back({vec3Of(group.low), static_cast<uint32_t>(entry.cluster + group.firstCluster), vec3Of(group.high),
                      group.clusterCount});
  return result;
}

std::vector<gpu::Cluster> PackedGeometry::packedClusters(const Entry& entry) const {
  std::vector<gpu::Cluster> result;
  for (size_t i = 0; i < entry.flat.clusterCount(); ++i) {
    const FlatCluster &cluster = entry.flat.clusters[i], &next = entry.flat.clusters[i + 1];
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

// Gives the meshes that will have the indices from `first` on their runs in the arrays.
void PackedGeometry::place(size_t first, std::span<const Mesh> meshes, std::span<Entry> entries) {
  for (Entry& entry : entries) {
    entry.group = groups_.take(entry.flat.groupCount());
    entry.cluster = clusters_.take(entry.flat.clusterCount());
    entry.vertex = vertices_.take(entry.flat.vertices.size());
    entry.triangle = triangles_.take(entry.flat.clusters.back().firstTriangle);
  }
  deformables_.setMeshCount(std::max(meshes_.size(), first + entries.size()));
  try {
    reserve();
    for (size_t i = 0; i < entries.size(); ++i)
      if (meshes[i].deformable())
        deformables_.add(first + i, meshes[i], entries[i].flat, entries[i].vertex, entries[i].cluster);
  } catch (...) {
    for (size_t i = 0; i < entries.size(); ++i) {
      giveBack(entries[i]);
      deformables_.remove(first + i);
    }
    deformables_.setMeshCount(meshes_.size());
    throw;
  }
}

void PackedGeometry::giveBack(const Entry& entry) {
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
    clusters.write(entry.cluster, packedClusters(entry));
    positions.write(3 * entry.vertex, entry.flat.positions);
    corners.write(entry.triangle, entry.flat.triangles);
    if (slots_) slots.write(entry.triangle, slotsOf(entry, entry.flat.triangles));
    if (textured_) coordinates.write(2 * entry.vertex, textureCoordinates(entry));
    entry.flat.positions = {};
    entry.flat.triangles = {};
  }
  for (Writer* writer : {&groups, &clusters, &positions, &corners, &slots, &coordinates}) writer->flush();
}

// Writes for each mesh its first entry in triangleSlots, and a last entry for removed instances.
void PackedGeometry::writeMeshTriangles() {
  std::vector<uint32_t> firsts;
  for (const Entry& entry : meshes_) firsts.push_back(static_cast<uint32_t>(entry.triangle));
  firsts.push_back(0);
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
  std::move(entries.begin(), entries.end(), std::back_inserter(meshes_));
  write(std::span(meshes_).subspan(first));
  if (slots_) writeMeshTriangles();
  for (const Entry& entry : std::span(meshes_).subspan(first))
    instances_.addMesh(summaryOf(entry.flat, entry.group, entry.origin));
  for (size_t i = 0; i < meshes.size(); ++i)
    if (meshes[i].deformable()) setDeformation(first + i, meshes[i].deformation);
}

void PackedGeometry::replace(size_t index, const Mesh& mesh, const std::vector<Material>& materials) {
  Entry entry = {flatten(mesh, materials), 0, 0, 0, 0, mesh.origin, mesh.uvs};
  place(index, {&mesh, 1}, {&entry, 1});
  meshes_[index] = std::move(entry);
  write({&meshes_[index], 1});
  if (slots_) writeMeshTriangles();
  instances_.setMesh(index, summaryOf(meshes_[index].flat, meshes_[index].group, meshes_[index].origin));
  if (mesh.deformable()) setDeformation(index, mesh.deformation);
}

void PackedGeometry::remove(size_t index) {
  giveBack(meshes_[index]);
  deformables_.remove(index);
  vertexSources_.remove(index);
  meshes_[index] = {flatten({}, {}), 0, 0, 0, 0, {}, {}};
  instances_.setMesh(index, {});
}

void PackedGeometry::addSlots() {
  if (slots_) return;
  memory_.reserve(Array::triangleSlots, triangles_.end() * sizeof(uint32_t));
  Writer slots(memory_, Array::triangleSlots);
  for (const Entry& entry : meshes_) slots.write(entry.triangle, slotsOf(entry, trianglesOf(entry)));
  slots.flush();
  writeMeshTriangles();
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
  deformables_.deform(index, deformation, entry.flat);
  const std::vector<gpu::Group> groups = packedGroups(entry);
  memory_.write(Array::groups, entry.group * sizeof(gpu::Group), std::as_bytes(std::span(groups)));
  instances_.setMesh(index, summaryOf(entry.flat, entry.group, entry.origin));
}

// Prepares a mesh for vertices that only the device knows. All its triangles may become usable, and their normals may
// point anywhere. The instances of the mesh may be anywhere, too; the device culls by the boxes of groups.
void PackedGeometry::releaseVertices(size_t index) {
  Entry& entry = meshes_[index];
  vertexSources_.add(index, entry.flat, entry.group, entry.vertex);
  FlatMesh& flat = entry.flat;
  flat.nonFinite = flat.degenerate = 0;
  for (size_t i = 0; i < flat.clusterCount(); ++i) {
    flat.clusters[i].triangleCount =
        static_cast<uint32_t>(flat.clusters[i + 1].firstTriangle - flat.clusters[i].firstTriangle);
    flat.clusters[i].cone = {};
  }
  const std::vector<gpu::Cluster> clusters = packedClusters(entry);
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

void PackedGeometry::setPositions(size_t index, std::span<const float> positions) {
  vertexSources_.remove(index);
  Entry& entry = meshes_[index];
  FlatMesh& flat = entry.flat;
  flat.nonFinite = flat.degenerate = 0;
  flat.positions.clear();
  for (const uint32_t vertex : flat.vertices)
    flat.positions.insert(flat.positions.end(), &positions[3 * size_t{vertex}], &positions[3 * size_t{vertex}] + 3);
  flat.triangles = trianglesOf(entry);
  for (size_t i = 0; i < flat.clusterCount(); ++i) {
    FlatCluster& cluster = flat.clusters[i];
    const size_t count = flat.clusters[i + 1].firstTriangle - cluster.firstTriangle;
    fit(cluster, &flat.positions[3 * cluster.firstVertex],
        std::span(flat.triangles).subspan(cluster.firstTriangle, count), flat);
  }
  for (FlatGroup& group : std::span(flat.groups).first(flat.groupCount()))
    fit(group, std::span(flat.clusters).subspan(group.firstCluster, group.clusterCount));
  write({&entry, 1});
  instances_.setMesh(index, summaryOf(flat, entry.group, entry.origin));
}

}  // namespace gnosphere
