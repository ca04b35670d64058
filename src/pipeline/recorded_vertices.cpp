// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recorded_vertices.hpp"

#include <algorithm>
#include <utility>

namespace gnosphere {
namespace {

using gpu::Array;

const Variant kFitClusters = {Kernel::fit_clusters, {}, false};

}  // namespace

void RecordedVertices::prepare() {
  if (prepared_) return;
  machine_.prepare({&kFitClusters, 1});
  machine_.prepared();
  prepared_ = true;
}

void RecordedVertices::readDropped(size_t number) {
  if (number >= frames_.size() || frames_[number].meshes.empty()) return;
  Frame& frame = frames_[number];
  DeviceMemory& memory = *frame.arrays[Array::droppedTriangles];
  memory.invalidate();
  const auto* dropped = static_cast<const VertexSources::Dropped*>(memory.host());
  for (size_t i = 0; i < frame.meshes.size(); ++i)
    scene_.geometry().vertexSources().setDropped(frame.meshes[i], dropped[i]);
  frame.meshes.clear();
}

void RecordedVertices::record(size_t number) {
  VertexSources& vertexSources = scene_.geometry().vertexSources();
  const VertexSources::Work& work = vertexSources.changed();
  if (work.groups.empty()) return;
  while (frames_.size() <= number) frames_.emplace_back();
  Frame& frame = frames_[number];
  if (!frame.addresses) frame.addresses = machine_.allocate("addresses", sizeof(gpu::Addresses), MemoryKind::upload);
  BoundArrays arrays = {};
  scene_.bind(arrays);
  frame.arrays.load(machine_, Array::vertexSources, work.sources);
  frame.arrays.load(machine_, Array::vertexBuffers, work.buffers);
  frame.arrays.load(machine_, Array::sourceGroups, work.groups);
  frame.arrays.makeRoom(machine_, Array::droppedTriangles, work.meshes.size() * sizeof(VertexSources::Dropped),
                        MemoryKind::readback);
  frame.arrays.bind(arrays);
  std::vector<size_t> meshes = work.meshes;
  std::array<Step, 2> steps = {Step{Step::Kind::fill, "", Array::droppedTriangles}, Step{Step::Kind::dispatch}};
  steps[1].variant = kFitClusters;
  steps[1].pass.placedCount = static_cast<uint32_t>(work.groups.size());
  steps[1].workgroupsX = std::min(machine_.traits().workgroups, steps[1].pass.placedCount);
  machine_.record(*frame.addresses, steps, arrays);
  frame.meshes = std::move(meshes);
  vertexSources.taken();
}

void RecordedVertices::abandon(size_t number) noexcept {
  if (number >= frames_.size()) return;
  for (const size_t mesh : frames_[number].meshes) scene_.geometry().vertexSources().takeAgain(mesh);
  frames_[number].meshes.clear();
}

uint64_t RecordedVertices::bytes() const {
  uint64_t sum = 0;
  for (const Frame& frame : frames_) sum += frame.arrays.bytes();
  return sum;
}

}  // namespace gnosphere
