// SPDX-License-Identifier: Apache-2.0
#include "vulkan/sensor_state.hpp"

#include <algorithm>
#include <cstring>
#include <span>

namespace gnosphere::vulkan {
namespace {

Options kernelOptions(const SimulatorOptions& options, bool azimuthOffsets, const SensorPlan& plan) {
  // The enumerations of the public API and the constants of shared.h count alike.
  const Exactness parts = exactnessOf(options);
  Options result;
  result.bounds = static_cast<uint32_t>(parts.bounds);
  result.cull = static_cast<uint32_t>(parts.cull);
  result.inside = static_cast<uint32_t>(parts.inside);
  result.range = static_cast<uint32_t>(parts.range);
  result.azimuthOffsets = azimuthOffsets;
  result.faces = static_cast<uint32_t>(options.faces);
  result.culling = cullingBits(options);
  result.effects = plan.bits;
  result.returns = plan.returns;
  result.fields = plan.fields;
  result.layers = plan.layers();
  return result;
}

}  // namespace

// Who looks at surfaces needs the transforms of what stands still, too.
bool keepsStill(const SimulatorOptions& options, uint32_t binning, const SensorPlan& plan) {
  return options.culling.still && binning != gpu::kBinningLists &&
         exactnessOf(options).bounds != Exactness::Bounds::paper && !plan.surfaces() && !plan.motion();
}

SensorState::SensorState(const Device& device, Layout& layout, const Geometry& geometry, const Sensor& sensor,
                         const SimulatorOptions& options, uint32_t binning, const SensorPlan& plan, uint64_t firstBeam,
                         std::span<const SensorState> others)
    : device_(device),
      layout_(layout),
      binning_(binning),
      plan_(plan),
      exact_(exactnessOf(options).inside == Exactness::Inside::exact),
      outputs_(outputsOf(plan, leavesWords())),
      tables_(makeBeamTables(sensor)) {
  for (const SensorState& other : others)
    if (other.tables_.azimuthOffsets == tables_.azimuthOffsets && other.plan_.sameStages(plan_))
      std::copy(std::begin(other.kernels_), std::end(other.kernels_), kernels_);
  if (!kernels_[0]) {
    const Options kernel = kernelOptions(options, tables_.azimuthOffsets, plan_);
    const bool float64 = kernel.inside == gpu::kInsideExact && options.float64 && device.capabilities().float64;
    for (const bool moving : {false, true}) {
      if (moving && !plan_.motion()) break;
      ownKernels_[moving] = std::make_unique<Kernels>(device, layout, kernel, binning, float64, moving, plan_);
      kernels_[moving] = ownKernels_[moving].get();
    }
  }
  if (!plan_.bare()) {
    tables_.frame.footprint = plan.footprintRadius;
    effects_ = std::make_unique<EffectsState>(device, plan, tables_.rows, firstBeam);
    if (!readsInPlace()) effects_->makeOutputs(outputs_, tables_.frame.beams);
  }
  shellEnds_ = gnosphere::shellEnds(options, binning, tables_.frame, geometry.instances().counters().triangles);
  reach_ = reachOf(options, tables_.frame);
  makeBuffers(geometry);
  inFlight_.push_back(makeFrame());
}

void SensorState::makeBuffers(const Geometry& geometry) {
  const auto make = [&](uint32_t binding, const char* name, uint64_t bytes, Memory memory = Memory::device) {
    buffers_[binding] = Buffer(device_, name, bytes, memory);
  };
  Uploader uploader(device_);
  buffers_[gpu::kBindRows] = uploader.upload<gpu::Row>("rows", tables_.rows);
  buffers_[gpu::kBindRowLookup] = uploader.upload<uint32_t>("rowLookup", tables_.rowLookup);
  buffers_[gpu::kBindColumns] = uploader.upload<float>("columns", tables_.columns);
  const uint64_t beams = tables_.frame.beams;
  const bool lists = binning_ == gpu::kBinningLists;
  make(gpu::kBindCounters, "counters", sizeof(gpu::Counters));
  make(gpu::kBindFarthest, "farthest", 4 * farthestEntries(tables_.frame));
  make(gpu::kBindWords, "words", lists || (leavesWords() && readsInPlace()) ? 0 : beams * sizeof(Word));
  make(gpu::kBindListEnds, "listEnds",
       lists                            ? beams * 4
       : binning_ == gpu::kBinningSlabs ? slabCount(tables_.frame) * 4
                                        : 0);
  make(gpu::kBindBlockSums, "blockSums", lists ? (beams / gpu::kPrefixBlock + 1) * 4 : 0);
  if (!readsInPlace())
    for (const Output& output : outputs_)
      if (output.binding < buffers_.size() && !leavesWords())
        make(output.binding, "results", beams * output.bytesPerBeam);
  // First guesses; growLists() makes room for what a scan turns out to need.
  growProjected(projectedGuess(beams, geometry.instances().counters().triangles));
  growTiles(std::min(tileGuess(binning_, capacities_.projected), mostTiles()));
  growCandidates(lists ? beams * 2 : 0);
}

void SensorState::growProjected(uint64_t count) {
  const auto make = [&](uint32_t binding, const char* name, uint64_t bytes) {
    buffers_[binding] = Buffer(device_, name, count * bytes, Memory::device);
  };
  make(gpu::kBindProjectedA, "projectedA", sizeof(gpu::vec4));
  make(gpu::kBindProjectedB, "projectedB", sizeof(gpu::vec4));
  make(gpu::kBindProjectedC, "projectedC", sizeof(gpu::vec4));
  if (effects_) effects_->growProjected(count);
  make(gpu::kBindProjectedColumns, "projectedColumns", sizeof(gpu::vec2));
  capacities_.projected = static_cast<uint32_t>(count);
  if (binning_ == gpu::kBinningSlabs) growTiles(capacities_.tiles);
}

void SensorState::growTiles(uint64_t count) {
  buffers_[gpu::kBindTiles] =
      Buffer(device_, "tiles", tileBytes(binning_, capacities_.projected, count), Memory::device);
  capacities_.tiles = static_cast<uint32_t>(count);
}

uint64_t SensorState::mostTiles() const {
  const uint64_t others = tileBytes(binning_, capacities_.projected, 0), all = device_.maxBufferBytes();
  return (all - std::min(all, others)) / tileBytes(binning_, 0, 1);
}

void SensorState::growCandidates(uint64_t count) {
  buffers_[gpu::kBindCandidates] = Buffer(device_, "candidates", count * 4, Memory::device);
  capacities_.candidates = static_cast<uint32_t>(count);
}

void SensorState::makeStillWords() {
  const uint64_t bytes = uint64_t{tables_.frame.beams} * sizeof(Word);
  if (!stillWords_.handle()) stillWords_ = Buffer(device_, "stillWords", bytes, Memory::device);
}

FrameInFlight SensorState::makeFrame() const {
  FrameInFlight result;
  result.frame = Buffer(device_, "frame", sizeof(gpu::Frame), Memory::upload);
  const uint64_t beams = tables_.frame.beams;
  for (const Output& output : outputs_)
    result.results.emplace_back(device_, "results", beams * output.bytesPerBeam, Memory::readback);
  result.results.emplace_back(device_, "counters", sizeof(gpu::Counters), Memory::readback);
  result.set = layout_.makeSet(0);
  return result;
}

const FrameInFlight& SensorState::prepare(size_t index, const Shot& shot, const ShotMotion* motion,
                                          uint32_t instanceCount, const PlacedInstances& placed,
                                          const VisibleLists& visible) {
  moving_ = motion != nullptr;
  while (inFlight_.size() <= index) inFlight_.push_back(makeFrame());
  FrameInFlight& frame = inFlight_[index];
  frame.capacities = capacities_;
  gpu::Frame content = tables_.frame;
  content.instanceCount = instanceCount;
  content.projectedCapacity = capacities_.projected;
  content.tileCapacity = capacities_.tiles;
  content.candidateCapacity = capacities_.candidates;
  std::memcpy(frame.frame.mapped(), &content, sizeof content);
  frame.frame.flush();
  EffectsState::Bindings buffers = {};
  buffers.fill(&buffers_[gpu::kBindCounters]);  // what nothing is planned for: no pipeline reads it
  for (size_t i = 0; i < buffers_.size(); ++i)
    if (buffers_[i].handle()) buffers[i] = &buffers_[i];
  buffers[gpu::kBindFrame] = &frame.frame;
  buffers[gpu::kBindInstances] = &placed.instances;
  buffers[gpu::kBindPlaced] = &placed.placed;
  buffers[gpu::kBindOwnerRanges] = &placed.ownerRanges;
  buffers[gpu::kBindVisibleGroups] = &visible.groups;
  buffers[gpu::kBindVisible] = &visible.clusters;
  if (effects_) {
    effects_->prepare(frame.effects, shot, motion);
    effects_->bind(frame.effects, buffers);
    if (plan_.surfaces()) buffers[gpu::kBindInstanceMeshes] = &placed.meshes;
  }
  if (readsInPlace())
    for (size_t i = 0; i < outputs_.size(); ++i) buffers[outputs_[i].binding] = &frame.results[i];
  words_ = buffers[gpu::kBindWords];
  layout_.updateSet(frame.set, std::span(buffers).first(layout_.bindingCount(0)));
  return frame;
}

bool SensorState::cutShort(const FrameInFlight& frame) const {
  const gpu::Counters& needed = frame.counters();
  return projectedCount(needed) > frame.capacities.projected || needed.tiles > frame.capacities.tiles ||
         (binning_ == gpu::kBinningLists && needed.candidates > frame.capacities.candidates);
}

void SensorState::growLists(const FrameInFlight& frame) {
  const gpu::Counters needed = frame.counters();
  const auto room = [&](uint64_t count, uint64_t entryBytes) {
    return grown(count, device_.maxBufferBytes() / entryBytes);
  };
  // A scan cut short has counted too few of what follows; the next run will tell.
  if (projectedCount(needed) > capacities_.projected) growProjected(room(projectedCount(needed), sizeof(gpu::vec4)));
  if (needed.tiles > capacities_.tiles) growTiles(grown(needed.tiles, mostTiles()));
  if (binning_ == gpu::kBinningLists && needed.candidates > capacities_.candidates)
    growCandidates(room(needed.candidates, 4));
}

const gpu::Counters& FrameInFlight::counters() const {
  results.back().invalidate();
  return *static_cast<const gpu::Counters*>(results.back().mapped());
}

DeviceResults SensorState::results(size_t index) const {
  const FrameInFlight& frame = inFlight_[index];
  return DeviceResults::from(tables_, exact_, frame.counters(), [&](uint32_t binding) -> const void* {
    for (size_t i = 0; i < outputs_.size(); ++i) {
      if (outputs_[i].binding != binding) continue;
      frame.results[i].invalidate();
      return frame.results[i].mapped();
    }
    return nullptr;
  });
}

void SensorState::addTo(MemoryUse& use) const {
  for (uint32_t i = 0; i < buffers_.size(); ++i) {
    const bool table = i >= gpu::kBindRows && i <= gpu::kBindColumns;
    (table ? use.sensor : use.work) += buffers_[i].bytes();
  }
  use.work += stillWords_.bytes();
  if (effects_) use.work += effects_->bytes();
  for (const FrameInFlight& frame : inFlight_) {
    use.work += frame.frame.bytes();
    if (!readsInPlace()) continue;
    for (const Buffer& results : frame.results) use.work += results.bytes();
  }
}

void SensorState::describe(Plan& plan) const {
  const auto add = [&](const Kernel& kernel) {
    plan.stages.back().pipelines.push_back({kernel.name(), {kernel.constants().begin(), kernel.constants().end()}});
  };
  const Kernels& k = *kernels_[plan_.motion()];
  plan.stages.push_back({"project", 0, {}});
  for (const Kernel* kernel : {&k.projectGroups, &k.projectClusters, &k.projectOccluders, &k.projectTriangles})
    add(*kernel);
  plan.stages.push_back({"bin", 0, {}});
  for (const std::vector<Kernel>* kernels : {&k.bin, &k.prefixSum})
    for (const Kernel& kernel : *kernels) add(kernel);
  if (k.resolve || leavesWords()) plan.stages.push_back({"resolve", 0, {}});
  if (k.resolve) add(*k.resolve);
  if (!k.footprint.empty() || k.surfaces || k.effects) plan.stages.push_back({"effects", 0, {}});
  for (const Kernel& kernel : k.footprint) add(kernel);
  for (const std::optional<Kernel>* kernel : {&k.surfaces, &k.effects})
    if (*kernel) add(**kernel);
  for (size_t i = 0; i < buffers_.size(); ++i)
    if (buffers_[i].bytes() > 0) plan.buffers.push_back({buffers_[i].name(), buffers_[i].bytes()});
  for (size_t i = 0; i < inFlight_[0].results.size(); ++i)
    plan.buffers.push_back({inFlight_[0].results[i].name(), inFlight_[0].results[i].bytes()});
  if (effects_) effects_->list(plan.buffers);
}

}  // namespace gnosphere::vulkan
