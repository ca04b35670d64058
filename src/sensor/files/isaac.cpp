// SPDX-License-Identifier: Apache-2.0
// Lidar profiles of NVIDIA's Isaac Sim. Azimuths are counter-clockwise from x seen from above, z is up. A rotary lidar
// fires all its emitters reportRateBaseHz times a second, each time with the next emitter state; a solid-state lidar
// fires one emitter state per scan.
#include <algorithm>
#include <cmath>
#include <set>

#include "base/json_text.hpp"
#include "base/lasting.hpp"
#include "base/limits.hpp"
#include "base/text.hpp"
#include "base/units.hpp"
#include "sensor/beams.hpp"
#include "sensor/files/source.hpp"

namespace gnosphere {
namespace {

using nlohmann::json;

/// One state of the emitters. Optional lists are empty or have one entry per emitter.
struct Emitters {
  std::vector<double> azimuths, elevations, times, rings, ranges, heights, sides;
};

Emitters readState(SensorSource& source, const json& profile, const json& state, size_t index) {
  const std::string where = "emitterStates[" + std::to_string(index) + "]: ";
  if (!state.is_object()) source.refuse(where + "is no object");
  Emitters emitters;
  emitters.azimuths = numbersIn(source, state, "azimuthDeg");
  emitters.elevations = numbersIn(source, state, "elevationDeg");
  const size_t count = emitters.azimuths.size();
  const auto check = [&](const char* key, size_t found) {
    if (found != count)
      source.refuse(where + "'" + key + "' has " + std::to_string(found) + " entries, 'azimuthDeg' " +
                    std::to_string(count));
  };
  check("elevationDeg", emitters.elevations.size());
  const auto optional = [&](const char* key, std::vector<double>& list) {
    if (!state.contains(key)) return;
    list = numbersIn(source, state, key);
    check(key, list.size());
  };
  optional("fireTimeNs", emitters.times);
  optional("channelId", emitters.rings);
  optional("rangeId", emitters.ranges);
  optional("vertOffsetM", emitters.heights);
  optional("horOffsetM", emitters.sides);
  if (count == 0) source.refuse(where + "there is no emitter");
  if (const double stated = numberIn(source, profile, "numberOfEmitters", static_cast<double>(count));
      stated != static_cast<double>(count))
    source.refuse(where + "'azimuthDeg' has " + std::to_string(count) + " entries, 'numberOfEmitters' is " +
                  shownNumber(stated));
  for (const double ring : emitters.rings)
    if (!(ring >= 0 && ring <= 65535) || ring != std::floor(ring))
      source.refuse(where + "'channelId' " + shownNumber(ring) + " is no ring from 0 to 65535");
  static const auto& known = lasting(std::set<std::string>{"azimuthDeg", "elevationDeg", "fireTimeNs", "channelId",
                                                           "rangeId", "vertOffsetM", "horOffsetM"});
  for (const auto& [key, value] : state.items())
    if (!known.contains(key) && value.is_array()) source.ignore(key + " of the emitters");
  return emitters;
}

struct Window {
  double least, most;
};

/// Returns the range classes of a profile.
std::vector<Window> readRanges(const SensorSource& source, const json& profile) {
  std::vector<Window> windows;
  const auto ranges = profile.find("ranges");
  if (ranges == profile.end()) return windows;
  if (!ranges->is_array()) source.refuse("'ranges' is no list of 'min' and 'max'");
  for (const json& range : *ranges) {
    if (!range.is_object()) source.refuse("'ranges' is no list of 'min' and 'max'");
    windows.push_back({numberIn(source, range, "min"), numberIn(source, range, "max")});
  }
  return windows;
}

const Window& windowOf(const SensorSource& source, const std::vector<Window>& windows, double id) {
  if (!(id >= 0 && id < static_cast<double>(windows.size())) || id != std::floor(id))
    source.refuse("'rangeId' is " + shownNumber(id) + ", but 'ranges' has " + std::to_string(windows.size()) +
                  " entries");
  return windows[static_cast<size_t>(id)];
}

/// Adds the beams of emitters to a list. If emitters of any state have origins or ranges, all beams of a list have
/// them.
class Firing {
 public:
  Firing(const SensorSource& source, const std::vector<Emitters>& states, const std::vector<Window>& windows)
      : source_(source), windows_(windows) {
    for (const Emitters& emitters : states) {
      origins_ = origins_ || !emitters.heights.empty() || !emitters.sides.empty();
      ranges_ = ranges_ || (!emitters.ranges.empty() && !windows.empty());
    }
  }

  /// Appends one emitter, whose head is turned to `headDeg`, to a list of beams.
  void fire(const Emitters& emitters, size_t i, double headDeg, double time, uint16_t ring, BeamList& list) const {
    const double azimuth = emitters.azimuths[i] + headDeg;
    list.directions.push_back(directionOfAngles(source_, azimuth, emitters.elevations[i], list.size()));
    if (origins_) {
      const double side = emitters.sides.empty() ? 0 : emitters.sides[i], a = kDegree * azimuth;
      list.origins.push_back(
          {-std::sin(a) * side, std::cos(a) * side, emitters.heights.empty() ? 0 : emitters.heights[i]});
    }
    list.times.push_back(time + (emitters.times.empty() ? 0 : kNano * emitters.times[i]));
    list.rings.push_back(emitters.rings.empty() ? ring : static_cast<uint16_t>(emitters.rings[i]));
    if (!ranges_) return;
    const Sensor& sensor = source_.file.sensor;
    const Window window = emitters.ranges.empty() ? Window{sensor.rangeMin, sensor.rangeMax}
                                                  : windowOf(source_, windows_, emitters.ranges[i]);
    list.rangeMin.push_back(static_cast<float>(window.least));
    list.rangeMax.push_back(static_cast<float>(window.most));
  }

 private:
  const SensorSource& source_;
  const std::vector<Window>& windows_;
  bool origins_ = false, ranges_ = false;
};

/// The key of the range at which the least reflectance is detected: that of USD's schema, or else that of profiles.
const char* reachKeyOf(const json& profile) {
  return profile.contains("minReflectionRangeM") ? "minReflectionRangeM" : "minReflectanceRange";
}

/// Reads how far a dark target is detected. The power of a return falls with the square of the range. A reflectance of
/// 0 states no such range, because then nothing is too dark.
void readReach(SensorSource& source, const json& profile) {
  const char* key = reachKeyOf(profile);
  if (!profile.contains("minReflectance") || !profile.contains(key)) return;
  const double reflectance = numberIn(source, profile, "minReflectance");
  const double range = numberIn(source, profile, key);
  if (reflectance == 0) return;
  if (!(reflectance > 0 && reflectance <= 1))
    source.refuse("'minReflectance' is " + numberText(reflectance) + ", expected is a number from 0 to 1");
  source.file.sensor.rangeAt10Percent = range * std::sqrt(0.1 / reflectance);
}

/// The azimuths in degrees between which a turning head fires.
struct Sector {
  double start, end;
  std::string keys;  ///< of the profile that state the sector, for messages; empty if the profile states none
};

/// Reads the sector of a profile. Old profiles may have two pairs of keys for it, of which the first counts.
Sector readSector(SensorSource& source, const json& profile) {
  const auto stated = [&](const char* start, const char* end) {
    if (!profile.contains(start) && !profile.contains(end)) return Sector{0, 360, ""};
    const double from = numberIn(source, profile, start, 0);
    return Sector{from, numberIn(source, profile, end, from + 360), std::string(start) + " and " + end};
  };
  const Sector old = stated("startAzimuthDeg", "endAzimuthDeg");
  const Sector valid = stated("validStartAzimuthDeg", "validEndAzimuthDeg");
  if (old.keys.empty()) return valid;
  if (!valid.keys.empty() && (valid.start != old.start || valid.end != old.end)) source.ignore(valid.keys);
  return old;
}

/// Makes scans follow each other as often as a profile says, or as soon as the last beam of a list has fired.
void setScanPeriod(SensorSource& source, double scanRate) {
  Sensor& sensor = source.file.sensor;
  const double period = 1 / scanRate, last = lastTimeOf(sensor);
  sensor.scanPeriod = std::max(period, last);
  if (last > period * (1 + 1e-9))
    source.ignore("scanRateBaseHz " + numberText(scanRate) + ", because the last beam of a scan fires " +
                  numberText(last) + " s after its start");
}

/// Notes the sector of a solid-state lidar's profile as ignored if beams are outside of it: sectors are for turning
/// heads.
void noteBeamsOutside(SensorSource& source, const Sector& sector, const std::vector<Emitters>& states) {
  const double middle = (sector.start + sector.end) / 2, half = (sector.end - sector.start) / 2;
  const auto isOutside = [&](double azimuth) { return std::abs(std::remainder(azimuth - middle, 360)) > half + 1e-6; };
  for (const Emitters& emitters : states)
    if (std::any_of(emitters.azimuths.begin(), emitters.azimuths.end(), isOutside))
      return source.ignore(sector.keys + ", outside which beams of this solid-state lidar are");
}

void placeSolidState(SensorSource& source, const json& profile, const std::vector<Emitters>& states,
                     const std::vector<Window>& windows) {
  // Lines of equal lengths are rows of the organised cloud, and rings.
  uint32_t width = 0, height = 0;
  std::vector<uint16_t> lineOf;
  if (profile.contains("numRaysPerLine")) {
    const std::vector<double> lines = numbersIn(source, profile, "numRaysPerLine");
    const size_t count = states[0].azimuths.size();
    for (size_t line = 0; line < lines.size(); ++line) {
      const double rays = lines[line];
      if (!(rays >= 0) || rays != std::floor(rays))
        source.refuse("'numRaysPerLine' has " + shownNumber(rays) + ", which is no number of rays");
      if (line <= 65535 && lineOf.size() <= count)
        lineOf.resize(lineOf.size() + static_cast<size_t>(std::min(rays, static_cast<double>(count + 1))),
                      static_cast<uint16_t>(line));
    }
    if (lineOf.size() != count)
      source.refuse("'numRaysPerLine' does not add up to the " + std::to_string(count) + " emitters");
    if (std::all_of(lines.begin(), lines.end(), [&](double n) { return n == lines[0]; })) {
      width = static_cast<uint32_t>(lines[0]);
      height = static_cast<uint32_t>(lines.size());
    }
  }
  Sensor& sensor = source.file.sensor;
  const Firing firing(source, states, windows);
  noteBeamsOutside(source, readSector(source, profile), states);
  for (const Emitters& emitters : states) {
    BeamList& list = sensor.patterns.emplace_back();
    for (size_t i = 0; i < emitters.azimuths.size(); ++i)
      firing.fire(emitters, i, 0, 0, lineOf.empty() ? uint16_t{0} : lineOf[i], list);
    list.width = width;
    list.height = height;
  }
  const double scanRate = numberIn(source, profile, "scanRateBaseHz", 0);
  if (scanRate > 0) setScanPeriod(source, scanRate);
}

/// Whether the rings of emitters are their places, as those of a grid are.
bool ringsAreRows(const Emitters& emitters) {
  for (size_t i = 0; i < emitters.rings.size(); ++i)
    if (emitters.rings[i] != static_cast<double>(i)) return false;
  return true;
}

/// Masks the beams of a turn that a head would fire outside its sector, as it fires only between the two azimuths.
void maskOutside(SensorSource& source, const Sector& sector, double columns) {
  Sensor& sensor = source.file.sensor;
  const double width = sector.end - sector.start;
  if (width <= 0) source.ignore(sector.keys + ", because the end is not beyond the start");
  if (width >= 360 || width <= 0) return;
  for (size_t row = 0; row < sensor.height(); ++row)
    for (uint32_t column = 0; column < sensor.width(); ++column)
      if (std::abs(sensor.azimuthSpanDeg) * column / columns > width)
        sensor.maskedBeams.push_back(static_cast<uint32_t>(row) * sensor.width() + column);
}

void placeRotary(SensorSource& source, const json& profile, const std::vector<Emitters>& states,
                 const std::vector<Window>& windows) {
  const double scanRate = numberIn(source, profile, "scanRateBaseHz");
  const bool renamed = !profile.contains("reportRateBaseHz") && profile.contains("patternFiringRateHz");
  const double fireRate = numberIn(source, profile, renamed ? "patternFiringRateHz" : "reportRateBaseHz");
  if (!(scanRate > 0 && fireRate >= scanRate && fireRate / scanRate < 1e9))
    source.refuse("'reportRateBaseHz' is " + numberText(fireRate) + " and 'scanRateBaseHz' " + numberText(scanRate) +
                  ", expected are firings and turns per second");
  Sensor& sensor = source.file.sensor;
  // A turn need not be a whole number of firings: the columns are those of one turn, and end a little before it.
  const double columns = std::floor(fireRate / scanRate);
  sensor.columns = static_cast<uint32_t>(columns);
  sensor.rotationPeriod = columns / fireRate;
  sensor.scanPeriod = 1 / scanRate;
  const bool clockwise = !sameWord(textIn(profile, "rotationDirection"), "CCW");
  const Sector sector = readSector(source, profile);
  sensor.azimuthStartDeg = std::remainder(clockwise ? sector.end : sector.start, 360);
  sensor.azimuthSpanDeg = (clockwise ? -360 : 360) * columns * scanRate / fireRate;
  if (states[0].azimuths.size() > 65535) source.refuse("there are more than 65535 channels");
  checkBeamCount(source, columns, states[0].azimuths.size());

  if (states.size() == 1 && ringsAreRows(states[0])) {
    const Emitters& emitters = states[0];
    for (size_t i = 0; i < emitters.azimuths.size(); ++i) {
      Channel channel{emitters.elevations[i], emitters.azimuths[i]};
      channel.origin = {0, emitters.sides.empty() ? 0 : emitters.sides[i],
                        emitters.heights.empty() ? 0 : emitters.heights[i]};
      channel.timeOffset = emitters.times.empty() ? 0 : kNano * emitters.times[i];
      if (!emitters.ranges.empty() && !windows.empty()) {
        const Window& window = windowOf(source, windows, emitters.ranges[i]);
        channel.rangeMin = window.least;
        channel.rangeMax = window.most;
        sensor.rangeMin = std::min(sensor.rangeMin, window.least);  // counts for channels that have 0
      }
      sensor.channels.push_back(channel);
    }
  } else {
    BeamList list;
    const Firing firing(source, states, windows);
    const size_t rows = states[0].azimuths.size();
    for (size_t row = 0; row < rows; ++row)
      for (uint32_t column = 0; column < sensor.columns; ++column) {
        const Emitters& emitters = states[column % states.size()];
        firing.fire(emitters, row, sensor.azimuthStartDeg + sensor.azimuthSpanDeg * column / columns, column / fireRate,
                    static_cast<uint16_t>(row), list);
      }
    list.width = sensor.columns;
    list.height = static_cast<uint32_t>(rows);
    sensor.columns = 0;
    sensor.patterns.push_back(std::move(list));
    setScanPeriod(source, scanRate);
  }
  maskOutside(source, sector, columns);
}

}  // namespace

void readIsaac(SensorSource& source, const json& root) {
  const auto found = root.find("profile");
  if (found == root.end() || !found->is_object()) source.refuse("'profile' is missing, or no object");
  const json& profile = *found;
  const auto list = profile.find("emitterStates");
  if (list == profile.end() || !list->is_array() || list->empty()) source.refuse("'emitterStates' has no entry");
  const double stated = numberIn(source, profile, "emitterStateCount", static_cast<double>(list->size()));
  if (stated != static_cast<double>(list->size()))
    source.refuse("'emitterStateCount' is " + shownNumber(stated) + ", but 'emitterStates' has " +
                  std::to_string(list->size()) + " entries");
  std::vector<Emitters> states;
  for (size_t i = 0; i < list->size(); ++i) {
    states.push_back(readState(source, profile, (*list)[i], i));
    if (states[i].azimuths.size() != states[0].azimuths.size())
      source.refuse("emitterStates[" + std::to_string(i) + "] has " + std::to_string(states[i].azimuths.size()) +
                    " emitters, emitterStates[0] " + std::to_string(states[0].azimuths.size()));
  }
  Sensor& sensor = source.file.sensor;
  sensor.name = textIn(root, "name");
  sensor.rangeMin = numberIn(source, profile, "nearRangeM", 0);
  sensor.rangeMax = numberIn(source, profile, "farRangeM");
  const double returns = numberIn(source, profile, "maxReturns", 1);
  if (!(returns >= 1 && limits::kReturns.holds(returns)))
    source.refuse("'maxReturns' is " + numberText(returns) + ", expected is 1.." +
                  std::to_string(limits::kReturns.most));
  sensor.maxReturns = static_cast<uint32_t>(returns);
  readReach(source, profile);
  const std::vector<Window> windows = readRanges(source, profile);
  const auto namesRange = [](const Emitters& emitters) {
    return std::any_of(emitters.ranges.begin(), emitters.ranges.end(), [](double id) { return id != 0; });
  };
  if (windows.empty() && std::any_of(states.begin(), states.end(), namesRange))
    source.ignore("rangeId of the emitters, because their ranges are not stated");
  const std::string scanType = textIn(profile, "scanType");
  if (sameWord(scanType, "rotary"))
    placeRotary(source, profile, states, windows);
  else if (sameWord(scanType, "solidState") || sameWord(scanType, "solid_state"))
    placeSolidState(source, profile, states, windows);
  else
    source.refuse("'scanType' is '" + scanType + "', expected is rotary or solidState");

  static const auto& known = lasting(std::set<std::string>{
      "scanType",         "rotationDirection",    "nearRangeM",         "farRangeM",           "maxReturns",
      "scanRateBaseHz",   "reportRateBaseHz",     "numberOfEmitters",   "emitterStates",       "emitterStateCount",
      "ranges",           "rangeCount",           "numLines",           "numRaysPerLine",      "startAzimuthDeg",
      "endAzimuthDeg",    "validStartAzimuthDeg", "validEndAzimuthDeg", "patternFiringRateHz", "upElevationDeg",
      "downElevationDeg", "numberOfChannels"});
  const bool reaches = sensor.rangeAt10Percent > 0;
  for (const auto& [key, value] : profile.items()) {
    const bool comment = key.find("omment") != key.npos;
    const bool used = reaches && (key == "minReflectance" || key == reachKeyOf(profile));
    if (!known.contains(key) && !comment && !used && value != json(0.0)) source.ignore(key);
  }
}

}  // namespace gnosphere
