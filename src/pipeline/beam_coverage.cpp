// SPDX-License-Identifier: Apache-2.0
#include "pipeline/beam_coverage.hpp"

#include "pipeline/tuning.hpp"
#include "sensor/beams.hpp"

namespace gnosphere {
namespace {

struct Run {
  uint32_t first = 0, count = 0;
};

// Returns the shortest run that holds all places in use; after the last place comes the first.
Run shortestRun(const std::vector<bool>& used) {
  if (std::find(used.begin(), used.end(), true) == used.end()) return {};
  const auto places = static_cast<uint32_t>(used.size());
  Run run = {0, places};
  uint32_t gap = 0;  // unused places before place i, which may lie beyond the turn
  for (uint32_t i = 0; i < 2 * places; ++i) {
    if (used[i % places] && gap > places - run.count) run = {i % places, places - gap};
    gap = used[i % places] ? 0 : gap + 1;
  }
  return run;
}

}  // namespace

gpu::vec2 rangesOf(const Sensor& sensor, uint64_t frame, uint32_t number) {
  const RangeWindow window = rangeWindowOf(sensor, number, frame);
  return {static_cast<float>(window.least), static_cast<float>(window.most)};
}

void setRanges(const Sensor& sensor, std::span<BeamTables> all) {
  const gpu::vec2 common(all[0].frame.rangeMin, all[0].frame.rangeMax);
  gpu::vec2 widest = common;  // culling by range must keep what any beam can hit
  bool own = false;
  for (const BeamTables& tables : all) {
    const size_t tried = tables.ranges.size() - (tables.listed ? tables.masked : 0);
    for (size_t i = 0; i < tried; ++i) {
      const gpu::vec2& range = tables.ranges[i];
      if (tables.numbers[i] == gpu::kNone || (range.x == common.x && range.y == common.y)) continue;
      own = true;
      widest = {std::min(widest.x, range.x), std::max(widest.y, range.y)};
    }
    if (tables.listed && tables.masked > 0) own = true;
  }
  for (BeamTables& tables : all) {
    tables.frame.hidesNear = sensor.nearHits == NearHits::hide;
    tables.frame.hasBeamRanges = own;
    tables.frame.rangeMin = widest.x;
    tables.frame.rangeMax = widest.y;
    if (!own) tables.ranges.clear();
  }
}

void setSlabs(const std::vector<bool>& taken, gpu::Frame& frame) {
  const Run columns = shortestRun(taken);
  frame.beamColumnFirst = columns.first;
  frame.beamColumnCount = columns.count;
  frame.slabShift = slabShift(static_cast<uint32_t>(std::count(taken.begin(), taken.end(), true)));
  std::vector<bool> used(slabsOf(frame));
  for (uint32_t column = 0; column < frame.columns; ++column)
    if (taken[column]) used[column >> frame.slabShift] = true;
  const Run slabs = shortestRun(used);
  frame.slabFirst = slabs.first;
  frame.slabCount = slabs.count;
}

}  // namespace gnosphere
