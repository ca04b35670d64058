// SPDX-License-Identifier: Apache-2.0
#include "sensor/beams.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "base/units.hpp"
#include "base/vector.hpp"

namespace gnosphere {
namespace {

struct SinCos {
  double sin, cos;
};

/// Reduces the angle in degrees, where 90 is exact: axes and diagonals come out exact, and every quadrant has the same
/// bits.
SinCos sinCosDegrees(double degrees) {
  int quadrant = 0;
  const double rest = std::remquo(degrees, 90.0, &quadrant);
  const double s = std::sin(rest * std::numbers::pi / 180);
  const double c = std::cos(rest * std::numbers::pi / 180);
  switch (quadrant & 3) {
    case 0: return {s, c};
    case 1: return {c, -s};
    case 2: return {-s, -c};
    default: return {-c, s};
  }
}

// Why the device must treat the sensor as a list of beams, as a predicate; null if it need not.
const char* causeOfBeamList(const Sensor& sensor) {
  const auto hasWindow = [](const Channel& channel) { return channel.rangeMin > 0 || channel.rangeMax > 0; };
  if (!sensor.isGrid()) return "is a list of beams";
  if (sensor.azimuthSpanDeg < 0) return "turns clockwise";
  if (sensor.azimuthSpanDeg < 360) return "covers a sector";
  if (sensor.azimuthStartDeg != -180) return "does not start at -180 degrees";
  if (!sensor.maskedBeams.empty()) return "has masked beams";
  if (sensor.nearHits == NearHits::hide && sensor.rangeMin > 0) return "hides near hits";
  if (std::any_of(sensor.channels.begin(), sensor.channels.end(), hasWindow))
    return "has channels with range windows of their own";
  return nullptr;
}

// Returns whether each elevation is less than a fiftieth of a step away from its place between the lowest and the
// highest one. Files round elevations, and a box of the paper that is wrong by so little hardly loses a beam.
bool hasEvenElevations(const Sensor& sensor) {
  const size_t count = sensor.channels.size();
  if (count < 2) return true;
  const std::vector<uint32_t> channels = channelsByElevation(sensor);
  const double first = sensor.channels[channels.front()].elevationDeg;
  const double step = (sensor.channels[channels.back()].elevationDeg - first) / static_cast<double>(count - 1);
  for (size_t i = 0; i < count; ++i) {
    const double place = first + static_cast<double>(i) * step;
    if (!(std::abs(sensor.channels[channels[i]].elevationDeg - place) < 0.02 * step)) return false;
  }
  return true;
}

// Degrees, reduced to one turn. Without a sector -180 + 360 i / columns is rounded once.
double azimuthDegOf(const Sensor& sensor, size_t beam) {
  const auto column = static_cast<double>(beam % sensor.columns);
  const double columnDeg = (sensor.azimuthSpanDeg * column + sensor.azimuthStartDeg * sensor.columns) / sensor.columns;
  return std::remainder(columnDeg + sensor.channels[beam / sensor.columns].azimuthOffsetDeg, 360.0);
}

template <typename T>
T entryOf(const std::vector<T>& list, size_t beam, T otherwise) {
  return list.empty() ? otherwise : list[beam];
}

}  // namespace

const BeamList& patternOf(const Sensor& sensor, uint64_t frame) {
  return sensor.patterns[frame % sensor.patterns.size()];
}

Vec3 unitVectorAt(double azimuthDeg, double elevationDeg) {
  const SinCos azimuth = sinCosDegrees(azimuthDeg), elevation = sinCosDegrees(elevationDeg);
  return {elevation.cos * azimuth.cos, elevation.cos * azimuth.sin, elevation.sin};
}

Vec3 directionOf(const Sensor& sensor, size_t beam, uint64_t frame) {
  if (!sensor.isGrid()) {
    const Vec3& d = patternOf(sensor, frame).directions[beam];
    const double length = lengthOf(d);
    return {d.x / length, d.y / length, d.z / length};
  }
  return unitVectorAt(azimuthDegOf(sensor, beam), sensor.channels[beam / sensor.columns].elevationDeg);
}

Vec3 originOf(const Sensor& sensor, size_t beam, uint64_t frame) {
  if (!sensor.isGrid()) return entryOf(patternOf(sensor, frame).origins, beam, Vec3{});
  const Vec3& from = sensor.channels[beam / sensor.columns].origin;
  const double azimuth = azimuthOf(sensor, beam), c = std::cos(azimuth), s = std::sin(azimuth);
  return {c * from.x - s * from.y, s * from.x + c * from.y, from.z};
}

double timeOf(const Sensor& sensor, size_t beam, uint64_t frame) {
  if (!sensor.isGrid()) return entryOf(patternOf(sensor, frame).times, beam, 0.0);
  const size_t column = beam % sensor.columns, channel = beam / sensor.columns;
  return sensor.rotationPeriod * static_cast<double>(column) / sensor.columns + sensor.channels[channel].timeOffset;
}

double azimuthOf(const Sensor& sensor, size_t beam, uint64_t frame) {
  if (sensor.isGrid()) return kDegree * azimuthDegOf(sensor, beam);
  const Vec3& d = patternOf(sensor, frame).directions[beam];
  // Backwards is -pi, as in column 0 of a full turn.
  const double azimuth = std::atan2(d.y, d.x);
  return azimuth < std::numbers::pi ? azimuth : -std::numbers::pi;
}

double elevationOf(const Sensor& sensor, size_t beam, uint64_t frame) {
  if (sensor.isGrid()) return kDegree * sensor.channels[beam / sensor.columns].elevationDeg;
  const Vec3& d = patternOf(sensor, frame).directions[beam];
  return std::atan2(d.z, lengthOf(d.x, d.y));
}

ScanTimes scanTimesOf(const Sensor& sensor, bool listed, uint64_t frame) {
  const double period = sensor.rotationPeriod;
  if (!listed)
    return {0,
            sensor.columns > 0 ? period / sensor.columns : 0,
            period / 2,
            period,
            sensor.columns,
            0,
            sensor.columns,
            0.5 * sensor.columns};
  double first = 0, last = 0;
  const auto include = [&](double time) {
    first = std::min(first, time);
    last = std::max(last, time);
  };
  if (sensor.isGrid())
    for (const Channel& channel : sensor.channels) {
      include(channel.timeOffset);
      include(channel.timeOffset + period);
    }
  else
    for (const double time : patternOf(sensor, frame).times) include(time);
  return {first,
          (last - first) / kListIntervals,
          (first + last) / 2,
          last,
          kListIntervals + 2,
          first,
          kListIntervals + 2,
          0.5 * kListIntervals};
}

bool firesInTurn(const Sensor& sensor) {
  const auto hasTimes = [](const BeamList& pattern) {
    return std::any_of(pattern.times.begin(), pattern.times.end(), [](double time) { return time != 0; });
  };
  return sensor.rotationPeriod > 0 || hasTimeOffsets(sensor) ||
         std::any_of(sensor.patterns.begin(), sensor.patterns.end(), hasTimes);
}

bool hasRings(const Sensor& sensor) {
  return std::any_of(sensor.patterns.begin(), sensor.patterns.end(),
                     [](const BeamList& pattern) { return !pattern.rings.empty(); });
}

bool hasTimeOffsets(const Sensor& sensor) {
  return std::any_of(sensor.channels.begin(), sensor.channels.end(),
                     [](const Channel& c) { return c.timeOffset != 0; });
}

bool hasAzimuthOffsets(const Sensor& sensor) {
  return std::any_of(sensor.channels.begin(), sensor.channels.end(),
                     [](const Channel& c) { return c.azimuthOffsetDeg != 0; });
}

std::vector<uint32_t> channelsByElevation(const Sensor& sensor) {
  std::vector<uint32_t> order(sensor.channels.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    return sensor.channels[a].elevationDeg < sensor.channels[b].elevationDeg;
  });
  return order;
}

bool hasOrigins(const Sensor& sensor) {
  const auto away = [](const Vec3& origin) { return origin.x != 0 || origin.y != 0 || origin.z != 0; };
  return std::any_of(sensor.channels.begin(), sensor.channels.end(),
                     [&](const Channel& c) { return away(c.origin); }) ||
         std::any_of(sensor.patterns.begin(), sensor.patterns.end(), [&](const BeamList& pattern) {
           return std::any_of(pattern.origins.begin(), pattern.origins.end(), away);
         });
}

OriginBounds originBoundsOf(const Sensor& sensor, uint64_t frame, const Vec3& centre, std::span<const uint32_t> beams) {
  OriginBounds bounds = {centre};
  const auto include = [&](double forward, double left, double up) {
    bounds.distance = std::max(bounds.distance, lengthOf({forward, left, up}));
    bounds.forward = std::max(bounds.forward, std::abs(forward));
    bounds.left = std::max(bounds.left, std::abs(left));
    bounds.up = std::max(bounds.up, std::abs(up));
  };
  for (const Channel& channel : sensor.channels)
    include(channel.origin.x, channel.origin.y, channel.origin.z - centre.z);
  if (sensor.isGrid() || patternOf(sensor, frame).origins.empty()) return bounds;
  for (const uint32_t beam : beams) {
    const Vec3 from = originOf(sensor, beam, frame), o = {from.x - centre.x, from.y - centre.y, from.z - centre.z};
    const double azimuth = azimuthOf(sensor, beam, frame), c = std::cos(azimuth), s = std::sin(azimuth);
    include(c * o.x + s * o.y, c * o.y - s * o.x, o.z);
  }
  return bounds;
}

Vec3 middleOfLasers(const Sensor& sensor) {
  if (sensor.channels.empty()) return {};
  const auto below = [](const Channel& a, const Channel& b) { return a.origin.z < b.origin.z; };
  const auto [low, high] = std::minmax_element(sensor.channels.begin(), sensor.channels.end(), below);
  return {0, 0, low->origin.z == high->origin.z ? low->origin.z : 0.5 * (low->origin.z + high->origin.z)};
}

double durationOf(const Sensor& sensor, uint64_t frame) {
  return sensor.rotationPeriod > 0 ? sensor.rotationPeriod : scanTimesOf(sensor, true, frame).last;
}

TimeSpan poseTimesOf(const Sensor& sensor, uint64_t frame) {
  const ScanTimes times = scanTimesOf(sensor, true, frame);
  const double duration = durationOf(sensor, frame);
  if (times.earliest >= 0 && times.last <= duration) return {0, duration};
  // Poses are known once a column, and interpolated between.
  const double step = sensor.isGrid() && sensor.columns > 0 ? duration / sensor.columns : 0;
  return {std::min(0.0, times.earliest - step), std::max(duration, times.last + step)};
}

double lastTimeOf(const Sensor& sensor) {
  double last = 0;
  for (const BeamList& list : sensor.patterns)
    for (const double time : list.times) last = std::max(last, time);
  return last;
}

double scanPeriodOf(const Sensor& sensor) {
  return sensor.scanPeriod > 0 ? sensor.scanPeriod : sensor.rotationPeriod;
}

RangeWindow rangeWindowOf(const Sensor& sensor, size_t beam, uint64_t frame) {
  if (!sensor.isGrid()) {
    const BeamList& pattern = patternOf(sensor, frame);
    return {pattern.rangeMin.empty() ? sensor.rangeMin : pattern.rangeMin[beam],
            pattern.rangeMax.empty() ? sensor.rangeMax : pattern.rangeMax[beam]};
  }
  const Channel& channel = sensor.channels[beam / sensor.columns];
  return {channel.rangeMin > 0 ? channel.rangeMin : sensor.rangeMin,
          channel.rangeMax > 0 ? channel.rangeMax : sensor.rangeMax};
}

RangeWindow widestWindow(const Sensor& sensor) {
  RangeWindow widest = {std::numeric_limits<double>::infinity(), 0};
  const auto include = [&](const RangeWindow& window) {
    widest = {std::min(widest.least, window.least), std::max(widest.most, window.most)};
  };
  if (sensor.isGrid()) {
    for (size_t channel = 0; channel < sensor.channels.size() && sensor.columns > 0; ++channel)
      include(rangeWindowOf(sensor, channel * sensor.columns));
  } else {
    for (const BeamList& list : sensor.patterns) {
      const auto least = std::min_element(list.rangeMin.begin(), list.rangeMin.end());
      const auto most = std::max_element(list.rangeMax.begin(), list.rangeMax.end());
      include({least == list.rangeMin.end() ? sensor.rangeMin : *least,
               most == list.rangeMax.end() ? sensor.rangeMax : *most});
    }
  }
  return widest.most > 0 ? widest : RangeWindow{sensor.rangeMin, sensor.rangeMax};
}

uint32_t ringOf(const Sensor& sensor, size_t beam, uint64_t frame) {
  if (sensor.isGrid()) return static_cast<uint32_t>(beam / sensor.columns);
  return entryOf(patternOf(sensor, frame).rings, beam, uint16_t{0});
}

std::vector<bool> silentBeams(const Sensor& sensor) {
  std::vector<bool> silent(sensor.beamCount());
  for (const uint32_t beam : sensor.maskedBeams) silent[beam] = true;
  return silent;
}

bool needsBeamList(const Sensor& sensor) {
  return causeOfBeamList(sensor) != nullptr;
}

std::string causeAgainstPaper(const Sensor& sensor) {
  if (const char* cause = causeOfBeamList(sensor)) return cause;
  return hasEvenElevations(sensor) ? "" : "has elevations at uneven steps";
}

BeamList beamsOf(const Sensor& sensor, uint64_t frame) {
  if (!sensor.isGrid()) return patternOf(sensor, frame);
  BeamList list;
  const size_t count = sensor.beamCount();
  const auto any = [&](auto has) { return std::any_of(sensor.channels.begin(), sensor.channels.end(), has); };
  const bool origins = hasOrigins(sensor), times = firesInTurn(sensor);
  const bool least = any([](const Channel& c) { return c.rangeMin > 0; });
  const bool most = any([](const Channel& c) { return c.rangeMax > 0; });
  for (size_t beam = 0; beam < count; ++beam) {
    list.directions.push_back(directionOf(sensor, beam));
    if (origins) list.origins.push_back(originOf(sensor, beam));
    if (times) list.times.push_back(timeOf(sensor, beam));
    const RangeWindow window = rangeWindowOf(sensor, beam);
    if (least) list.rangeMin.push_back(static_cast<float>(window.least));
    if (most) list.rangeMax.push_back(static_cast<float>(window.most));
    list.rings.push_back(static_cast<uint16_t>(ringOf(sensor, beam)));
  }
  list.width = sensor.width();
  list.height = sensor.height();
  return list;
}

}  // namespace gnosphere
