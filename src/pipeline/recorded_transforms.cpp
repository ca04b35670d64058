// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recorded_transforms.hpp"

#include <algorithm>

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
  const size_t count = transforms.buffers().size();
  auto* sources = arrays_.entries<gpu::TransformSource>(machine, Array::transformSources, count);
  auto* buffers = arrays_.entries<gpu::CallerBuffer>(machine, Array::transformBuffers, count);
  auto* transformed =
      arrays_.entries<gpu::TransformedInstance>(machine, Array::transformedInstances, transforms.count());
  arrays_.makeRoom(machine, Array::unplacedInstances, sizeof(uint32_t), MemoryKind::readback);
  arrays_.bind(arrays);
  instances.writeTransformSources(pose, sources, buffers, transformed);
  for (const Array array : {Array::transformSources, Array::transformBuffers, Array::transformedInstances})
    arrays_[array]->flush();
  std::vector<Step> steps = {Step{Step::Kind::fill, "", Array::unplacedInstances}, Step{Step::Kind::dispatch}};
  steps[1].variant = kPlaceInstances;
  steps[1].pass.placedCount = static_cast<uint32_t>(transforms.count());
  steps[1].workgroupsX =
      std::min(machine.traits().workgroups, (steps[1].pass.placedCount + kInstancesPerGroup - 1) / kInstancesPerGroup);
  return steps;
}

uint32_t RecordedTransforms::unplaced() {
  if (!recorded_) return 0;
  DeviceMemory& memory = *arrays_[Array::unplacedInstances];
  memory.invalidate();
  return *static_cast<const uint32_t*>(memory.host());
}

}  // namespace gnosphere
