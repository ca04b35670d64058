// SPDX-License-Identifier: Apache-2.0
#include "pipeline/beam_cells.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <tuple>

#include "base/limits.hpp"
#include "base/threads.hpp"
#include "base/units.hpp"
#include "pipeline/tuning.hpp"
#include "sensor/beams.hpp"

namespace gnosphere {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr uint32_t kLeastColumns = 16, kMostCellColumns = 1 << 22;
constexpr uint64_t kCellsPerBeam = 4, kLeastCells = 1 << 16;
constexpr size_t kLookupCellsPerRow = 2047;
// Fewer beams leave most of the sphere empty. Narrow columns show where; but what is near to scattered lasers may be
// anywhere, and tries all cells.
constexpr size_t kFewestForOwnColumns = 64;
constexpr uint32_t kColumnsOfFew = 64, kColumnsOfScattered = 16;
// Elevations closer than this, in radians, are one, unless many of them follow each other.
constexpr double kSameElevation = 1e-6;
// So many beams per elevation make it worth a row of its own.
constexpr uint64_t kBeamsPerElevation = 16;
// Beams whose angles differ by less, in radians, have one direction. Float directions are 300 times as coarse.
constexpr double kSameDirection = 2e-10;
// A beam belongs to a column although it lies before it by this share of a column.
constexpr double kColumnTolerance = 1e-4;

struct Listed {
  double azimuth, elevation;  // radians
  uint32_t number, row, column;
};

// Returns the rows as numbers of beams, of beams sorted by elevation.
std::vector<size_t> rowEnds(const std::vector<Listed>& beams) {
  std::vector<size_t> ends;
  if (beams.empty()) return ends;
  double lowest = beams[0].elevation;
  for (size_t i = 1; i <= beams.size() && ends.size() <= limits::kChannels.most; ++i) {
    const bool same = i < beams.size() && beams[i].elevation - beams[i - 1].elevation <= kSameElevation &&
                      beams[i].elevation - lowest <= 4 * kSameElevation;
    if (same) continue;
    ends.push_back(i);
    if (i < beams.size()) lowest = beams[i].elevation;
  }
  if (ends.size() <= limits::kChannels.most && ends.size() * kBeamsPerElevation <= beams.size()) return ends;
  // A band of the sphere that is as high as a cell is wide, if the beams are spread evenly.
  const auto [least, most] = std::minmax_element(
      beams.begin(), beams.end(), [](const Listed& a, const Listed& b) { return a.azimuth < b.azimuth; });
  const double across = std::max(most->azimuth - least->azimuth, 1e-6);
  const double up = std::max(beams.back().elevation - beams.front().elevation, 1e-6);
  const double count = static_cast<double>(beams.size());
  const auto rows = static_cast<size_t>(
      std::clamp(std::round(std::sqrt(count * up / across)), 1.0, std::min(count, double(limits::kChannels.most))));
  ends.clear();
  for (size_t row = 1; row <= rows; ++row) {
    size_t end = beams.size() * row / rows;
    // Beams of one elevation are in one row, so that no two rows overlap.
    while (end < beams.size() && beams[end].elevation == beams[end - 1].elevation) ++end;
    if (end > 0 && (ends.empty() || end > ends.back())) ends.push_back(end);
  }
  return ends;
}

// Cells take memory, so there are no more than a few per beam.
uint32_t mostColumns(uint64_t beams, uint64_t rows) {
  const uint64_t cells = std::max(kLeastCells, kCellsPerBeam * beams);
  return static_cast<uint32_t>(
      std::clamp<uint64_t>(cells / std::max<uint64_t>(rows, 1), kLeastColumns, kMostCellColumns));
}

// Returns the number of columns in a turn: about one beam per cell in the row with most beams. The median of the gaps
// finds the columns of a grid exactly, also of one that covers only a sector.
uint32_t columnCount(const std::vector<Listed>& beams, const std::vector<size_t>& ends) {
  size_t first = 0, fullest = 0;
  for (size_t row = 0; row < ends.size(); ++row) {
    const size_t begin = row == 0 ? 0 : ends[row - 1];
    if (ends[row] - begin > fullest) {
      fullest = ends[row] - begin;
      first = begin;
    }
  }
  std::vector<double> azimuths;
  for (size_t i = first; i < first + fullest; ++i) azimuths.push_back(beams[i].azimuth);
  std::sort(azimuths.begin(), azimuths.end());
  std::vector<double> gaps;
  for (size_t i = 1; i < azimuths.size(); ++i)
    if (azimuths[i] > azimuths[i - 1]) gaps.push_back(azimuths[i] - azimuths[i - 1]);
  if (beams.empty()) return kLeastColumns;
  const uint32_t most = mostColumns(beams.size(), ends.size());
  if (gaps.empty()) return std::min(most, 1024u);
  std::nth_element(gaps.begin(), gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2), gaps.end());
  const double columns = std::round(kTurn / gaps[gaps.size() / 2]);
  return static_cast<uint32_t>(std::clamp<double>(columns, kLeastColumns, most));
}

// The beams in order of elevation.
std::vector<Listed> sortedBeams(const Sensor& sensor, uint64_t frame, const std::vector<uint32_t>& numbers) {
  std::vector<Listed> beams;
  beams.reserve(numbers.size());
  for (const uint32_t beam : numbers)
    beams.push_back({azimuthOf(sensor, beam, frame), elevationOf(sensor, beam, frame), beam, 0, 0});
  const auto before = [](const Listed& a, const Listed& b) {
    return a.elevation < b.elevation || (a.elevation == b.elevation && a.number < b.number);
  };
  std::sort(beams.begin(), beams.end(), before);
  return beams;
}

void sortIntoCells(std::vector<Listed>& beams, const std::vector<size_t>& ends, uint32_t columns) {
  inRuns(ends.size(), 1, threadCount(), [&](uint64_t firstRow, uint64_t endRow) {
    for (uint64_t row = firstRow; row < endRow; ++row) {
      const auto begin = beams.begin() + static_cast<std::ptrdiff_t>(row == 0 ? 0 : ends[row - 1]);
      const auto end = beams.begin() + static_cast<std::ptrdiff_t>(ends[row]);
      for (auto beam = begin; beam != end; ++beam) {
        const double place = (beam->azimuth / kTurn + 0.5) * columns;
        beam->row = static_cast<uint32_t>(row);
        beam->column = static_cast<uint32_t>(std::floor(place + kColumnTolerance)) % columns;
      }
      std::sort(begin, end, [](const Listed& a, const Listed& b) {
        return std::tie(a.column, a.azimuth, a.number) < std::tie(b.column, b.azimuth, b.number);
      });
    }
  });
}

gpu::vec2 rangesOf(const Sensor& sensor, uint64_t frame, uint32_t number) {
  const RangeWindow window = rangeWindowOf(sensor, number, frame);
  return {static_cast<float>(window.least), static_cast<float>(window.most)};
}

// Sets what kernels must know of range windows. `ranges` has the windows of all beams, by index; it is emptied if every
// beam has the window of the sensor. No hit is nearer than the first word of a place without a beam. The masked beams
// of a list come last and are in no cell; their empty windows tell the kernels of effects that they never fire.
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
    tables.frame.ownRanges = own;
    tables.frame.rangeMin = widest.x;
    tables.frame.rangeMax = widest.y;
    if (!own) tables.ranges.clear();
  }
}

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

// Finds the columns that hold all beams, divides the columns that have beams among the threads, and finds the slabs
// that hold all beams. `columnOf(i)` is the column of beam i.
template <typename ColumnOf>
void setSlabs(size_t count, const ColumnOf& columnOf, gpu::Frame& frame) {
  std::vector<bool> taken(frame.columns);
  for (size_t i = 0; i < count; ++i) taken[columnOf(i)] = true;
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

// Marks the entries of the farthest-range table that have beams; `placesOf(mark)` calls mark(row, column) for each
// beam. The list is empty if all have.
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

// The range window of a masked beam.
const gpu::vec2 kNoRange(1, -1);

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
  setSlabs(
      taken.size(), [&](size_t i) { return taken[i] % columns; }, tables.frame);
  const std::vector<bool> silent = silentBeams(sensor);
  for (const uint32_t number : tables.numbers) {
    const bool fires = number != gpu::kNone && !silent[number];
    tables.ranges.push_back(fires ? rangesOf(sensor, frame, number) : kNoRange);
  }
}

// Places the beams in a grid. Returns false if one of them does not lie in a place, or two lie in the same.
bool placeOnGrid(const Sensor& sensor, uint64_t frame, const std::vector<Listed>& beams,
                 const std::vector<size_t>& ends, uint32_t columns, BeamTables& tables) {
  const uint64_t places = uint64_t{columns} * ends.size();
  if (ends.size() > limits::kChannels.most || places > limits::kBeams.most ||
      places > std::max(kLeastCells, kCellsPerBeam * beams.size()))
    return false;
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

// Sorts the first `firing` beams by blocks of cells, and within a block by the slices of the scan's time in which they
// fire; notes for each block in which slices its beams fire.
void sortBySlices(const std::vector<Listed>& beams, size_t firing, BeamTables& tables) {
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
BeamTables listInCells(const Sensor& sensor, uint64_t frame, std::vector<Listed> beams, const std::vector<size_t>& ends,
                       size_t rows, uint32_t columns, const OriginGroup& group) {
  BeamTables tables;
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
  sortIntoCells(beams, ends, columns);
  setFrame(sensor, columns, 0, tables);
  tables.frame.beams = static_cast<uint32_t>(beams.size() + group.silent.size());

  const size_t firing = beams.size();
  setSlabs(
      firing, [&](size_t i) { return beams[i].column; }, tables.frame);
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
  // A beam lies up to one column behind the column of its cell. The amount that it may lie before it is slack.
  tables.frame.beside = 1;
  tables.frame.columnSlack += static_cast<float>(kColumnTolerance);
  tables.masked = static_cast<uint32_t>(group.silent.size());
  return tables;
}

// Gives all tables the same size.
void makeAlike(std::span<BeamTables> all) {
  uint32_t beams = 0;
  size_t farthest = 0;
  for (const BeamTables& tables : all) {
    beams = std::max(beams, tables.frame.beams);
    farthest = std::max(farthest, tables.startFarthest.size());
  }
  for (uint32_t i = 0; i < all.size(); ++i) {
    all[i].frame.beams = beams;
    all[i].frame.table = i;
    if (all[i].startFarthest.empty()) all[i].startFarthest.resize(farthest, gpu::kNone);
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

std::vector<BeamTables> makeListedTables(const Sensor& sensor, std::span<const FiredGroup> groups, bool mayMap) {
  struct Sorted {
    std::vector<Listed> beams;
    std::vector<size_t> ends;
  };
  const auto sortedOf = [&](uint64_t frame, const std::vector<uint32_t>& numbers) {
    std::vector<Listed> beams = sortedBeams(sensor, frame, numbers);
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
  all.clear();
  for (size_t i = 0; i < groups.size(); ++i)
    all.push_back(listInCells(sensor, groups[i].frame, std::move(sorted[i].beams), sorted[i].ends, rows, columns,
                              *groups[i].group));
  makeAlike(all);
  setRanges(sensor, all);
  return all;
}

}  // namespace gnosphere
