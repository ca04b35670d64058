// SPDX-License-Identifier: Apache-2.0
#include "sensor/files/source.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>
#include <utility>

#include "base/json_text.hpp"
#include "base/limits.hpp"
#include "base/text.hpp"
#include "base/vector.hpp"
#include "sensor/beams.hpp"

namespace gnosphere {

using nlohmann::json;

void setTurn(SensorSource& source, double startDeg) {
  Sensor& sensor = source.file.sensor;
  const SensorFileOptions& options = source.options;
  if (options.columns == 0)
    source.assume("1800 columns in a turn of 360 degrees; `gnosphere sensors --columns` sets another number");
  if (options.scanRate == 0) source.assume("10 turns per second; `gnosphere sensors --rate` sets another number");
  sensor.columns = options.columns > 0 ? options.columns : 1800;
  sensor.rotationPeriod = 1 / (options.scanRate > 0 ? options.scanRate : 10);
  sensor.azimuthStartDeg = startDeg;
  sensor.azimuthSpanDeg = -360;
}

void checkBeamCount(const SensorSource& source, double columns, size_t channels) {
  if (const double beams = columns * static_cast<double>(channels); beams > 1e8)
    source.refuse("makes " + shownNumber(beams) + " beams, of " + shownNumber(columns) +
                  " columns; at most 100 million are read");
}

void assumeRange(SensorSource& source, double metres, const std::string& why) {
  source.file.sensor.rangeMax = metres;
  source.assume("a largest range of " + numberText(metres) + " m" + why);
}

void delay(Channel& channel, double seconds, double degreesPerSecond) {
  channel.timeOffset += seconds;
  channel.azimuthOffsetDeg += degreesPerSecond * seconds;
}

void addDirection(const SensorSource& source, BeamList& list, const Vec3& d) {
  const double length = lengthOf(d);
  if (!(length > 0) || !std::isfinite(length))
    source.refuse("the direction of beam " + std::to_string(list.size()) +
                  (length == 0 ? " has no length" : " is not finite"));
  list.directions.push_back({d.x / length, d.y / length, d.z / length});
}

Vec3 directionOfAngles(const SensorSource& source, double azimuthDeg, double elevationDeg, size_t beam) {
  if (!std::isfinite(azimuthDeg) || !std::isfinite(elevationDeg))
    source.refuse("the angles of beam " + std::to_string(beam) + " are not finite");
  if (std::abs(elevationDeg) > 90 + 1e-9 || std::abs(azimuthDeg) > 720)
    source.refuse("beam " + std::to_string(beam) + " has the azimuth " + numberText(azimuthDeg) +
                  " and the elevation " + numberText(elevationDeg) + " degrees, which are no angles of a beam");
  return unitVectorAt(azimuthDeg, std::clamp(elevationDeg, -90.0, 90.0));
}

namespace {

/// Drops the times of a table that counts its beams in the column of times, as the published one of the Mid-360 does.
/// Times within a scan of `size` beams begin at its first one.
void dropTimes(SensorSource& source, BeamList& list, size_t size) {
  const auto isOfOneScan = [&](size_t first) {
    const auto begin = list.times.begin() + static_cast<std::ptrdiff_t>(first);
    const auto [least, most] = std::minmax_element(begin, begin + static_cast<std::ptrdiff_t>(size));
    return size < list.size() ? limits::kSeconds.holds(*most - *least) : *least >= 0 && limits::kSeconds.holds(*most);
  };
  bool right = true;
  for (size_t first = 0; first + size <= list.times.size(); first += size) right = right && isOfOneScan(first);
  if (right) return;
  const auto [least, most] = std::minmax_element(list.times.begin(), list.times.end());
  source.ignore("times from " + shownNumber(*least) + " to " + shownNumber(*most) +
                " s, which are not those of one scan");
  list.times.clear();
}

void ignoreRate(SensorSource& source) {
  if (source.rateAsked) source.ignore("the scan rate, because the file has firing times");
}

void spreadOver(BeamList& list, double rate) {
  for (size_t i = 0; i < list.size(); ++i)
    list.times.push_back(static_cast<double>(i) / (static_cast<double>(list.size()) * rate));
}

}  // namespace

void setPatterns(SensorSource& source, std::vector<BeamList> patterns) {
  bool timed = false;
  for (BeamList& list : patterns) {
    if (list.size() > 0) dropTimes(source, list, list.size());
    timed = timed || !list.times.empty();
    if (list.times.empty() && source.options.scanRate > 0) spreadOver(list, source.options.scanRate);
  }
  if (timed)
    ignoreRate(source);
  else if (source.options.scanRate > 0)
    source.file.sensor.scanPeriod = 1 / source.options.scanRate;
  source.file.sensor.patterns = std::move(patterns);
}

void setBeams(SensorSource& source, BeamList list) {
  const size_t count = list.size(), size = source.options.beamsPerScan;
  if (count == 0) source.refuse("the pattern has no beam");
  if (size > count)
    source.refuse("has " + std::to_string(count) + " beams, not " + std::to_string(size) + " for a scan");
  if (size == 0 || size == count) return setPatterns(source, {std::move(list)});
  dropTimes(source, list, size);
  const bool timed = !list.times.empty();
  if (timed) ignoreRate(source);
  const double rate = source.options.scanRate > 0 ? source.options.scanRate : 10;
  if (source.options.scanRate == 0 && !timed)
    source.assume("10 scans per second; `gnosphere sensors --rate` sets another number");
  if (!timed) source.file.sensor.scanPeriod = 1 / rate;
  for (size_t first = 0; first + size <= count; first += size) {
    BeamList& part = source.file.sensor.patterns.emplace_back();
    const auto cut = [&](auto& to, const auto& from) {
      if (!from.empty())
        to.assign(from.begin() + static_cast<std::ptrdiff_t>(first),
                  from.begin() + static_cast<std::ptrdiff_t>(first + size));
    };
    cut(part.directions, list.directions);
    cut(part.origins, list.origins);
    cut(part.rings, list.rings);
    cut(part.rangeMin, list.rangeMin);
    cut(part.rangeMax, list.rangeMax);
    cut(part.times, list.times);
    if (!timed) spreadOver(part, rate);
    const double start = *std::min_element(part.times.begin(), part.times.end());
    for (double& time : part.times) time -= start;
  }
  if (count % size > 0) source.ignore("the last " + std::to_string(count % size) + " beams, which fill no scan");
}

std::vector<std::string_view> linesOf(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    lines.push_back(line);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

std::vector<std::string_view> cellsOf(std::string_view line) {
  std::vector<std::string_view> cells;
  for (;;) {
    const size_t end = std::min(line.find(','), line.size());
    cells.push_back(trimmed(line.substr(0, end), " \t"));
    if (end == line.size()) return cells;
    line.remove_prefix(end + 1);
  }
}

std::string shownNumber(double value) {
  if (value == std::floor(value) && std::abs(value) < 1e15) return std::to_string(static_cast<long long>(value));
  return numberText(value);
}

void refuseSurplus(const SensorSource& source, const std::vector<std::string_view>& cells, size_t expected,
                   const std::string& where) {
  for (size_t i = expected; i < cells.size(); ++i)
    if (!cells[i].empty())
      source.refuse(where + " has " + std::to_string(cells.size()) + " cells, expected are " +
                    std::to_string(expected) + "; decimals need a point, not a comma");
}

double numberOf(const SensorSource& source, std::string_view text, const std::string& where) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (problem != std::errc() || end != text.data() + text.size())
    source.refuse(where + " is '" + std::string(text.substr(0, 40)) + "', expected is a number");
  if (!std::isfinite(value)) source.refuse(where + " is '" + std::string(text) + "', expected is a finite number");
  return value;
}

namespace {

/// A JSON value for a message. A list or an object is only named, because it could be of any size.
std::string briefly(const json& value) {
  if (value.is_array()) return "a list";
  if (value.is_object()) return "an object";
  return jsonText(value).substr(0, 40);
}

}  // namespace

double numberIn(const SensorSource& source, const json& object, const std::string& key) {
  const auto found = object.find(key);
  if (found == object.end()) source.refuse("'" + key + "' is missing");
  if (!found->is_number()) source.refuse("'" + key + "' is " + briefly(*found) + ", expected is a number");
  return found->get<double>();
}

double numberIn(const SensorSource& source, const json& object, const std::string& key, double otherwise) {
  return object.contains(key) ? numberIn(source, object, key) : otherwise;
}

std::vector<double> numbersIn(const SensorSource& source, const json& object, const std::string& key) {
  const auto found = object.find(key);
  if (found == object.end()) source.refuse("'" + key + "' is missing");
  if (!found->is_array()) source.refuse("'" + key + "' is not a list of numbers");
  std::vector<double> list;
  list.reserve(found->size());
  for (const json& value : *found) {
    if (!value.is_number())
      source.refuse("'" + key + "' has " + briefly(value) + " at place " + std::to_string(list.size()) +
                    ", expected is a number");
    list.push_back(value.get<double>());
  }
  return list;
}

}  // namespace gnosphere
