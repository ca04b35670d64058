// SPDX-License-Identifier: Apache-2.0
#include "pipeline/beam_cells.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "base/threads.hpp"
#include "gnosphere/error.hpp"
#include "sensor/beams.hpp"

namespace gnosphere {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr uint64_t kMostBeams = 0x7fffffffu;
constexpr uint32_t kMostRows = 65535, kMostColumns = 1 << 22;
constexpr uint64_t kCellsPerBeam = 4, kLeastCells = 1 << 16;
// Elevations closer than this, in radians, are one, unless many of them follow each other.
constexpr double kSameElevation = 1e-6;
// So many beams per elevation make it worth a row of its own.
constexpr uint64_t kBeamsPerElevation = 4;
// A beam belongs to a column although it lies before it by this share of a column.
constexpr double kColumnTolerance = 1e-4;

struct Angles {
  double azimuth, elevation;  // radians
};

struct Listed {
  double azimuth, elevation;
  uint32_t number, row, column;
};

// Returns the rows as numbers of beams, of beams sorted by elevation.
std::vector<size_t> rowEnds(const std::vector<Listed>& beams) {
  std::vector<size_t> ends;
  double lowest = beams[0].elevation;
  for (size_t i = 1; i <= beams.size() && ends.size() <= kMostRows; ++i) {
    const bool same = i < beams.size() && beams[i].elevation - beams[i - 1].elevation <= kSameElevation &&
                      beams[i].elevation - lowest <= 4 * kSameElevation;
    if (same) continue;
    ends.push_back(i);
    if (i < beams.size()) lowest = beams[i].elevation;
  }
  if (ends.size() <= kMostRows && ends.size() * kBeamsPerElevation <= beams.size()) return ends;
  // A band of the sphere that is as high as a cell is wide, if the beams are spread evenly.
  const auto [least, most] = std::minmax_element(
      beams.begin(), beams.end(), [](const Listed& a, const Listed& b) { return a.azimuth < b.azimuth; });
  const double across = std::max(most->azimuth - least->azimuth, 1e-6);
  const double up = std::max(beams.back().elevation - beams.front().elevation, 1e-6);
  const double count = static_cast<double>(beams.size());
  const auto rows = static_cast<size_t>(
      std::clamp(std::round(std::sqrt(count * up / across)), 1.0, std::min(count, double{kMostRows})));
  ends.clear();
  for (size_t row = 1; row <= rows; ++row) {
    size_t end = beams.size() * row / rows;
    // Beams of one elevation are in one row, so that no two rows overlap.
    while (end < beams.size() && beams[end].elevation == beams[end - 1].elevation) ++end;
    if (end > 0 && (ends.empty() || end > ends.back())) ends.push_back(end);
  }
  return ends;
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
  const uint64_t most =
      std::clamp<uint64_t>(std::max(kLeastCells, kCellsPerBeam * beams.size()) / ends.size(), 16, kMostColumns);
  if (gaps.empty()) return static_cast<uint32_t>(std::min<uint64_t>(most, 1024));
  std::nth_element(gaps.begin(), gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2), gaps.end());
  const double columns = std::round(kTurn / gaps[gaps.size() / 2]);
  return static_cast<uint32_t>(std::clamp(columns, 16.0, static_cast<double>(most)));
}

// The beams that fire, in order of elevation.
std::vector<Listed> firingBeams(const Sensor& sensor, uint64_t frame, std::vector<uint32_t>& masked) {
  const size_t count = sensor.beamCount();
  std::vector<bool> silent(count);
  for (const uint32_t beam : sensor.maskedBeams) silent[beam] = true;
  std::vector<Listed> beams;
  beams.reserve(count);
  for (size_t beam = 0; beam < count; ++beam) {
    const auto number = static_cast<uint32_t>(beam);
    if (silent[beam])
      masked.push_back(number);
    else
      beams.push_back({azimuthOf(sensor, beam, frame), elevationOf(sensor, beam, frame), number, 0, 0});
  }
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

}  // namespace

BeamTables makeListedTables(const Sensor& sensor, uint64_t frame) {
  if (sensor.beamCount() > kMostBeams)
    throw Error(ErrorCode::invalidArgument, "sensor '" + sensor.name + "' has " + std::to_string(sensor.beamCount()) +
                                                " beams; the limit of a list is " + std::to_string(kMostBeams));
  std::vector<uint32_t> masked;
  std::vector<Listed> beams = firingBeams(sensor, frame, masked);
  const std::vector<size_t> ends = beams.empty() ? std::vector<size_t>{} : rowEnds(beams);
  const uint32_t columns = beams.empty() ? 16 : columnCount(beams, ends);

  BeamTables tables;
  tables.listed = true;
  std::vector<RowKeys> keys;
  for (size_t row = 0; row < ends.size(); ++row) {
    const size_t begin = row == 0 ? 0 : ends[row - 1];
    keys.push_back({elevationKey(beams[begin].elevation), elevationKey(beams[ends[row] - 1].elevation)});
  }
  tables.rows.resize(ends.size());
  tables.rowLookup = makeRowLookup(keys);
  sortIntoCells(beams, ends, columns);
  for (const uint32_t number : masked) beams.push_back({azimuthOf(sensor, number, frame), 0, number, 0, 0});
  tables.masked = static_cast<uint32_t>(masked.size());
  setFrame(sensor, columns, tables);

  const size_t firing = beams.size() - masked.size();
  tables.cellStarts.reserve(ends.size() * columns + 1);
  for (size_t cell = 0, beam = 0; cell < ends.size() * columns; ++cell) {
    tables.cellStarts.push_back(static_cast<uint32_t>(beam));
    while (beam < firing && size_t{beams[beam].row} * columns + beams[beam].column == cell) ++beam;
  }
  tables.cellStarts.push_back(static_cast<uint32_t>(firing));

  const ScanTimes times = scanTimesOf(sensor, true, frame);
  bool ownRanges = !masked.empty();
  for (size_t i = 0; i < beams.size(); ++i) {
    const uint32_t number = beams[i].number;
    const double azimuth = azimuthOf(sensor, number, frame), elevation = elevationOf(sensor, number, frame);
    tables.numbers.push_back(number);
    tables.angles.push_back({onLattice(std::cos(azimuth)), onLattice(std::sin(azimuth)), onLattice(std::cos(elevation)),
                             onLattice(std::sin(elevation))});
    const RangeWindow window = rangeWindowOf(sensor, number, frame);
    // The range window of a masked beam is empty.
    tables.ranges.push_back(i < firing ? gpu::vec2(window.least, window.most) : gpu::vec2(1, -1));
    ownRanges |= window.least != sensor.rangeMin || window.most != sensor.rangeMax;
    const Vec3 origin = originOf(sensor, number, frame);
    const double place = times.step > 0 ? (timeOf(sensor, number, frame) - times.first) / times.step : 0;
    tables.origins.push_back({static_cast<float>(origin.x), static_cast<float>(origin.y), static_cast<float>(origin.z),
                              static_cast<float>(place)});
  }
  tables.frame.ownRanges = ownRanges;
  tables.frame.hidesNear = sensor.nearHits == NearHits::hide;
  if (ownRanges) {
    // Culling by range must keep what any beam can hit.
    for (const gpu::vec2& range : tables.ranges) {
      tables.frame.rangeMin = std::min(tables.frame.rangeMin, range.x);
      tables.frame.rangeMax = std::max(tables.frame.rangeMax, range.y);
    }
  } else {
    tables.ranges.clear();
  }
  // A beam lies up to one column behind the column of its cell. What it may lie before it is slack.
  tables.frame.shiftMax = 1;
  tables.frame.columnSlack += static_cast<float>(kColumnTolerance);
  return tables;
}

}  // namespace gnosphere
