// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recorded_transforms.hpp"

#include <algorithm>

#include "pipeline/scene_arrays.hpp"

namespace gnosphere {
namespace {

using gpu::Array;

constexpr uint32_t kInstancesPerGroup = 64;  // of the kernel
const Variant kPlaceInstances = {Kernel::place_instances, {}, false};

}  // namespace

void RecordedTransforms::prepare(Machine& machine) {
  machine.prepare({&kPlaceInstances, 1});
  machine.prepared();
}

std::vector<Step> RecordedTransforms::steps(Machine& machine, const InstanceTable& instances, const Pose& pose,
                                            BoundArrays& arrays) {
  const TransformSources& transforms = instances.transformSources();
  recorded_ = transforms.any();
  if (!recorded_) return {};
  const auto room = [&]<typename T>(Array array, size_t count, MemoryKind kind, std::unique_ptr<DeviceMemory>& memory,
                                    T*& to) {
    makeRoom(machine, array, count * sizeof(T), kind, memory);
    arrays[static_cast<size_t>(array)] = memory.get();
    to = static_cast<T*>(memory->host());
  };
  gpu::TransformSource* sources;
  gpu::CallerBuffer* buffers;
  gpu::TransformedInstance* transformed;
  uint32_t* unplaced;
  room(Array::transformSources, transforms.buffers().size(), MemoryKind::upload, sources_, sources);
  room(Array::transformBuffers, transforms.buffers().size(), MemoryKind::upload, buffers_, buffers);
  room(Array::transformedInstances, transforms.count(), MemoryKind::upload, instances_, transformed);
  room(Array::unplacedInstances, 1, MemoryKind::readback, unplaced_, unplaced);
  instances.writeTransformSources(pose, sources, buffers, transformed);
  for (const auto* memory : {&sources_, &buffers_, &instances_}) (*memory)->flush();
  std::vector<Step> steps = {Step{Step::Kind::fill, "", Array::unplacedInstances}, Step{Step::Kind::dispatch}};
  steps[1].variant = kPlaceInstances;
  steps[1].pass.placedCount = static_cast<uint32_t>(transforms.count());
  steps[1].workgroupsX =
      std::min(machine.traits().workgroups, (steps[1].pass.placedCount + kInstancesPerGroup - 1) / kInstancesPerGroup);
  return steps;
}

uint32_t RecordedTransforms::unplaced() {
  if (!recorded_) return 0;
  unplaced_->invalidate();
  return *static_cast<const uint32_t*>(unplaced_->host());
}

uint64_t RecordedTransforms::bytes() const {
  uint64_t sum = 0;
  for (const auto* memory : {&sources_, &buffers_, &instances_, &unplaced_}) sum += *memory ? (*memory)->bytes() : 0;
  return sum;
}

}  // namespace gnosphere
