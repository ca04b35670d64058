// SPDX-License-Identifier: Apache-2.0
// Checks a sensor, and names the field that is wrong.
#include <algorithm>
#include <cmath>

#include "base/finite.hpp"
#include "base/limits.hpp"
#include "base/text.hpp"
#include "base/vector.hpp"
#include "gnosphere/sensor.hpp"
#include "sensor/beams.hpp"

namespace gnosphere {
namespace {

std::string nameOf(const Sensor& sensor) {
  return "sensor " + (sensor.name.empty() ? "without a name" : sensor.name);
}

[[noreturn]] void refuse(const Sensor& sensor, const std::string& why) {
  throw Error(ErrorCode::invalidArgument, nameOf(sensor) + ": " + why);
}

std::string coordinates(const Vec3& v) {
  return std::string("[") + numberText(v.x) + ", " + numberText(v.y) + ", " + numberText(v.z) + "]";
}

void checkChannel(const Sensor& sensor, size_t j) {
  const Channel& channel = sensor.channels[j];
  const auto refuseIts = [&](const char* what, const std::string& why) {
    refuse(sensor, std::string(what) + " of channel " + std::to_string(j) + " must be " + why);
  };
  if (!(std::abs(channel.elevationDeg) <= 90))
    refuseIts("elevation", "within -90..90 degrees, is " + numberText(channel.elevationDeg));
  if (!(std::abs(channel.azimuthOffsetDeg) <= 360))
    refuseIts("azimuth offset", "within -360..360 degrees, is " + numberText(channel.azimuthOffsetDeg));
  if (!limits::kOrigin.holds(lengthOf(channel.origin)))
    refuseIts("origin", "within 1 m of the sensor's, is " + coordinates(channel.origin));
  if (!(std::abs(channel.timeOffset) <= 1))
    refuseIts("time offset", "within -1..1 s, is " + numberText(channel.timeOffset));
  for (const double range : {channel.rangeMin, channel.rangeMax})
    if (!(range >= 0) || !isFiniteFloat(range)) refuseIts("range", "finite and at least 0, is " + numberText(range));
  if (sensor.rotationPeriod > 0 && std::abs(channel.timeOffset) > sensor.rotationPeriod)
    refuseIts("time offset", "within the rotation period, " + numberText(sensor.rotationPeriod) + " s, is " +
                                 numberText(channel.timeOffset));
  const bool hasOwn = channel.rangeMin > 0 || channel.rangeMax > 0;
  const double least = channel.rangeMin > 0 ? channel.rangeMin : sensor.rangeMin;
  const double most = channel.rangeMax > 0 ? channel.rangeMax : sensor.rangeMax;
  if (hasOwn && most > 0 && least >= most)
    refuseIts("range min", "less than its range max, " + numberText(most) + ", is " + numberText(least));
}

void checkGrid(const Sensor& sensor) {
  if (sensor.columns == 0) refuse(sensor, "columns must be at least 1");
  limits::kBeams.check(sensor.beamCount(), nameOf(sensor) + ": its columns and channels make");
  for (size_t j = 0; j < sensor.channels.size(); ++j) checkChannel(sensor, j);
  if (!(std::abs(sensor.azimuthStartDeg) <= 360))
    refuse(sensor, "azimuth start must be within -360..360 degrees, is " + numberText(sensor.azimuthStartDeg));
  if (!(std::abs(sensor.azimuthSpanDeg) <= 360) || sensor.azimuthSpanDeg == 0)
    refuse(sensor, "azimuth span must be within -360..360 degrees and not 0, is " + numberText(sensor.azimuthSpanDeg));
}

/// One pattern of a list sensor, and how messages name it.
struct Pattern {
  const Sensor& sensor;
  const BeamList& list;
  std::string name;

  [[noreturn]] void refuse(const std::string& why) const { gnosphere::refuse(sensor, std::string(name).append(why)); }

  template <typename T>
  void checkLength(const char* what, const std::vector<T>& values) const {
    if (!values.empty() && values.size() != list.size())
      refuse(std::string(what) + " has " + std::to_string(values.size()) + " entries, directions has " +
             std::to_string(list.size()) + "; there must be one per beam in both");
  }

  template <typename T, typename Good>
  void checkEach(const char* what, const std::vector<T>& values, Good good, const char* wanted) const {
    checkLength(what, values);
    const auto bad = std::find_if_not(values.begin(), values.end(), good);
    if (bad != values.end())
      refuse(std::string(what) + " of beam " + std::to_string(bad - values.begin()) + " must be " + wanted);
  }

  void check() const;
};

void Pattern::check() const {
  if (list.size() == 0) refuse("directions are empty");
  limits::kBeams.check(list.size(), nameOf(sensor) + ": " + name + "it has");
  if (list.size() != sensor.patterns[0].size())
    refuse("has " + std::to_string(list.size()) + " beams, pattern 0 has " + std::to_string(sensor.patterns[0].size()) +
           "; all patterns must have the same number");
  checkEach(
      "direction", list.directions, [&](const Vec3& d) { return std::abs(lengthOf(d) - 1) <= 1e-4; }, "a unit vector");
  checkEach(
      "origin", list.origins, [](const Vec3& o) { return limits::kListedOrigin.holds(lengthOf(o)); },
      "within 1 km of the sensor's");
  checkEach(
      "time", list.times, [](double t) { return t >= 0 && limits::kSeconds.holds(t); }, "within 0..10 s");
  const auto isRange = [](float range) { return range >= 0 && std::isfinite(range); };
  checkEach("range min", list.rangeMin, isRange, "finite and at least 0");
  checkEach("range max", list.rangeMax, isRange, "finite and at least 0");
  for (size_t i = 0; i < std::min(list.rangeMin.size(), list.rangeMax.size()); ++i)
    if (list.rangeMin[i] > list.rangeMax[i])
      refuse("range min of beam " + std::to_string(i) + " must be at most its range max, " +
             numberText(double{list.rangeMax[i]}) + ", is " + numberText(double{list.rangeMin[i]}));
  checkLength("rings", list.rings);
  if ((list.width > 0 || list.height > 0) && uint64_t{list.width} * list.height != list.size())
    refuse("an organised cloud of " + std::to_string(list.width) + " x " + std::to_string(list.height) +
           " does not suit " + std::to_string(list.size()) + " beams");
}

void checkPatterns(const Sensor& sensor) {
  if (sensor.columns != 0 || !sensor.channels.empty())
    refuse(sensor, "columns and channels belong to a grid, patterns to a list of beams; keep one");
  for (size_t i = 0; i < sensor.patterns.size(); ++i) {
    std::string name;
    if (sensor.patterns.size() > 1) name.append("pattern ").append(std::to_string(i)).append(": ");
    Pattern{sensor, sensor.patterns[i], name}.check();
    if (sensor.patterns[i].width != sensor.patterns[0].width || sensor.patterns[i].height != sensor.patterns[0].height)
      refuse(sensor, name + "its organised cloud has another size than that of pattern 0");
  }
}

/// Refuses scans that begin before the one in front of them has ended. Rates and periods are rounded.
void checkScanPeriod(const Sensor& sensor) {
  const double period = sensor.scanPeriod;
  if (!std::isfinite(period) || period < 0) refuse(sensor, "scan period must be finite and at least 0");
  if (period == 0) return;
  const double last = std::max(sensor.rotationPeriod, lastTimeOf(sensor));
  if (last > period * (1 + 1e-9))
    refuse(sensor, "scan period must be at least that of a scan, " + numberText(last) + " s, is " + numberText(period));
}

/// Whether there are beams for which the sensor's own ranges count.
bool hasBeamsWithoutRanges(const Sensor& sensor) {
  const auto isWithout = [](const Channel& channel) { return channel.rangeMax == 0; };
  const auto areWithout = [](const BeamList& list) { return list.rangeMax.empty() && list.size() > 0; };
  return sensor.isGrid() ? std::any_of(sensor.channels.begin(), sensor.channels.end(), isWithout)
                         : std::any_of(sensor.patterns.begin(), sensor.patterns.end(), areWithout);
}

}  // namespace

void validate(const Sensor& sensor) {
  sensor.isGrid() ? checkGrid(sensor) : checkPatterns(sensor);
  for (const uint32_t beam : sensor.maskedBeams)
    if (beam >= sensor.beamCount())
      refuse(sensor, "masked beam " + std::to_string(beam) + " does not exist, there are " +
                         std::to_string(sensor.beamCount()));
  if (!isFiniteFloat(sensor.rangeMin) || sensor.rangeMin < 0) refuse(sensor, "range min must be finite and at least 0");
  if (!isFiniteFloat(sensor.rangeMax))
    refuse(sensor, "range max must be finite in single precision, is " + numberText(sensor.rangeMax));
  if (!isFiniteFloat(sensor.rangeAt10Percent) || sensor.rangeAt10Percent < 0)
    refuse(sensor, "range at 10 % must be finite and at least 0");
  if (sensor.rangeMin > sensor.rangeMax) {
    refuse(sensor, "range min " + numberText(sensor.rangeMin) + " is beyond range max " + numberText(sensor.rangeMax));
  }
  if (sensor.rangeMax == 0 && hasBeamsWithoutRanges(sensor))
    refuse(sensor, "range max is 0 m, so no hit would count; set it to the farthest range that the sensor measures");
  for (double divergence : {sensor.divergenceHorizontal, sensor.divergenceVertical}) {
    if (!(divergence >= 0 && limits::kDivergence.holds(1000 * divergence)))
      refuse(sensor, "divergence must be within 0..100 mrad, is " + numberText(1000 * divergence) +
                         (1000 * divergence > double(limits::kDivergence.most) ? limits::kWiderBeam : ""));
  }
  if (sensor.maxReturns < 1 || !limits::kReturns.holds(sensor.maxReturns))
    refuse(sensor, "max returns must be within 1.." + std::to_string(limits::kReturns.most) + ", is " +
                       std::to_string(sensor.maxReturns));
  constexpr double kShortest = 1e-9;  // of a scan, in seconds: speeds within shorter ones have no number
  const double turn = sensor.rotationPeriod;
  if (!(turn == 0 || turn >= kShortest) || !limits::kSeconds.holds(turn))
    refuse(sensor, "rotation period must be 0 or within 1e-9..10 s, is " + numberText(turn) +
                       "; of a scanner that stands and turns longer leave it out: then all beams fire at once");
  for (size_t pattern = 0; pattern < std::max<size_t>(sensor.patterns.size(), 1); ++pattern)
    if (const double last = durationOf(sensor, pattern); last > 0 && last < kShortest)
      refuse(sensor, "the last beam must fire at 0 s, or at 1e-9 s or later, and fires at " + numberText(last) + " s");
  checkScanPeriod(sensor);
}

}  // namespace gnosphere
