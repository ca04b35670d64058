// SPDX-License-Identifier: Apache-2.0
#include "pipeline/scene_arrays.hpp"

#include <algorithm>
#include <array>

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

bool holds(const std::unique_ptr<DeviceMemory>& memory, uint64_t bytes) {
  return memory && memory->bytes() >= bytes;
}

}  // namespace

void makeRoom(Machine& machine, gpu::Array array, uint64_t bytes, MemoryKind kind,
              std::unique_ptr<DeviceMemory>& memory) {
  if (holds(memory, bytes)) return;
  const uint64_t limit = std::max(bytes, machine.traits().info.maxBufferBytes);
  const uint64_t room = memory ? std::min(bytes + bytes / 4, limit) : bytes;
  memory.reset();
  memory = machine.allocate(gpu::nameOf(array), room, kind);
}

void load(Machine& machine, gpu::Array array, uint64_t bytes, std::span<const std::byte> data,
          std::unique_ptr<DeviceMemory>& memory) {
  makeRoom(machine, array, bytes, MemoryKind::upload, memory);
  std::copy(data.begin(), data.end(), static_cast<std::byte*>(memory->host()));
  memory->flush();
}

void PlacedArrays::bind(BoundArrays& arrays) const {
  arrays[static_cast<size_t>(Array::instances)] = instances_.get();
  arrays[static_cast<size_t>(Array::placed)] = placed_.get();
  arrays[static_cast<size_t>(Array::instanceMeshes)] = meshes_.get();
  arrays[static_cast<size_t>(Array::instanceViews)] = views_.get();
  arrays[static_cast<size_t>(Array::instanceNumbers)] = numbers_.get();
  arrays[static_cast<size_t>(Array::ownerRanges)] = ownerRanges_.get();
  arrays[static_cast<size_t>(Array::deformers)] = deformers_.get();
  arrays[static_cast<size_t>(Array::jointRows)] = jointRows_.get();
  arrays[static_cast<size_t>(Array::morphWeights)] = morphWeights_.get();
}

uint64_t PlacedArrays::bytes() const {
  uint64_t sum = 0;
  for (const auto* memory :
       {&instances_, &placed_, &meshes_, &views_, &numbers_, &ownerRanges_, &deformers_, &jointRows_, &morphWeights_})
    sum += *memory ? (*memory)->bytes() : 0;
  return sum;
}

uint64_t SceneArrays::bytes() const {
  uint64_t sum = 0;
  for (const auto& memory : memory_) sum += memory ? memory->bytes() : 0;
  return sum;
}

void SceneArrays::bind(BoundArrays& arrays) const {
  for (size_t i = 0; i < memory_.size(); ++i)
    if (memory_[i]) arrays[i] = memory_[i].get();
}

void SceneArrays::reserve(Array array, uint64_t bytes) {
  std::unique_ptr<DeviceMemory>& memory = of(array);
  if (holds(memory, bytes)) return;
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
  if (bytes > 0) of(array)->prepareWrite(place, bytes);
}

void SceneArrays::write(Array array, uint64_t place, std::span<const std::byte> data) {
  of(array)->write(place, data);
}

void SceneArrays::read(Array array, uint64_t place, std::span<std::byte> data) const {
  of(array)->read(place, data);
}

void SceneArrays::place(const Pose& pose, double reach, const Selection& selection, PlacedArrays& to) {
  to.groups_ = instances_.choose(pose, reach, selection);
  const uint64_t pairs = uint64_t{to.groups_.still.groups} + to.groups_.moving.groups;
  const auto room = [&](Array array, uint64_t bytes, std::unique_ptr<DeviceMemory>& memory) {
    makeRoom(machine_, array, bytes, MemoryKind::upload, memory);
  };
  room(Array::placed, pairs * 2 * sizeof(uint32_t), to.placed_);
  // An array that grows is made anew without the numbers. The count of instances has then grown, and with it
  // the version of the numbers.
  room(Array::instances, instances_.count() * sizeof(gpu::Instance), to.instances_);
  auto* instances = static_cast<gpu::Instance*>(to.instances_->host());
  const bool meshes = of(Array::triangleSlots) != nullptr || deformed();
  if (to.numbering_ != instances_.numbers().version() || (meshes && !to.meshes_)) {
    instances_.writeNumbers(instances);
    const auto& ranges = instances_.numbers().ownerRanges();
    room(Array::ownerRanges, std::max<size_t>(ranges.size(), 1) * sizeof(ranges[0]), to.ownerRanges_);
    std::ranges::copy(ranges, static_cast<std::array<uint32_t, 2>*>(to.ownerRanges_->host()));
    to.ownerRanges_->flush();
    if (meshes) {
      room(Array::instanceMeshes, instances_.count() * sizeof(uint32_t), to.meshes_);
      instances_.writeMeshes(static_cast<uint32_t*>(to.meshes_->host()));
      to.meshes_->flush();
    }
    to.numbering_ = instances_.numbers().version();
  }
  instances_.writeTransforms(pose, instances);
  instances_.writePairs(static_cast<uint32_t*>(to.placed_->host()));
  to.instances_->flush();
  to.placed_->flush();
  if (deformed()) placeDeformations(to);
}

void SceneArrays::place(std::span<const ViewPlace> views, double reach, std::span<const uint8_t> ignored, bool numbered,
                        PlacedArrays& to) {
  to.groups_ = instances_.choose(views, reach, ignored, to.inViews_);
  const uint64_t count = to.inViews_.entries.size();
  to.numbering_ = 0;  // the entries are no longer those of a single scan, even if memory runs out below
  const auto room = [&](Array array, uint64_t bytes, std::unique_ptr<DeviceMemory>& memory) {
    makeRoom(machine_, array, bytes, MemoryKind::upload, memory);
  };
  room(Array::placed, uint64_t{to.groups_.still.groups} * 2 * sizeof(uint32_t), to.placed_);
  room(Array::instances, count * sizeof(gpu::Instance), to.instances_);
  room(Array::instanceViews, count * sizeof(uint32_t), to.views_);
  instances_.writeViews(views, to.inViews_, static_cast<gpu::Instance*>(to.instances_->host()),
                        static_cast<uint32_t*>(to.views_->host()), static_cast<uint32_t*>(to.placed_->host()));
  to.instances_->flush();
  to.views_->flush();
  to.placed_->flush();
  room(Array::ownerRanges, to.inViews_.runs.size() * 2 * sizeof(uint32_t), to.ownerRanges_);
  std::ranges::copy(to.inViews_.runs, static_cast<std::array<uint32_t, 2>*>(to.ownerRanges_->host()));
  to.ownerRanges_->flush();
  if (numbered) {
    room(Array::instanceNumbers, count * sizeof(uint32_t), to.numbers_);
    std::ranges::transform(to.inViews_.entries, static_cast<uint32_t*>(to.numbers_->host()),
                           &InstanceTable::InView::instance);
    to.numbers_->flush();
  }
  if (!of(Array::triangleSlots) && !deformed()) return;
  room(Array::instanceMeshes, count * sizeof(uint32_t), to.meshes_);
  instances_.writeMeshes(to.inViews_, static_cast<uint32_t*>(to.meshes_->host()));
  to.meshes_->flush();
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
  const auto put = [&](Array array, std::span<const std::byte> content, std::unique_ptr<DeviceMemory>& memory) {
    load(machine_, array, content.size(), content, memory);
  };
  put(Array::deformers, std::as_bytes(deformables.deformers()), to.deformers_);
  put(Array::jointRows, std::as_bytes(deformables.jointRows()), to.jointRows_);
  put(Array::morphWeights, std::as_bytes(deformables.morphWeights()), to.morphWeights_);
  to.deformation_ = deformables.version();
}

bool SceneArrays::listsHold(const PlacedArrays& placed) const {
  return holds(of(Array::shellGroups), groupBytes(placed.groups_)) &&
         holds(of(Array::visible), clusterBytes(placed.groups_));
}

void SceneArrays::growLists(const PlacedArrays& placed) {
  makeRoom(machine_, Array::shellGroups, groupBytes(placed.groups_), MemoryKind::device, of(Array::shellGroups));
  makeRoom(machine_, Array::visible, clusterBytes(placed.groups_), MemoryKind::device, of(Array::visible));
}

}  // namespace gnosphere
