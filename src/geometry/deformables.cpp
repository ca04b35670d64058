// SPDX-License-Identifier: Apache-2.0
#include "geometry/deformables.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

#include "common/deform.h"
#include "geometry/deform.hpp"

namespace gnosphere {
namespace {

using gpu::Array;

static_assert(3 * gpu::kClusterTriangles * gpu::kMostInfluences <= gpu::kMostBones,
              "every bone of a cluster has a number");

// Extends the box of a joint; the boxes are in the order of the joints.
void include(std::vector<JointBox>& boxes, uint32_t joint, const gpu::vec3& position) {
  auto place = std::find_if(boxes.begin(), boxes.end(), [&](const JointBox& other) { return other.joint >= joint; });
  if (place == boxes.end() || place->joint != joint) place = boxes.insert(place, {joint, position, position});
  place->low = glm::min(place->low, position);
  place->high = glm::max(place->high, position);
}

uint32_t unitsOf(const Influence& influence) {
  return static_cast<uint32_t>(influence.weight * gpu::kWeightUnits);
}

// Appends the bones of a cluster, and their weights at its vertices.
gpu::ClusterBones addClusterBones(std::span<const std::vector<Influence>> influences, std::vector<uint32_t>& bones,
                                  std::vector<uint32_t>& weights) {
  struct Bone {
    uint32_t number = 0;  // among those of the cluster
    uint32_t least = gpu::kWeightUnits;
    size_t vertices = 0;  // that follow the joint
  };
  std::map<uint32_t, Bone> own;  // by joint
  size_t most = 0;
  for (const std::vector<Influence>& vertex : influences) {
    most = std::max(most, vertex.size());
    for (const Influence& influence : vertex) {
      Bone& bone = own[influence.joint];
      bone.least = std::min(bone.least, unitsOf(influence));
      ++bone.vertices;
    }
  }
  gpu::ClusterBones result;
  result.first = static_cast<uint32_t>(bones.size());
  result.count = static_cast<uint32_t>(own.size());
  result.weightFirst = static_cast<uint32_t>(weights.size());
  result.influences = static_cast<uint32_t>(most);
  for (auto& [joint, bone] : own) {
    bone.number = static_cast<uint32_t>(bones.size()) - result.first;
    bones.push_back(gpu::packedBone(joint, bone.vertices == influences.size() ? bone.least : 0));
  }
  for (const std::vector<Influence>& vertex : influences)
    for (size_t k = 0; k < most; ++k)
      weights.push_back(k < vertex.size() ? gpu::packedWeight(own[vertex[k].joint].number, unitsOf(vertex[k])) : 0);
  return result;
}

// The rows of the map that moves nothing.
constexpr gpu::vec4 kIdentity[] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};

// Encloses what a joint makes of a box. The device's boxes of clusters are rounded, so those of groups have twice their
// margin.
void addBone(const JointBox& bone, const gpu::Deformer& deformer, std::span<const gpu::vec4> rows, FlatGroup& group) {
  const gpu::vec3 low = bone.low + deformer.morphLow, high = bone.high + deformer.morphHigh;
  const gpu::vec4* own = bone.joint == gpu::kNone ? kIdentity : &rows[3 * size_t{bone.joint}];
  for (int axis = 0; axis < 3; ++axis) {
    const gpu::vec2 span = gpu::spanThrough(own[axis], 0.5f * (low + high), 0.5f * (high - low), 2 * gpu::kBoneMargin);
    group.low[axis] = std::min(group.low[axis], span.x - span.y);
    group.high[axis] = std::max(group.high[axis], span.x + span.y);
  }
}

// Returns an upper bound of the distance between where two maps (three rows each) take a point of a box.
double farthest(const gpu::vec4* from, const gpu::vec4* to, const gpu::vec3& low, const gpu::vec3& high) {
  double squares = 0;
  for (int row = 0; row < 3; ++row) {
    const double a = double{to[row].x} - from[row].x, b = double{to[row].y} - from[row].y,
                 c = double{to[row].z} - from[row].z, d = double{to[row].w} - from[row].w;
    // Each coordinate of the change is linear, so it is largest at a corner.
    const double most = std::max(std::abs(a * low.x), std::abs(a * high.x)) +
                        std::max(std::abs(b * low.y), std::abs(b * high.y)) +
                        std::max(std::abs(c * low.z), std::abs(c * high.z)) + std::abs(d);
    squares += most * most;
  }
  return std::sqrt(squares);
}

double lengthOf(const gpu::vec3& v) {
  return std::sqrt(double{v.x} * v.x + double{v.y} * v.y + double{v.z} * v.z);
}

template <typename T>
void write(SceneMemory& memory, Array array, uint64_t first, const std::vector<T>& entries) {
  if (!entries.empty()) memory.write(array, first * sizeof(T), std::as_bytes(std::span(entries)));
}

}  // namespace

void Deformables::add(size_t index, const Mesh& mesh, const FlatMesh& flat, uint64_t vertex, uint64_t cluster) {
  Entry entry;
  entry.origin = mesh.origin;
  entry.vertices = flat.vertices.size();
  entry.clusters = flat.clusterCount();
  entry.restGroups.assign(flat.groups.begin(), flat.groups.begin() + flat.groupCount());
  entry.groups.resize(flat.groupCount());

  std::vector<gpu::ClusterBones> clusters;
  std::vector<uint32_t> bones, weights;
  std::vector<gpu::vec3> positions, offsets;
  std::vector<std::vector<Influence>> influences;
  for (size_t g = 0; g < flat.groupCount(); ++g)
    for (size_t c = flat.groups[g].firstCluster; c < flat.groups[g].firstCluster + flat.groups[g].clusterCount; ++c) {
      const size_t first = flat.clusters[c].firstVertex, count = flat.clusters[c + 1].firstVertex - first;
      influences.resize(count);
      for (size_t i = 0; i < count; ++i) {
        influencesOf(mesh, flat.vertices[first + i], influences[i]);
        const gpu::vec3 position = vertexAt(mesh.positions, flat.vertices[first + i]);
        if (!inLimits(&position.x)) continue;
        if (mesh.influences == 0) include(entry.groups[g], gpu::kNone, position);
        for (const Influence& influence : influences[i]) include(entry.groups[g], influence.joint, position);
      }
      clusters.push_back(addClusterBones(influences, bones, weights));
    }
  for (const uint32_t v : flat.vertices) positions.push_back(vertexAt(mesh.positions, v));
  for (const std::vector<float>& target : mesh.morphTargets)
    for (const uint32_t v : flat.vertices) offsets.push_back(vertexAt(target, v));
  for (const std::vector<float>& target : mesh.morphTargets) {
    std::array<gpu::vec3, 2>& bounds = entry.offsetBounds.emplace_back();
    for (size_t v = 0; v < mesh.vertexCount(); ++v)
      if (const gpu::vec3 offset = vertexAt(target, v); inLimits(&offset.x))
        bounds = {glm::min(bounds[0], offset), glm::max(bounds[1], offset)};
  }

  gpu::Deformer deformer = {};
  deformer.joints = mesh.jointCount;
  deformer.vertices = static_cast<uint32_t>(flat.vertices.size());
  deformer.targets = static_cast<uint32_t>(mesh.morphTargets.size());
  deformer.vertexFirst = static_cast<uint32_t>(vertex);
  deformer.clusterFirst = static_cast<uint32_t>(cluster);
  TakenRuns runs;
  const auto take = [&](Ranges& ranges, uint64_t count) { return static_cast<uint32_t>(runs.take(ranges, count)); };
  deformer.restFirst = take(vertices_, entry.vertices);
  deformer.offsetFirst = take(offsets_, offsets.size());
  deformer.weightFirst = take(weights_, deformer.targets);
  deformer.rowFirst = take(rows_, 3 * uint64_t{mesh.jointCount});
  deformer.bonesFirst = take(clusterBones_, clusters.size());
  entry.bones = bones.size();
  entry.firstBone = take(bones_, bones.size());
  entry.weights = weights.size();
  entry.firstWeight = take(boneWeights_, weights.size());
  for (gpu::ClusterBones& own : clusters) {
    own.first += static_cast<uint32_t>(entry.firstBone);
    own.weightFirst += static_cast<uint32_t>(entry.firstWeight);
  }

  jointRows_.resize(std::max<size_t>(jointRows_.size(), rows_.end()));
  morphWeights_.resize(std::max<size_t>(morphWeights_.size(), weights_.end()));
  ++version_;
  reserve();
  write(memory_, Array::restPositions, deformer.restFirst, positions);
  write(memory_, Array::morphOffsets, deformer.offsetFirst, offsets);
  write(memory_, Array::clusterBones, deformer.bonesFirst, clusters);
  write(memory_, Array::bones, entry.firstBone, bones);
  write(memory_, Array::boneWeights, entry.firstWeight, weights);
  meshes_.insert_or_assign(index, std::move(entry));
  deformers_[index] = deformer;
  runs.keep();
}

void Deformables::reserve() {
  memory_.reserve(Array::restPositions, vertices_.end() * sizeof(gpu::vec3));
  memory_.reserve(Array::morphOffsets, offsets_.end() * sizeof(gpu::vec3));
  memory_.reserve(Array::clusterBones, clusterBones_.end() * sizeof(gpu::ClusterBones));
  memory_.reserve(Array::bones, bones_.end() * sizeof(uint32_t));
  memory_.reserve(Array::boneWeights, boneWeights_.end() * sizeof(uint32_t));
}

void Deformables::setMeshCount(size_t count) {
  deformers_.resize(count + 1);
  ++version_;
}

void Deformables::remove(size_t index) noexcept {
  const auto found = meshes_.find(index);
  if (found == meshes_.end()) return;
  const Entry& entry = found->second;
  const gpu::Deformer& deformer = deformers_[index];
  vertices_.giveBack(deformer.restFirst, entry.vertices);
  offsets_.giveBack(deformer.offsetFirst, entry.vertices * deformer.targets);
  weights_.giveBack(deformer.weightFirst, deformer.targets);
  rows_.giveBack(deformer.rowFirst, 3 * uint64_t{deformer.joints});
  clusterBones_.giveBack(deformer.bonesFirst, entry.clusters);
  bones_.giveBack(entry.firstBone, entry.bones);
  boneWeights_.giveBack(entry.firstWeight, entry.weights);
  deformers_[index] = {};
  meshes_.erase(found);
  ++version_;
}

// Writes the maps of a mesh's joints and the weights of its morph targets; an empty deformation moves nothing.
void Deformables::writeMaps(const Entry& entry, const gpu::Deformer& deformer, const Deformation& deformation,
                            std::vector<gpu::vec4>& rows, std::vector<float>& weights) {
  const std::vector<JointMap> maps = jointMapsOf(entry.origin, deformation);
  for (uint32_t joint = 0; joint < deformer.joints; ++joint)
    for (uint32_t row = 0; row < 3; ++row) {
      const float* values = maps.empty() ? nullptr : &maps[joint][4 * row];
      rows[deformer.rowFirst + 3 * joint + row] =
          values ? gpu::vec4{values[0], values[1], values[2], values[3]} : kIdentity[row];
    }
  for (uint32_t target = 0; target < deformer.targets; ++target)
    weights[deformer.weightFirst + target] = deformation.empty() ? 0 : deformation.morphWeights[target];
}

void Deformables::deform(size_t index, const Deformation& deformation, FlatMesh& flat) {
  const Entry& entry = meshes_.at(index);
  gpu::Deformer& deformer = deformers_[index];
  writeMaps(entry, deformer, deformation, jointRows_, morphWeights_);  // allocates before it writes
  ++version_;
  deformer.deformed = !deformation.empty();
  deformer.morphLow = deformer.morphHigh = gpu::vec3(0);
  for (size_t target = 0; target < entry.offsetBounds.size(); ++target) {
    const float weight = morphWeights_[deformer.weightFirst + target];
    const auto& [low, high] = entry.offsetBounds[target];
    deformer.morphLow += glm::min(weight * low, weight * high);
    deformer.morphHigh += glm::max(weight * low, weight * high);
  }
  if (deformation.empty()) {
    std::copy(entry.restGroups.begin(), entry.restGroups.end(), flat.groups.begin());
    return;
  }
  const std::span rows = std::span(jointRows_).subspan(deformer.rowFirst);
  for (size_t g = 0; g < entry.groups.size(); ++g) {
    FlatGroup& group = flat.groups[g];
    std::fill(group.low, group.low + 3, gpu::kCoordinateLimit);
    std::fill(group.high, group.high + 3, -gpu::kCoordinateLimit);
    for (const JointBox& bone : entry.groups[g]) addBone(bone, deformer, rows, group);
  }
}

double Deformables::writeEnd(size_t index, const Deformation& deformation, End& to) const {
  const Entry& entry = meshes_.at(index);
  const gpu::Deformer& deformer = deformers_[index];
  to.jointRows.resize(jointRows_.size());
  to.morphWeights.resize(morphWeights_.size());
  writeMaps(entry, deformer, deformation, to.jointRows, to.morphWeights);

  // The distance that a vertex moves is at most the sum of two: how far its joints move it, and how far the morph
  // targets do, which the maps of its joints stretch.
  double morphed = 0, most = 0;
  for (size_t target = 0; target < entry.offsetBounds.size(); ++target) {
    const auto& [low, high] = entry.offsetBounds[target];
    const size_t place = deformer.weightFirst + target;
    morphed += std::abs(double{to.morphWeights[place]} - morphWeights_[place]) *
               lengthOf(glm::max(glm::abs(low), glm::abs(high)));
  }
  if (deformer.joints == 0) return morphed;
  for (const std::vector<JointBox>& group : entry.groups)
    for (const JointBox& bone : group) {
      const size_t place = deformer.rowFirst + 3 * size_t{bone.joint};
      const gpu::vec4* end = &to.jointRows[place];
      double stretch = 0;
      for (int row = 0; row < 3; ++row)
        stretch += double{end[row].x} * end[row].x + double{end[row].y} * end[row].y + double{end[row].z} * end[row].z;
      most = std::max(most,
                      farthest(&jointRows_[place], end, bone.low + deformer.morphLow, bone.high + deformer.morphHigh) +
                          std::sqrt(stretch) * morphed);
    }
  return most;
}

}  // namespace gnosphere
