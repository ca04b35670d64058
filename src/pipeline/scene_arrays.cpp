// SPDX-License-Identifier: Apache-2.0
#include "pipeline/scene_arrays.hpp"

#include <algorithm>

namespace gnosphere {
namespace {

using gpu::Array;

// Bytes of the two lists of groups, with four numbers per group, and of the list of clusters, with two.
uint64_t groupBytes(const PlacedGroups& placed) {
  return uint64_t{std::max(placed.still.groups, placed.moving.groups)} * 2 * 4 * sizeof(uint32_t);
}
uint64_t clusterBytes(const PlacedGroups& placed) {
  return uint64_t{std::max(placed.still.clusters, placed.moving.clusters)} * 2 * sizeof(uint32_t);
}

}  // namespace

void SceneArrays::reserve(Array array, uint64_t bytes) {
  if (arrays_.holds(array, bytes)) return;
  std::unique_ptr<DeviceMemory>& memory = arrays_[array];
  const uint64_t had = memory ? memory->bytes() : 0;
  const uint64_t most = std::max(bytes, machine_.traits().info.maxBufferBytes);
  auto larger =
      machine_.allocate(gpu::nameOf(array), had > 0 ? std::min(bytes + bytes / 2, most) : bytes, MemoryKind::device);
  if (memory) larger->copyFrom(*memory, had);
  memory = std::move(larger);
  // Vertices that the device itself has written to the array are lost.
  geometry_.vertexSources().takeAgain();
}

void SceneArrays::prepareWrite(Array array, uint64_t place, uint64_t bytes) {
  if (bytes > 0) arrays_[array]->prepareWrite(place, bytes);
}

void SceneArrays::write(Array array, uint64_t place, std::span<const std::byte> data) {
  arrays_[array]->write(place, data);
}

void SceneArrays::read(Array array, uint64_t place, std::span<std::byte> data) const {
  arrays_[array]->read(place, data);
}

void SceneArrays::place(const Pose& pose, double reach, const Selection& selection, PlacedArrays& to) {
  ArrayTable& own = to.arrays_;
  to.groups_ = instances_.choose(pose, reach, selection);
  const uint64_t pairs = uint64_t{to.groups_.still.groups} + to.groups_.moving.groups;
  auto* placed = own.entries<uint32_t>(machine_, Array::placed, pairs * 2);
  // An array that grows is made anew without the numbers. The count of instances has then grown, and with it
  // the version of the numbers.
  auto* instances = own.entries<gpu::Instance>(machine_, Array::instances, instances_.count());
  const bool meshes = arrays_[Array::triangleSlots] || deformed();
  if (to.numbering_ != instances_.numbers().version() || (meshes && !own[Array::instanceMeshes])) {
    instances_.writeNumbers(instances);
    const auto& ranges = instances_.numbers().ownerRanges();
    own.load(machine_, Array::ownerRanges, std::max<size_t>(ranges.size(), 1) * sizeof(ranges[0]),
             std::as_bytes(std::span(ranges)));
    if (meshes) {
      instances_.writeMeshes(own.entries<uint32_t>(machine_, Array::instanceMeshes, instances_.count()));
      own[Array::instanceMeshes]->flush();
    }
    to.numbering_ = instances_.numbers().version();
  }
  instances_.writeTransforms(pose, instances);
  instances_.writePairs(placed);
  own[Array::instances]->flush();
  own[Array::placed]->flush();
  if (deformed()) placeDeformations(to);
}

void SceneArrays::place(std::span<const ViewPlace> views, double reach, std::span<const uint8_t> ignoredBySensor,
                        bool numbered, PlacedArrays& to) {
  ArrayTable& own = to.arrays_;
  to.groups_ = instances_.choose(views, reach, ignoredBySensor, to.inViews_);
  const uint64_t count = to.inViews_.entries.size();
  to.numbering_ = 0;  // the entries are no longer those of a single scan, even if memory runs out below
  auto* placed = own.entries<uint32_t>(machine_, Array::placed, uint64_t{to.groups_.still.groups} * 2);
  auto* instances = own.entries<gpu::Instance>(machine_, Array::instances, count);
  auto* viewOf = own.entries<uint32_t>(machine_, Array::instanceViews, count);
  instances_.writeViews(views, to.inViews_, instances, viewOf, placed);
  for (const Array array : {Array::instances, Array::instanceViews, Array::placed}) own[array]->flush();
  own.load(machine_, Array::ownerRanges, to.inViews_.runs);
  if (numbered) {
    std::ranges::transform(to.inViews_.entries, own.entries<uint32_t>(machine_, Array::instanceNumbers, count),
                           &InstanceTable::InView::instance);
    own[Array::instanceNumbers]->flush();
  }
  if (!arrays_[Array::triangleSlots] && !deformed()) return;
  instances_.writeMeshes(to.inViews_, own.entries<uint32_t>(machine_, Array::instanceMeshes, count));
  own[Array::instanceMeshes]->flush();
  if (deformed()) placeDeformations(to);
}

uint64_t SceneArrays::bytesOfView(uint32_t world, bool moves) const {
  const WorldContent content = instances_.contentOf(world);
  PlacedGroups groups;
  groups.still.groups = static_cast<uint32_t>(content.groups);
  groups.still.clusters = static_cast<uint32_t>(content.clusters);
  const uint64_t ofInstance = sizeof(gpu::Instance) + sizeof(uint32_t) + (moves ? sizeof(gpu::InstanceMotion) : 0);
  return content.instances * ofInstance + content.groups * 2 * sizeof(uint32_t) + groupBytes(groups) +
         clusterBytes(groups);
}

void SceneArrays::placeDeformations(PlacedArrays& to) {
  const Deformables& deformables = geometry_.deformables();
  if (to.deformation_ == deformables.version()) return;
  to.arrays_.load(machine_, Array::deformers, deformables.deformers());
  to.arrays_.load(machine_, Array::jointRows, deformables.jointRows());
  to.arrays_.load(machine_, Array::morphWeights, deformables.morphWeights());
  to.deformation_ = deformables.version();
}

bool SceneArrays::listsHold(const PlacedArrays& placed) const {
  return arrays_.holds(Array::shellGroups, groupBytes(placed.groups_)) &&
         arrays_.holds(Array::visible, clusterBytes(placed.groups_));
}

void SceneArrays::growLists(const PlacedArrays& placed) {
  arrays_.makeRoom(machine_, Array::shellGroups, groupBytes(placed.groups_), MemoryKind::device);
  arrays_.makeRoom(machine_, Array::visible, clusterBytes(placed.groups_), MemoryKind::device);
}

}  // namespace gnosphere
