// SPDX-License-Identifier: Apache-2.0
#include "pipeline/beam_places.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "base/limits.hpp"
#include "base/units.hpp"
#include "pipeline/beam_coverage.hpp"
#include "sensor/beams.hpp"

namespace gnosphere {
namespace {

// Beams whose angles differ by less, in radians, have one direction. Float directions are 300 times as coarse.
constexpr double kSameDirection = 2e-10;

// Computes everything that follows from the numbers of the beams in places.
void finishPlaces(const Sensor& sensor, uint64_t frame, BeamTables& tables) {
  const uint32_t columns = tables.frame.columns, places = static_cast<uint32_t>(tables.numbers.size());
  setRowLookup(tables);
  tables.mapped = true;
  tables.frame.beams = places;
  std::vector<uint32_t> taken;
  for (uint32_t index = 0; index < places; ++index)
    if (tables.numbers[index] != gpu::kNone) taken.push_back(index);
  tables.holes = taken.size() < places;
  if (tables.holes)
    tables.startFarthest = startFarthest(tables.frame, [&](const auto& mark) {
      for (const uint32_t index : taken) mark(index / columns, index % columns);
    });
  std::vector<bool> takenColumns(columns);
  for (const uint32_t index : taken) takenColumns[index % columns] = true;
  setSlabs(takenColumns, tables.frame);
  const std::vector<bool> silent = silentBeams(sensor);
  for (const uint32_t number : tables.numbers) {
    const bool fires = number != gpu::kNone && !silent[number];
    tables.ranges.push_back(fires ? rangesOf(sensor, frame, number) : kNoRange);
  }
}

// Returns where the azimuths of a row begin in `columns`. Rows that look in the same directions share them.
uint32_t azimuthsOf(const Sensor& sensor, const RowGrid& grid, const RowGrid::Row& row, BeamTables& tables,
                    std::map<double, uint32_t>& known) {
  const auto begin = static_cast<uint32_t>(tables.columns.size() / 2);
  const auto [entry, isNew] = known.try_emplace(sensor.channels[row.channel].azimuthOffsetDeg, begin);
  if (!isNew) return entry->second;
  // Values in places without a beam are never looked at.
  std::vector<float> own(tables.columns.begin(), tables.columns.begin() + 2 * ptrdiff_t{grid.columns});
  for (uint32_t beam = 0; beam < grid.taken; ++beam) {
    const size_t place = 2 * size_t{(beam + static_cast<uint32_t>(row.first + int64_t{grid.columns})) % grid.columns};
    const double azimuth = azimuthOf(sensor, size_t{row.channel} * sensor.columns + grid.columnAt(beam));
    own[place] = onLattice(std::cos(azimuth));
    own[place + 1] = onLattice(std::sin(azimuth));
  }
  tables.columns.insert(tables.columns.end(), own.begin(), own.end());
  return begin;
}

}  // namespace

BeamTables makeRowTables(const Sensor& sensor, const RowGrid& grid, const OriginGroup& group) {
  BeamTables tables;
  tables.between = grid.between();
  tables.staggered = grid.staggered();
  for (const RowGrid::Row& row : grid.rows) {
    gpu::Row& made = tables.rows.emplace_back(rowAt(sensor.channels[row.channel].elevationDeg * kDegree, row.channel));
    made.first = row.first;
    made.lag = static_cast<float>(row.lag + grid.before());
    made.behind = static_cast<float>(row.behind);
  }
  setFrame(sensor, grid.columns, grid.phase, tables);
  setPaper(sensor, tables);
  gpu::Frame& frame = tables.frame;
  frame.beside = static_cast<float>(grid.beside);
  frame.stretch = static_cast<float>(grid.stretch / std::max(1u, grid.taken - 1));
  frame.momentsBefore = grid.before();
  frame.momentsAfter = grid.after();
  // Rounding of these, and of a box's columns when they are subtracted.
  if (tables.between) frame.columnSlack += 2.5e-7f * static_cast<float>(grid.columns);
  std::map<double, uint32_t> known;
  tables.numbers.assign(size_t{grid.columns} * grid.rows.size(), gpu::kNone);
  for (size_t r = 0; r < grid.rows.size(); ++r) {
    const RowGrid::Row& row = grid.rows[r];
    if (tables.between) tables.rows[r].azimuths = azimuthsOf(sensor, grid, row, tables, known);
    for (uint32_t beam = 0; beam < grid.taken; ++beam) {
      const size_t place = (beam + static_cast<uint32_t>(row.first + int64_t{grid.columns})) % grid.columns;
      tables.numbers[r * grid.columns + place] = row.channel * sensor.columns + grid.columnAt(beam);
    }
    const auto first = static_cast<float>(row.first), later = static_cast<float>(row.first - row.lag);
    frame.shiftMin = std::min({frame.shiftMin, first, later});
    frame.shiftMax = std::max({frame.shiftMax, first, later});
  }
  finishPlaces(sensor, 0, tables);
  tables.masked = static_cast<uint32_t>(group.silent.size());
  setRanges(sensor, {&tables, 1});
  return tables;
}

bool placeOnGrid(const Sensor& sensor, uint64_t frame, const std::vector<ListedBeam>& beams,
                 const std::vector<size_t>& ends, uint32_t columns, BeamTables& tables) {
  const uint64_t places = uint64_t{columns} * ends.size();
  if (ends.size() > limits::kChannels.most || places > limits::kBeams.most ||
      places > std::max(kLeastCells, kCellsPerBeam * beams.size()))
    return false;
  constexpr double kTurn = 2 * std::numbers::pi;
  const double step = kTurn / columns;
  const double first = (beams[0].azimuth / kTurn + 0.5) * columns;
  double phase = first - std::floor(first);
  if (phase * step < kSameDirection || (1 - phase) * step < kSameDirection) phase = 0;
  tables.numbers.assign(places, gpu::kNone);
  size_t i = 0;
  for (size_t row = 0; row < ends.size(); ++row) {
    const double elevation = beams[i].elevation;
    tables.rows.push_back(rowAt(elevation, static_cast<uint32_t>(row)));
    for (; i < ends[row]; ++i) {
      const double place = (beams[i].azimuth / kTurn + 0.5) * columns - phase, column = std::round(place);
      if (std::abs(place - column) * step > kSameDirection || beams[i].elevation - elevation > kSameDirection)
        return false;
      const auto wrapped = static_cast<uint32_t>(static_cast<int64_t>(column + columns) % columns);
      uint32_t& number = tables.numbers[row * columns + wrapped];
      if (number != gpu::kNone) return false;
      number = beams[i].number;
    }
  }
  setFrame(sensor, columns, phase, tables);
  finishPlaces(sensor, frame, tables);
  return true;
}

}  // namespace gnosphere
