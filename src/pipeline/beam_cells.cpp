// SPDX-License-Identifier: Apache-2.0
#include "pipeline/beam_cells.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>
#include <tuple>

#include "base/threads.hpp"
#include "pipeline/beam_coverage.hpp"
#include "pipeline/beam_order.hpp"
#include "pipeline/beam_places.hpp"
#include "sensor/beams.hpp"

namespace gnosphere {
namespace {

constexpr size_t kLookupCellsPerRow = 2047;
// Fewer beams leave most of the sphere empty. Narrow columns show where; but what is near to scattered lasers may be
// anywhere, and tries all cells.
constexpr size_t kFewestForOwnColumns = 64;
constexpr uint32_t kColumnsOfFew = 64, kColumnsOfScattered = 16;
// A beam belongs to a column although it lies before it by this share of a column.
constexpr double kColumnTolerance = 1e-4;

/// Cells per turn, and the azimuth of column 0 beyond -180 degrees, in columns.
struct CellColumns {
  uint32_t count = 0;
  double phase = 0;

  /// Returns how many columns a beam lies behind column 0; it may be less than 0.
  double placeOf(const ListedBeam& beam) const { return (beam.azimuth / (2 * std::numbers::pi) + 0.5) * count - phase; }
  double columnOf(const ListedBeam& beam) const { return std::floor(placeOf(beam) + kColumnTolerance); }
};

void sortIntoCells(std::vector<ListedBeam>& beams, const std::vector<size_t>& ends, const CellColumns& columns) {
  inRuns(ends.size(), 1, threadCount(), [&](uint64_t firstRow, uint64_t endRow) {
    for (uint64_t row = firstRow; row < endRow; ++row) {
      const auto begin = beams.begin() + static_cast<std::ptrdiff_t>(row == 0 ? 0 : ends[row - 1]);
      const auto end = beams.begin() + static_cast<std::ptrdiff_t>(ends[row]);
      for (auto beam = begin; beam != end; ++beam) {
        beam->row = static_cast<uint32_t>(row);
        beam->column = static_cast<uint32_t>(columns.columnOf(*beam) + columns.count) % columns.count;
      }
      std::sort(begin, end, [](const ListedBeam& a, const ListedBeam& b) {
        return std::tie(a.column, a.azimuth, a.number) < std::tie(b.column, b.azimuth, b.number);
      });
    }
  });
}

// Sorts the first `firing` beams by blocks of cells, and within a block by the slices of the scan's time in which they
// fire; notes for each block in which slices its beams fire.
void sortBySlices(const std::vector<ListedBeam>& beams, size_t firing, BeamTables& tables) {
  static_assert(kListIntervals == gpu::kTimeSlices * gpu::kSliceIntervals);
  static_assert(gpu::kSliceIntervals % 2 == 0, "the middle of a run of slices is an entry of the table of poses");
  const auto blocksOf = [&](uint32_t rows, uint32_t columns) {
    return ((tables.frame.columns - 1) / columns + 1) * ((tables.rows.size() + rows - 1) / rows);
  };
  const auto blockOf = [&](size_t i, uint32_t rows, uint32_t columns) {
    return beams[i].row / rows * size_t{(tables.frame.columns - 1) / columns + 1} + beams[i].column / columns;
  };
  const auto sliceOf = [&](size_t i) {
    return std::min(static_cast<uint32_t>(tables.origins[i].w) / gpu::kSliceIntervals, gpu::kTimeSlices - 1);
  };
  const auto timedOf = [&](size_t i) {
    return blockOf(i, gpu::kTimedRows, gpu::kTimedColumns) * gpu::kTimeSlices + sliceOf(i);
  };
  tables.sliceMasks.assign(blocksOf(gpu::kSliceRows, gpu::kSliceColumns), 0);
  tables.timedStarts.assign(blocksOf(gpu::kTimedRows, gpu::kTimedColumns) * gpu::kTimeSlices + 1, 0);
  tables.timedBeams.resize(firing);
  for (size_t i = 0; i < firing; ++i) {
    tables.sliceMasks[blockOf(i, gpu::kSliceRows, gpu::kSliceColumns)] |= 1u << sliceOf(i);
    ++tables.timedStarts[timedOf(i) + 1];
  }
  std::partial_sum(tables.timedStarts.begin(), tables.timedStarts.end(), tables.timedStarts.begin());
  std::vector<uint32_t> next = tables.timedStarts;
  for (size_t i = 0; i < firing; ++i)
    tables.timedBeams[next[timedOf(i)]++] = {
        static_cast<uint32_t>(i), beams[i].row % gpu::kTimedRows | beams[i].column % gpu::kTimedColumns << 16};
}

// Sorts the beams into cells of `rows` rows, of which the last ones may be empty.
BeamTables listInCells(const Sensor& sensor, uint64_t frame, std::vector<ListedBeam> beams,
                       const std::vector<size_t>& ends, size_t rows, const CellColumns& cells,
                       const OriginGroup& group) {
  BeamTables tables;
  const uint32_t columns = cells.count;
  std::vector<RowKeys> keys;
  for (size_t row = 0; row < ends.size(); ++row) {
    const size_t begin = row == 0 ? 0 : ends[row - 1];
    keys.push_back({elevationKey(beams[begin].elevation), elevationKey(beams[ends[row] - 1].elevation)});
  }
  tables.listed = true;
  tables.rows.resize(rows);
  const size_t lookupCells = std::min<size_t>(std::bit_ceil(rows * kLookupCellsPerRow + 1), gpu::kRowLookupCells);
  tables.frame.lookupCells = static_cast<uint32_t>(lookupCells);
  tables.rowLookup = makeRowLookup(keys, tables.frame.lookupCells);
  sortIntoCells(beams, ends, cells);
  setFrame(sensor, columns, cells.phase, tables);
  tables.frame.beams = static_cast<uint32_t>(beams.size() + group.silent.size());

  const size_t firing = beams.size();
  std::vector<bool> takenColumns(columns);
  for (const ListedBeam& beam : beams) takenColumns[beam.column] = true;
  setSlabs(takenColumns, tables.frame);
  tables.cellStarts.reserve(rows * columns + 1);
  for (size_t cell = 0, beam = 0; cell < rows * columns; ++cell) {
    tables.cellStarts.push_back(static_cast<uint32_t>(beam));
    while (beam < firing && size_t{beams[beam].row} * columns + beams[beam].column == cell) ++beam;
  }
  tables.cellStarts.push_back(static_cast<uint32_t>(firing));
  for (const uint32_t number : group.silent) beams.push_back({azimuthOf(sensor, number, frame), 0, number, 0, 0});

  tables.startFarthest = startFarthest(tables.frame, [&](const auto& mark) {
    for (size_t i = 0; i < firing; ++i) mark(beams[i].row, beams[i].column);
  });

  const ScanTimes times = scanTimesOf(sensor, true, frame);
  for (size_t i = 0; i < beams.size(); ++i) {
    const auto& [azimuth, elevation, number, row, column] = beams[i];
    const double c = std::cos(azimuth), s = std::sin(azimuth);
    tables.numbers.push_back(number);
    tables.angles.push_back(
        {onLattice(c), onLattice(s), onLattice(std::cos(elevation)), onLattice(std::sin(elevation))});
    tables.ranges.push_back(i < firing ? rangesOf(sensor, frame, number) : kNoRange);
    // As those of channels, origins are stated forward along the beam's azimuth, left and up.
    const Vec3 &at = originOf(sensor, number, frame), &centre = group.lasers.centre;
    const Vec3 from = {at.x - centre.x, at.y - centre.y, at.z - centre.z};
    const double place = times.step > 0 ? (timeOf(sensor, number, frame) - times.first) / times.step : 0;
    tables.origins.push_back({static_cast<float>(c * from.x + s * from.y), static_cast<float>(c * from.y - s * from.x),
                              static_cast<float>(from.z), static_cast<float>(place)});
  }
  sortBySlices(beams, firing, tables);
  // The amount that a beam may lie before the column of its cell is slack.
  double beside = 0;
  for (size_t i = 0; i < firing; ++i) beside = std::max(beside, cells.placeOf(beams[i]) - cells.columnOf(beams[i]));
  tables.frame.beside = static_cast<float>(std::min(beside + kColumnTolerance, 1.0));
  tables.frame.columnSlack += static_cast<float>(kColumnTolerance);
  tables.masked = static_cast<uint32_t>(group.silent.size());
  return tables;
}

// Gives all tables the same sizes.
void makeAlike(std::span<BeamTables> all) {
  uint32_t beams = 0;
  float beside = 0;
  size_t farthest = 0;
  for (const BeamTables& tables : all) {
    beams = std::max(beams, tables.frame.beams);
    beside = std::max(beside, tables.frame.beside);
    farthest = std::max(farthest, tables.startFarthest.size());
  }
  for (uint32_t i = 0; i < all.size(); ++i) {
    all[i].frame.beams = beams;
    all[i].frame.beside = beside;
    all[i].frame.table = i;
    if (all[i].startFarthest.empty()) all[i].startFarthest.resize(farthest, gpu::kNone);
  }
}

struct Sorted {
  std::vector<ListedBeam> beams;
  std::vector<size_t> ends;
};

// Returns the phase with which beams lie the least behind their columns. The beams of a vertical fan, such as those of
// a scanner in an aircraft, then lie on a column, and what is beside the fan is not near a beam.
double bestPhase(const std::vector<Sorted>& lists, uint32_t columns) {
  constexpr size_t kParts = 1024;  // of a column
  constexpr size_t kWorthIt = kParts / 8;
  std::array<bool, kParts> taken = {};
  for (const Sorted& list : lists)
    for (const ListedBeam& beam : list.beams) {
      const double place = CellColumns{columns}.placeOf(beam);
      taken[std::min(static_cast<size_t>((place - std::floor(place)) * kParts), kParts - 1)] = true;
    }
  size_t run = 0, longest = 0, end = 0;  // of parts without a beam, which may go around
  for (size_t part = 0; part < 2 * kParts; ++part) {
    run = taken[part % kParts] ? 0 : run + 1;
    if (run <= longest) continue;
    longest = run;
    end = part + 1;
  }
  return longest < kWorthIt || longest > kParts ? 0 : static_cast<double>(end % kParts) / kParts;
}

}  // namespace

std::vector<BeamTables> makeListedTables(const Sensor& sensor, std::span<const FiredGroup> groups, bool mayMap) {
  const auto sortedOf = [&](uint64_t frame, const std::vector<uint32_t>& numbers) {
    std::vector<ListedBeam> beams = sortedBeams(sensor, frame, numbers);
    std::vector<size_t> ends = rowEnds(beams);
    return Sorted{std::move(beams), std::move(ends)};
  };
  std::vector<BeamTables> all(1);
  std::vector<Sorted> sorted;
  if (mayMap && groups.size() == 1) {
    const auto& [frame, group] = groups[0];
    std::vector<uint32_t> numbers = group->beams;
    // Masked beams have places, too, for their numbers.
    numbers.insert(numbers.end(), group->silent.begin(), group->silent.end());
    Sorted one = sortedOf(frame, numbers);
    const auto& [beams, ends] = one;
    if (!beams.empty() && placeOnGrid(sensor, frame, beams, ends, columnCount(beams, ends), all[0])) {
      all[0].masked = static_cast<uint32_t>(group->silent.size());
      setRanges(sensor, all);
      return all;
    }
    if (group->silent.empty()) sorted.push_back(std::move(one));
  }
  size_t rows = 0, most = 0;
  uint32_t columns = 0;
  for (size_t i = 0; i < groups.size(); ++i) {
    const auto& [frame, group] = groups[i];
    if (sorted.size() == i) sorted.push_back(sortedOf(frame, group->beams));
    const auto& [beams, ends] = sorted[i];
    uint32_t own = group->lasers.distance > 0 ? kColumnsOfScattered : kColumnsOfFew;
    if (beams.size() >= kFewestForOwnColumns) own = columnCount(beams, ends);
    columns = std::max(columns, own);
    rows = std::max(rows, ends.size());
    most = std::max(most, beams.size());
  }
  columns = std::min(columns, mostColumns(most, rows));
  const CellColumns cells = {columns, bestPhase(sorted, columns)};
  all.clear();
  for (size_t i = 0; i < groups.size(); ++i)
    all.push_back(listInCells(sensor, groups[i].frame, std::move(sorted[i].beams), sorted[i].ends, rows, cells,
                              *groups[i].group));
  makeAlike(all);
  setRanges(sensor, all);
  return all;
}

}  // namespace gnosphere
