// SPDX-License-Identifier: Apache-2.0
#include "vulkan/stages.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>

#include "base/threads.hpp"

namespace gnosphere::vulkan {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

}  // namespace

Stages::Stages(const Device& device, const Geometry& geometry, Layout& layout) : device_(device) {
  for (const GeometryChunk& chunk : geometry.chunks()) {
    const Buffer* buffers[] = {&chunk.groups,          &chunk.clusters,          &chunk.positions,
                               &chunk.triangleCorners, &chunk.clusterMaterials,  &chunk.meshPlaces,
                               &chunk.trianglePlaces,  &chunk.textureCoordinates};
    // What nothing is planned for is bound to something: no pipeline reads it.
    for (const Buffer*& buffer : buffers)
      if (!buffer->handle()) buffer = &chunk.groups;
    chunkSets_.push_back(layout.makeSet(1));
    layout.updateSet(chunkSets_.back(), std::span(buffers).first(layout.bindingCount(1)));
  }
}

void Stages::record(Commands& commands, const SensorState& state, const PlacedInstances& placed,
                    StillImage::Use use) const {
  clear(commands, state, use);
  commands.start();
  if (use != StillImage::Use::use) scanStill(commands, state, placed);
  if (use == StillImage::Use::make) {
    commands.copy(state.words(), state.stillWords());
    findOccluders(commands, state);  // as long as the image is used, the table is kept as well
  }
  if (use != StillImage::Use::none) scanMoving(commands, state, placed);
  if (state.kernels().resolve) {
    resolve(commands, state);
    commands.finished("resolve");
  }
  if (!state.plan().bare()) {
    effects(commands, state);
    commands.finished("effects");
  }
}

// Shell by shell: what is near first, since it hides much of what is far.
void Stages::scanStill(Commands& commands, const SensorState& state, const PlacedInstances& placed) const {
  float begin = 0;
  for (const float end : state.shellEnds()) {
    const bool last = end == kInfinity;
    project(commands, state, placed.still, {0, 0, begin, end, begin > 0});
    commands.finished("project");
    bin(commands, state, last);
    commands.finished("bin");
    if (!last) findOccluders(commands, state);
    begin = end;
  }
}

void Stages::scanMoving(Commands& commands, const SensorState& state, const PlacedInstances& placed) const {
  const bool any = std::any_of(placed.moving.begin(), placed.moving.end(), [](const auto& c) { return c.groups > 0; });
  if (any) project(commands, state, placed.moving, {0, 0, 0, kInfinity, 1});
  commands.finished("project");
  if (any) bin(commands, state, true);
  commands.finished("bin");
}

void Stages::clear(Commands& commands, const SensorState& state, StillImage::Use use) const {
  commands.fill(state.buffer(gpu::kBindCounters), 0, VK_WHOLE_SIZE, 0);
  if (use == StillImage::Use::use)
    commands.copy(state.stillWords(), state.words());
  else if (state.binning() == gpu::kBinningLists)
    commands.fill(state.buffer(gpu::kBindListEnds), 0, VK_WHOLE_SIZE, 0);
  else
    commands.fill(state.words(), 0, VK_WHOLE_SIZE, gpu::kNone);
  if (state.binning() == gpu::kBinningSlabs)
    commands.fill(state.buffer(gpu::kBindListEnds), 0, VK_WHOLE_SIZE, gpu::kNone);
  commands.barrier();
}

void Stages::project(Commands& commands, const SensorState& state, std::span<const PlacedInstances::Chunk> chunks,
                     gpu::Pass pass) const {
  for (size_t i = 0; i < chunkSets_.size(); ++i) {
    if (i > 0 || pass.occluders) {
      commands.fill(state.buffer(gpu::kBindCounters), offsetof(gpu::Counters, visibleGroups),
                    i > 0 ? kPerChunkBytes : kPerShellBytes, 0);
      commands.barrier();
    }
    const PlacedInstances::Chunk& chunk = chunks[i];
    commands.bindSet(1, chunkSets_[i]);
    pass.placedFirst = chunk.first;
    pass.placedCount = chunk.groups;
    commands.push(pass);
    commands.dispatch(state.kernels().projectGroups, std::min(cullGroupCount(), (chunk.groups + 63) / 64));
    commands.dispatch(state.kernels().projectClusters, std::min(cullGroupCount(), chunk.groups));
    commands.dispatch(state.kernels().projectTriangles, std::min(triangleGroupCount(state), chunk.clusters));
  }
}

void Stages::bin(Commands& commands, const SensorState& state, bool lastShell) const {
  const Kernels& kernels = state.kernels();
  const uint32_t blocks = state.frame().beams / gpu::kPrefixBlock + 1;
  commands.dispatch(kernels.bin[0], triangleGroupCount(state));
  if (!lastShell) return;
  for (size_t pass = 0; pass < kernels.prefixSum.size(); ++pass)
    commands.dispatch(kernels.prefixSum[pass], pass == gpu::kPrefixBlocks ? 1 : std::min(groupCount(), blocks));
  if (kernels.bin.size() > 1) commands.dispatch(kernels.bin[1], groupCount());
}

void Stages::findOccluders(Commands& commands, const SensorState& state) const {
  commands.dispatch(state.kernels().projectOccluders, cullGroupCount());
}

void Stages::resolve(Commands& commands, const SensorState& state) const {
  const uint32_t groups = (state.frame().columns + gpu::kResolveColumns - 1) / gpu::kResolveColumns;
  commands.dispatch(*state.kernels().resolve, groups, state.frame().rows);
}

void Stages::effects(Commands& commands, const SensorState& state) const {
  const uint32_t groups = (state.frame().columns + gpu::kResolveColumns - 1) / gpu::kResolveColumns;
  for (const Kernel& pass : state.kernels().footprint)
    commands.dispatch(pass, std::min(8 * groupCount(), state.frame().beams));
  if (state.kernels().surfaces)
    for (VkDescriptorSet chunk : chunkSets_) {
      commands.bindSet(1, chunk);
      commands.dispatch(*state.kernels().surfaces, groups, state.frame().rows);
    }
  if (!state.kernels().effects) return;
  commands.push({});
  commands.dispatch(*state.kernels().effects, groups, state.frame().rows);
}

void Stages::count(Plan& plan, const SensorState& state) const {
  const auto chunks = static_cast<uint32_t>(chunkSets_.size());
  const auto shells = static_cast<uint32_t>(state.shellEnds().size());
  const Kernels& kernels = state.kernels();
  for (Plan::Stage& stage : plan.stages) {
    if (stage.name == "project") stage.dispatches = shells * 3 * chunks + (shells - 1);
    if (stage.name == "bin")
      stage.dispatches = shells - 1 + static_cast<uint32_t>(kernels.bin.size() + kernels.prefixSum.size());
    if (stage.name == "resolve") stage.dispatches = kernels.resolve ? 1 : 0;
    if (stage.name == "effects")
      stage.dispatches =
          static_cast<uint32_t>(kernels.footprint.size()) + (kernels.surfaces ? chunks : 0) + (kernels.effects ? 1 : 0);
  }
}

// A fixed number of workgroups loops over however many items there are: legal on every device, and no dispatch needs to
// know a count that only the device has. On a software device neighbouring workgroups share a thread, so the loop's
// stride also spreads uneven work over the threads; four times as many took 1.05 of the time.
uint32_t Stages::groupCount() const {
  return device_.capabilities().cpu ? std::max(64u, 8 * threadCount()) : 4096;
}

// Boxes and entries of a table take alike: few are balanced, and each workgroup more costs a CPU its start. 64 of them
// on two threads took 1.04 of all of `project`.
uint32_t Stages::cullGroupCount() const {
  return device_.capabilities().cpu ? 4 * threadCount() : groupCount();
}

// With slabs whoever is free takes what is next until nothing is left: on a CPU a workgroup per thread is enough then,
// and each one more asks in vain.
uint32_t Stages::triangleGroupCount(const SensorState& state) const {
  return device_.capabilities().cpu && state.binning() == gpu::kBinningSlabs ? threadCount() : groupCount();
}

}  // namespace gnosphere::vulkan
