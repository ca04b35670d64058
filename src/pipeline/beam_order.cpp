// SPDX-License-Identifier: Apache-2.0
#include "pipeline/beam_order.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/limits.hpp"
#include "sensor/beams.hpp"

namespace gnosphere {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr uint32_t kLeastColumns = 16, kMostCellColumns = 1 << 22;
// Elevations closer than this, in radians, are one, unless many of them follow each other.
constexpr double kSameElevation = 1e-6;
// So many beams per elevation make it worth a row of its own.
constexpr uint64_t kBeamsPerElevation = 16;

}  // namespace

std::vector<ListedBeam> sortedBeams(const Sensor& sensor, uint64_t frame, const std::vector<uint32_t>& numbers) {
  std::vector<ListedBeam> beams;
  beams.reserve(numbers.size());
  for (const uint32_t beam : numbers)
    beams.push_back({azimuthOf(sensor, beam, frame), elevationOf(sensor, beam, frame), beam, 0, 0});
  const auto before = [](const ListedBeam& a, const ListedBeam& b) {
    return a.elevation < b.elevation || (a.elevation == b.elevation && a.number < b.number);
  };
  std::sort(beams.begin(), beams.end(), before);
  return beams;
}

std::vector<size_t> rowEnds(const std::vector<ListedBeam>& beams) {
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
  // Each row is then a band of the sphere that is as high as a cell is wide, if the beams are spread evenly.
  const auto [least, most] = std::minmax_element(
      beams.begin(), beams.end(), [](const ListedBeam& a, const ListedBeam& b) { return a.azimuth < b.azimuth; });
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

uint32_t mostColumns(uint64_t beams, uint64_t rows) {
  const uint64_t cells = std::max(kLeastCells, kCellsPerBeam * beams);
  return static_cast<uint32_t>(
      std::clamp<uint64_t>(cells / std::max<uint64_t>(rows, 1), kLeastColumns, kMostCellColumns));
}

uint32_t columnCount(const std::vector<ListedBeam>& beams, const std::vector<size_t>& ends) {
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

}  // namespace gnosphere
