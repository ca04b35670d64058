// SPDX-License-Identifier: Apache-2.0
#include "cuda/sensor_arrays.hpp"

#include "scan_options.hpp"

namespace gnosphere::cuda {
namespace {

// Of indices that kernels hold in 32 bits.
constexpr uint64_t kMostEntries = 0xffffffffu;

uint64_t entries(const gpu::Frame& frame, uint32_t columns, uint32_t rows) {
  return uint64_t{(frame.columns + columns - 1) / columns} * ((frame.rows + rows - 1) / rows);
}

uint64_t projectedCount(const gpu::Counters& counters) {
  return uint64_t{counters.projectedSmall} + counters.projectedLarge;
}

}  // namespace

SensorArrays::SensorArrays(const Sensor& sensor, const SimulatorOptions& options, uint32_t way, uint64_t triangles)
    : way_(way),
      tables_(makeBeamTables(sensor)),
      reach_(reachOf(options, tables_.frame)),
      shellBorder_(gnosphere::shellBorder(options, way, tables_.frame, triangles)),
      rows_("rows", tables_.rows),
      rowLookup_("rowLookup", tables_.rowLookup),
      columns_("columns", tables_.columns),
      frame_("frame", 1),
      counters_("counters", 1),
      farthest_("farthest", entries(tables_.frame, gpu::kFineColumns, gpu::kFineRows) +
                                entries(tables_.frame, gpu::kCoarseColumns, gpu::kCoarseRows)) {
  const uint64_t beams = tables_.frame.beams;
  if (way == gpu::kWayLists) {
    listEnds_ = Array<uint32_t>("listEnds", beams);
    blockSums_ = Array<uint32_t>("blockSums", beams / gpu::kScanBlock + 1);
    candidates_ = Array<uint32_t>("candidates", beams * 2);
  } else {
    words_ = Array<uint64_t>("words", beams);
  }
  points_ = Array<gpu::vec4>("points", beams);
  owners_ = Array<Pair>("owners", beams);
  growProjected(projectedGuess(beams, triangles));
  tiles_ = Array<std::array<uint32_t, 4>>("tiles", 1 << 12);
}

void SensorArrays::growProjected(uint64_t count) {
  projectedA_ = Array<gpu::vec4>("projectedA", count);
  projectedB_ = Array<gpu::vec4>("projectedB", count);
  projectedC_ = Array<gpu::vec4>("projectedC", count);
  projectedColumns_ = Array<gpu::vec2>("projectedColumns", count);
}

void SensorArrays::prepare(uint32_t instanceCount, Job& job) {
  gpu::Frame frame = tables_.frame;
  frame.instanceCount = instanceCount;
  frame.projectedCapacity = static_cast<uint32_t>(projectedA_.count());
  frame.tileCapacity = static_cast<uint32_t>(tiles_.count());
  frame.candidateCapacity = static_cast<uint32_t>(candidates_.count());
  frame_.write({&frame, 1});
  fill(counters_.data(), 0, counters_.bytes());
  fill(listEnds_.data(), 0, listEnds_.bytes());
  fill(words_.data(), 0xff, words_.bytes());
  const auto bind = [&](uint32_t binding, const auto& array) { job.arrays[0][binding] = array.data(); };
  bind(gpu::kBindFrame, frame_);
  bind(gpu::kBindCounters, counters_);
  bind(gpu::kBindRows, rows_);
  bind(gpu::kBindRowLookup, rowLookup_);
  bind(gpu::kBindColumns, columns_);
  bind(gpu::kBindFarthest, farthest_);
  bind(gpu::kBindProjectedA, projectedA_);
  bind(gpu::kBindProjectedB, projectedB_);
  bind(gpu::kBindProjectedC, projectedC_);
  bind(gpu::kBindProjectedColumns, projectedColumns_);
  bind(gpu::kBindTiles, tiles_);
  bind(gpu::kBindWords, words_);
  bind(gpu::kBindListEnds, listEnds_);
  bind(gpu::kBindBlockSums, blockSums_);
  bind(gpu::kBindCandidates, candidates_);
  bind(gpu::kBindPoints, points_);
  bind(gpu::kBindOwners, owners_);
}

// A scan cut short has counted too few of what follows; the next run will tell.
bool SensorArrays::grow(const gpu::Counters& needed) {
  bool enough = true;
  if (projectedCount(needed) > projectedA_.count()) {
    growProjected(grown(projectedCount(needed), kMostEntries));
    enough = false;
  }
  if (needed.tiles > tiles_.count()) {
    tiles_ = Array<std::array<uint32_t, 4>>("tiles", grown(needed.tiles, kMostEntries));
    enough = false;
  }
  if (way_ == gpu::kWayLists && needed.candidates > candidates_.count()) {
    candidates_ = Array<uint32_t>("candidates", grown(needed.candidates, kMostEntries));
    enough = false;
  }
  return !enough;
}

void SensorArrays::addTo(MemoryUse& use) const {
  use.sensor += rows_.bytes() + rowLookup_.bytes() + columns_.bytes();
  use.work += frame_.bytes() + counters_.bytes() + farthest_.bytes() + projectedA_.bytes() + projectedB_.bytes() +
              projectedC_.bytes() + projectedColumns_.bytes() + tiles_.bytes() + words_.bytes() + listEnds_.bytes() +
              blockSums_.bytes() + candidates_.bytes() + points_.bytes() + owners_.bytes();
}

}  // namespace gnosphere::cuda
