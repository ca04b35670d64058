// SPDX-License-Identifier: Apache-2.0
#include "sensor/row_grid.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/limits.hpp"
#include "sensor/beams.hpp"

namespace gnosphere {
namespace {

constexpr double kPlacesPerBeam = 4, kFewPlaces = 1 << 16;
// Columns that differ by less are at one place, and a phase that differs by less turns from a whole column is one.
constexpr double kSamePlace = 1e-9, kSameTurn = 3e-11;

double fractionOf(double value) {
  const double fraction = value - std::floor(value);
  return fraction < 1 ? fraction : 0;
}

/// Returns the fraction of a column from which on the others follow with the least distance to the last one.
double firstFraction(std::vector<double> fractions) {
  std::sort(fractions.begin(), fractions.end());
  double first = fractions[0], widest = fractions[0] + 1 - fractions.back();
  for (size_t i = 1; i < fractions.size(); ++i)
    if (const double gap = fractions[i] - fractions[i - 1]; gap > widest + kSamePlace) {
      widest = gap;
      first = fractions[i];
    }
  return first;
}

}  // namespace

uint32_t RowGrid::before() const {
  double least = 0;
  for (const Row& row : rows) least = std::min(least, row.lag);
  return static_cast<uint32_t>(std::ceil(-least));
}

uint32_t RowGrid::after() const {
  double most = 0;
  for (const Row& row : rows) most = std::max(most, row.lag);
  return static_cast<uint32_t>(std::ceil(most));
}

bool RowGrid::staggered() const {
  return std::any_of(rows.begin(), rows.end(), [](const Row& row) { return row.first != 0 || row.lag != 0; });
}

std::optional<RowGrid> rowGridOf(const Sensor& sensor) {
  if (!sensor.isGrid() || sensor.beamCount() == 0 || sensor.channels.size() > limits::kChannels.most) return {};
  RowGrid grid;
  grid.taken = sensor.columns;
  grid.clockwise = sensor.azimuthSpanDeg < 0;
  grid.step = sensor.rotationPeriod / sensor.columns;
  const double span = std::abs(sensor.azimuthSpanDeg);
  // A column more than fits into the turn leaves room for the last one.
  const double turn = 360 * (sensor.columns / span), whole = std::round(turn);
  const bool divides = std::abs(turn - whole) * sensor.columns < kSamePlace * turn;
  const double columns = divides ? whole : std::ceil(turn), places = columns * double(sensor.channels.size());
  if (places > double(limits::kBeams.most) ||
      places > std::max(kFewPlaces, kPlacesPerBeam * double(sensor.beamCount())))
    return {};
  grid.columns = static_cast<uint32_t>(columns);
  const double each = divides ? 1 : columns / turn;  // the distance of two columns, in places
  grid.stretch = divides ? 0 : (sensor.columns - 1) * (each - 1);

  const double startDeg =
      grid.clockwise ? sensor.azimuthStartDeg - span * (sensor.columns - 1) / sensor.columns : sensor.azimuthStartDeg;
  const std::vector<uint32_t> order = channelsByElevation(sensor);
  const auto shiftOf = [&](uint32_t channel) {
    return std::remainder(sensor.channels[channel].azimuthOffsetDeg, 360.0) / 360 * columns;
  };
  std::vector<double> fractions;
  for (const uint32_t channel : order) fractions.push_back(fractionOf(shiftOf(channel)));
  const double first = firstFraction(std::move(fractions));
  double phase = fractionOf(startDeg / 360 + 0.5) * columns + first;
  if (std::abs(phase - std::round(phase)) < kSameTurn * columns) phase = std::round(phase);
  grid.phase = phase < columns ? phase : phase - columns;
  for (const uint32_t channel : order) {
    const double shift = shiftOf(channel) - first, place = std::floor(shift + kSamePlace);
    const double lag = grid.step > 0 ? sensor.channels[channel].timeOffset / grid.step : 0;
    grid.rows.push_back(
        {channel, static_cast<int32_t>(place), std::max(shift - place, 0.0), grid.clockwise ? -lag : lag});
    grid.beside = std::max(grid.beside, grid.rows.back().behind);
  }
  grid.beside = grid.beside + grid.stretch > kSamePlace ? grid.beside + grid.stretch : 0;
  return grid;
}

ScanTimes scanTimesOf(const RowGrid& grid, const Sensor& sensor) {
  double least = 0, most = 0;
  for (const Channel& channel : sensor.channels) {
    least = std::min(least, channel.timeOffset);
    most = std::max(most, channel.timeOffset);
  }
  const uint32_t before = grid.before(), behind = grid.after() + 1;
  const double first = grid.clockwise ? grid.step * (grid.taken - 1.0 + before) : -grid.step * before;
  ScanTimes times = {first, grid.clockwise ? -grid.step : grid.step, sensor.rotationPeriod / 2,
                     sensor.rotationPeriod + most, before + grid.columns + behind};
  times.earliest = least;
  times.used = before + grid.taken + behind;
  times.halfway = grid.step > 0 ? (times.middle - times.first) / times.step : 0.5 * times.used;
  return times;
}

}  // namespace gnosphere
