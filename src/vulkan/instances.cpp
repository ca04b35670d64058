// SPDX-License-Identifier: Apache-2.0
#include "vulkan/instances.hpp"

#include <algorithm>

namespace gnosphere::vulkan {
namespace {

// Room for `count` and some more, so that a scene that grows does not allocate with every scan.
void makeRoom(const Device& device, const char* name, uint64_t bytes, Buffer& buffer, Memory memory = Memory::upload) {
  if (buffer.bytes() >= bytes && buffer.handle()) return;
  const uint64_t more = std::min(bytes + bytes / 4, std::max(bytes, device.maxBufferBytes()));
  buffer = Buffer(device, name, buffer.handle() ? more : bytes, memory);
}

// Of a list with an entry per group or cluster of the chunk that has the most.
uint64_t listBytes(const PlacedInstances& placed, uint32_t PlacedInstances::Chunk::*count) {
  uint64_t most = 0;
  for (const auto* chunks : {&placed.still, &placed.moving})
    for (const PlacedInstances::Chunk& chunk : *chunks) most = std::max<uint64_t>(most, chunk.*count);
  return most * 2 * sizeof(uint32_t);
}

}  // namespace

bool VisibleLists::hold(const PlacedInstances& placed) const {
  return groups.handle() && groups.bytes() >= listBytes(placed, &PlacedInstances::Chunk::groups) &&
         clusters.bytes() >= listBytes(placed, &PlacedInstances::Chunk::clusters);
}

void VisibleLists::makeRoomFor(const PlacedInstances& placed, const Device& device) {
  makeRoom(device, "visibleGroups", listBytes(placed, &PlacedInstances::Chunk::groups), groups, Memory::device);
  makeRoom(device, "visible", listBytes(placed, &PlacedInstances::Chunk::clusters), clusters, Memory::device);
}

void Instances::place(const Pose& pose, double reach, const Selection& selection, PlacedInstances& to) {
  choose(pose, reach, selection, to);
  makeRoom(device_, "placed", uint64_t{to.pairs} * 8, to.placed);
  const VkBuffer handle = to.instances.handle();
  makeRoom(device_, "instances", count() * sizeof(gpu::Instance), to.instances);
  auto* instances = static_cast<gpu::Instance*>(to.instances.mapped());
  if (to.instances.handle() != handle || to.numbering != numbering()) {
    writeNumbers(instances);
    makeRoom(device_, "ownerRanges", ownerRangeCount() * 8, to.ownerRanges);
    writeOwnerRanges(static_cast<uint32_t*>(to.ownerRanges.mapped()));
    to.ownerRanges.flush();
    if (surfaces_) {
      makeRoom(device_, "instanceMeshes", count() * sizeof(uint32_t), to.meshes);
      writeMeshes(static_cast<uint32_t*>(to.meshes.mapped()));
      to.meshes.flush();
    }
    to.numbering = numbering();
  }
  writeTransforms(pose, instances);
  writePairs(to, static_cast<uint32_t*>(to.placed.mapped()));
  to.instances.flush();
  to.placed.flush();
}

}  // namespace gnosphere::vulkan
