// SPDX-License-Identifier: Apache-2.0
// Finds which parts of the tables have beams: range windows, slabs, and entries of the farthest-range table.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "pipeline/beam_tables.hpp"

namespace gnosphere {

/// The range window of a masked beam.
constexpr gpu::vec2 kNoRange(1, -1);

/// Returns the range window of a beam.
gpu::vec2 rangesOf(const Sensor& sensor, uint64_t frame, uint32_t number);

/// Sets what kernels must know of range windows. `ranges` has the windows of all beams, by index; it is emptied if
/// every beam has the window of the sensor. No hit is nearer than the first word of a place without a beam. The masked
/// beams of a list come last and are in no cell; their empty windows tell the kernels of effects that they never fire.
void setRanges(const Sensor& sensor, std::span<BeamTables> all);

/// Finds the columns that hold all beams, divides the columns that have beams among the threads, and finds the slabs
/// that hold all beams. `taken` tells of each column whether it has beams.
void setSlabs(const std::vector<bool>& taken, gpu::Frame& frame);

/// Marks the entries of the farthest-range table that have beams; `placesOf(mark)` calls mark(row, column) for each
/// beam. The list is empty if all have.
template <typename PlacesOf>
std::vector<uint32_t> startFarthest(const gpu::Frame& frame, const PlacesOf& placesOf) {
  const auto entries = [](uint32_t count, uint32_t each) { return (count + each - 1) / each; };
  const uint32_t finePerRow = entries(frame.columns, gpu::kFineColumns),
                 coarsePerRow = entries(frame.columns, gpu::kCoarseColumns),
                 fine = finePerRow * entries(frame.rows, gpu::kFineRows);
  std::vector<uint32_t> table(fine + coarsePerRow * entries(frame.rows, gpu::kCoarseRows), 0);
  placesOf([&](uint32_t row, uint32_t column) {
    table[row / gpu::kFineRows * finePerRow + column / gpu::kFineColumns] = gpu::kNone;
    table[fine + row / gpu::kCoarseRows * coarsePerRow + column / gpu::kCoarseColumns] = gpu::kNone;
  });
  if (std::find(table.begin(), table.end(), 0u) == table.end()) table.clear();
  return table;
}

}  // namespace gnosphere
