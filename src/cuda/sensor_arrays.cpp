// SPDX-License-Identifier: Apache-2.0
#include "cuda/sensor_arrays.hpp"

namespace gnosphere::cuda {
namespace {

// Of indices that kernels hold in 32 bits.
constexpr uint64_t kMostEntries = 0xffffffffu;
constexpr uint64_t kFirstCandidatesPerBeam = 2;

}  // namespace

SensorArrays::SensorArrays(const SensorPlan& plan, const SimulatorOptions& options, uint64_t triangles)
    : plan_(plan),
      binning_(chooseBinning(options, true, false, plan)),
      exact_(exactnessOf(options).inside == Exactness::Inside::exact),
      tables_(makeBeamTables(plan.sensor)) {
  gpu::Frame& frame = tables_.frame;
  frame.footprint = plan.footprintRadius;
  reach_ = reachOf(options, frame);
  shellEnds_ = gnosphere::shellEnds(options, binning_, frame, triangles);
  arrays_[gpu::kBindRows] = Array("rows", tables_.rows);
  arrays_[gpu::kBindRowLookup] = Array("rowLookup", tables_.rowLookup);
  arrays_[gpu::kBindColumns] = Array("columns", tables_.columns);
  make(gpu::kBindFrame, "frame", sizeof(gpu::Frame));
  make(gpu::kBindCounters, "counters", sizeof(gpu::Counters));
  make(gpu::kBindFarthest, "farthest", 4 * farthestEntries(frame));
  const uint64_t beams = frame.beams;
  if (binning_ == gpu::kBinningLists) {
    make(gpu::kBindListEnds, "listEnds", beams * 4);
    make(gpu::kBindBlockSums, "blockSums", (beams / gpu::kPrefixBlock + 1) * 4);
    growCandidates(beams * kFirstCandidatesPerBeam);
  } else {
    make(gpu::kBindWords, "words", beams * 8);
    if (binning_ == gpu::kBinningSlabs) make(gpu::kBindListEnds, "listEnds", slabCount(frame) * 4);
  }
  for (const Output& output : outputs())
    if (output.binding != gpu::kBindWords) make(output.binding, "results", beams * output.bytesPerBeam);
  make(lastingArrays(plan_, tables_.rows, 0));
  growProjected(projectedGuess(beams, triangles));
  growTiles(tileGuess(binning_, tables_.frame.projectedCapacity));
}

void SensorArrays::make(uint32_t binding, const char* name, uint64_t bytes) {
  arrays_[binding] = Array(name, bytes);
}

void SensorArrays::make(const std::vector<EffectsArray>& arrays) {
  for (const EffectsArray& array : arrays) {
    make(array.binding, array.name, array.bytes);
    arrays_[array.binding].write<std::byte>(array.content);
  }
}

void SensorArrays::growProjected(uint64_t count) {
  make(gpu::kBindProjectedA, "projectedA", count * sizeof(gpu::vec4));
  make(gpu::kBindProjectedB, "projectedB", count * sizeof(gpu::vec4));
  make(gpu::kBindProjectedC, "projectedC", count * sizeof(gpu::vec4));
  make(gpu::kBindProjectedColumns, "projectedColumns", count * sizeof(gpu::vec2));
  make(projectedArrays(plan_, count));
  tables_.frame.projectedCapacity = static_cast<uint32_t>(count);
  if (binning_ == gpu::kBinningSlabs) growTiles(tables_.frame.tileCapacity);
}

void SensorArrays::growTiles(uint64_t count) {
  make(gpu::kBindTiles, "tiles", tileBytes(binning_, tables_.frame.projectedCapacity, count));
  tables_.frame.tileCapacity = static_cast<uint32_t>(count);
}

void SensorArrays::growCandidates(uint64_t count) {
  make(gpu::kBindCandidates, "candidates", count * sizeof(uint32_t));
  tables_.frame.candidateCapacity = static_cast<uint32_t>(count);
}

void SensorArrays::prepare(const Shot& shot, const ShotMotion* motion, uint32_t instanceCount, Job& job) {
  gpu::Frame frame = tables_.frame;
  frame.instanceCount = instanceCount;
  arrays_[gpu::kBindFrame].write<gpu::Frame>({&frame, 1});
  const auto fillWith = [&](uint32_t binding, uint8_t value) {
    fill(arrays_[binding].data(), value, arrays_[binding].bytes());
  };
  fillWith(gpu::kBindCounters, 0);
  fillWith(gpu::kBindListEnds, binning_ == gpu::kBinningSlabs ? 0xff : 0);
  fillWith(gpu::kBindWords, 0xff);
  for (const EffectsArray& array : shotArrays(plan_, 0, shot, motion)) {
    if (arrays_[array.binding].bytes() < array.bytes) make(array.binding, array.name, array.bytes);
    arrays_[array.binding].write<std::byte>(array.content);
  }
  for (size_t i = 0; i < arrays_.size(); ++i)  // what nothing is planned for is bound to something: no kernel reads it
    job.arrays[0][i] = arrays_[i].data() ? arrays_[i].data() : arrays_[gpu::kBindCounters].data();
  addTo(job.options);
  job.subRays = static_cast<uint32_t>(plan_.subRays.size());
  job.moving = motion != nullptr;
}

// A scan cut short has counted too few of what follows; the next run will tell.
bool SensorArrays::grow(const gpu::Counters& needed) {
  const gpu::Frame before = tables_.frame;
  if (projectedCount(needed) > before.projectedCapacity) growProjected(grown(projectedCount(needed), kMostEntries));
  if (needed.tiles > before.tileCapacity) growTiles(grown(needed.tiles, kMostEntries));
  if (binning_ == gpu::kBinningLists && needed.candidates > before.candidateCapacity)
    growCandidates(grown(needed.candidates, kMostEntries));
  const gpu::Frame& after = tables_.frame;
  return after.projectedCapacity != before.projectedCapacity || after.tileCapacity != before.tileCapacity ||
         after.candidateCapacity != before.candidateCapacity;
}

DeviceResults SensorArrays::results() {
  const std::vector<Output> outputs = this->outputs();
  results_.resize(outputs.size());
  return DeviceResults::from(tables_, exact_, counters(), [&](uint32_t binding) -> const void* {
    for (size_t i = 0; i < outputs.size(); ++i) {
      if (outputs[i].binding != binding) continue;
      results_[i].resize(arrays_[binding].bytes());
      copyToHost(results_[i].data(), arrays_[binding].data(), results_[i].size());
      return results_[i].data();
    }
    return nullptr;
  });
}

void SensorArrays::addTo(Options& options) const {
  options.AZIMUTH_OFFSETS = tables_.azimuthOffsets;
  options.EFFECTS = plan_.bits;
  options.FIELDS = plan_.fields;
  options.LAYERS = plan_.layers();
  options.RETURNS = plan_.returns;
}

void SensorArrays::addTo(MemoryUse& use) const {
  for (uint32_t i = 0; i < arrays_.size(); ++i) {
    const bool table = i >= gpu::kBindRows && i <= gpu::kBindColumns;
    (table ? use.sensor : use.work) += arrays_[i].bytes();
  }
}

void SensorArrays::list(std::vector<Plan::Buffer>& to) const {
  for (const Array& array : arrays_)
    if (array.bytes() > 0) to.push_back({array.name(), array.bytes()});
}

}  // namespace gnosphere::cuda
