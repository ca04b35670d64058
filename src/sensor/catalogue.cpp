// SPDX-License-Identifier: Apache-2.0
// Built-in sensors: the five of the paper, and real heads.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "base/lasting.hpp"
#include "base/nearest_text.hpp"
#include "base/text.hpp"
#include "base/units.hpp"
#include "gnosphere/error.hpp"
#include "gnosphere/sensor.hpp"
#include "sensor/catalogue_heads.hpp"
#include "sensor/catalogue_lists.hpp"

namespace gnosphere {
namespace {

/// Sensors of Table 2 of the GnoSphere360 paper: elevations are evenly spaced, both ends included. Every angle is
/// rounded once, so a model that is symmetric about the horizon has exactly opposite channels.
Sensor evenSensor(const char* name, double lowestDeg, double highestDeg, uint32_t columns, uint32_t channels,
                  double rangeMax) {
  Sensor sensor;
  sensor.name = name;
  sensor.columns = columns;
  sensor.rangeMax = rangeMax;
  const double last = channels - 1;
  for (uint32_t j = 0; j < channels; ++j) {
    sensor.channels.push_back({(lowestDeg * (last - j) + highestDeg * j) / last, 0.0});
  }
  return sensor;
}

/// Splits a text at spaces.
std::vector<std::string> wordsOf(std::string_view text) {
  std::vector<std::string> words;
  while (!text.empty()) {
    const size_t end = std::min(text.find(' '), text.size());
    if (end > 0) words.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return words;
}

double numberAt(std::string_view text) {
  double value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

/// The numbers of a list of HeadFigures, repeated to `count` of them if `count` is not 0.
std::vector<double> numbersOf(const char* text, size_t count) {
  std::vector<double> numbers;
  for (const std::string& word : wordsOf(text)) {
    const std::string_view w = word;
    const size_t dots = w.find(".."), slash = w.find('/');
    if (dots == w.npos) {
      numbers.push_back(numberAt(w));
      continue;
    }
    const double first = numberAt(w.substr(0, dots)), last = numberAt(w.substr(dots + 2, slash - dots - 2));
    const double steps = numberAt(w.substr(slash + 1)) - 1;
    for (double i = 0; i <= steps; ++i) numbers.push_back((first * (steps - i) + last * i) / steps);
  }
  if (numbers.empty()) numbers.push_back(0);
  const size_t given = numbers.size();
  for (size_t i = given; i < count; ++i) numbers.push_back(numbers[i - given]);
  return numbers;
}

/// The scans of a mode in a second.
double rateOf(std::string_view mode) {
  const size_t x = mode.find('x');
  return numberAt(x == mode.npos ? mode : mode.substr(x + 1));
}

/// Sets the columns, the sector and the periods that a mode of a head has.
void setMode(const HeadFigures& figures, std::string_view mode, Sensor& sensor) {
  const size_t x = mode.find('x');
  const double rate = rateOf(mode);
  sensor.azimuthStartDeg = figures.startDeg;
  sensor.azimuthSpanDeg = figures.spanDeg;
  if (x != mode.npos) {
    sensor.columns = static_cast<uint32_t>(numberAt(mode.substr(0, x)));
    // Another mode sweeps further or less far in its columns, as the head turns faster or slower.
    const std::string first = wordsOf(figures.modes)[0];
    if (figures.cycle > 0)
      sensor.azimuthSpanDeg *= sensor.columns * rate / (numberAt(first.substr(0, first.find('x'))) * rateOf(first));
    sensor.rotationPeriod = figures.cycle > 0 ? kMicro * figures.cycle * sensor.columns : 1 / rate;
    return;
  }
  // A turn need not be a whole number of columns: it ends a little before its start.
  const double cycle = kMicro * figures.cycle;
  const double columns = std::floor(1 / (rate * cycle) + 1e-4);
  sensor.columns = static_cast<uint32_t>(columns);
  sensor.rotationPeriod = columns * cycle;
  sensor.azimuthSpanDeg = std::clamp(figures.spanDeg * sensor.rotationPeriod * rate, -360.0, 360.0);
}

Sensor sensorOf(const HeadFigures& figures, std::string_view mode) {
  Sensor sensor;
  setMode(figures, mode, sensor);
  if (const double period = 1 / rateOf(mode); sensor.rotationPeriod < period) sensor.scanPeriod = period;
  sensor.rangeMin = figures.rangeMin;
  sensor.rangeMax = figures.rangeMax;
  sensor.rangeAt10Percent = figures.rangeAt10Percent;
  const std::vector<double> divergence = numbersOf(figures.divergence, 2);
  sensor.divergenceHorizontal = kMilli * divergence[0];
  sensor.divergenceVertical = kMilli * divergence[1];
  sensor.maxReturns = figures.returns;
  const std::vector<double> elevations = numbersOf(figures.elevations, 0);
  const size_t count = elevations.size();
  const auto azimuths = numbersOf(figures.azimuthOffsets, count), times = numbersOf(figures.times, count);
  const auto left = numbersOf(figures.left, count), up = numbersOf(figures.up, count);
  const auto rests = numbersOf(figures.rests, count);
  const double degreesPerSecond = sensor.azimuthSpanDeg / sensor.rotationPeriod;
  for (size_t i = 0; i < count; ++i) {
    Channel channel{elevations[i], azimuths[i]};
    channel.origin = {kMilli * figures.radius * std::cos(kDegree * azimuths[i]),
                      kMilli * (left[i] - figures.radius * std::sin(kDegree * azimuths[i])), kMilli * up[i]};
    if (figures.tilted) {
      const double elevation = kDegree * elevations[i];
      channel.origin.x -= kMilli * up[i] * std::sin(elevation);
      channel.origin.z = kMilli * up[i] * std::cos(elevation);
    }
    channel.timeOffset = kMicro * times[i];
    channel.azimuthOffsetDeg += degreesPerSecond * channel.timeOffset;  // the head turns on
    sensor.channels.push_back(channel);
    // Heads whose lasers rest in some columns keep the order of the lists.
    for (uint32_t column = rests[i] == 1 ? 0 : 1; rests[i] > 0 && column < sensor.columns; column += 2)
      sensor.maskedBeams.push_back(static_cast<uint32_t>(i) * sensor.columns + column);
  }
  if (figures.fromBelow)
    std::stable_sort(sensor.channels.begin(), sensor.channels.end(),
                     [](const Channel& a, const Channel& b) { return a.elevationDeg < b.elevationDeg; });
  return sensor;
}

CatalogueHead headOf(const HeadFigures& figures) {
  return {figures.name,   figures.product, wordsOf(figures.modes),
          figures.source, figures.remarks, figures.rangeAt10Percent};
}

}  // namespace

const std::vector<Sensor>& builtinSensors() {
  static const auto& sensors = lasting(std::vector<Sensor>{
      evenSensor("VLP-16", -15, 15, 1800, 16, 100),
      evenSensor("VLP-32", -25, 15, 3600, 32, 100),
      evenSensor("HDL-64E", -25, 2, 4500, 64, 120),
      evenSensor("Hypothetical-256", -45, 45, 18000, 256, 200),
      evenSensor("Hypothetical-350", -45, 45, 18000, 350, 200),
  });
  return sensors;
}

const std::vector<CatalogueHead>& sensorCatalogue() {
  static const auto& heads = lasting([] {
    std::vector<CatalogueHead> list;
    for (const HeadFigures& figures : kHeads) list.push_back(headOf(figures));
    for (CatalogueHead& head : listHeads()) list.push_back(std::move(head));
    return list;
  }());
  return heads;
}

Sensor builtinSensor(const std::string& name) {
  const size_t colon = std::min(name.find(':'), name.size());
  const std::string bare = name.substr(0, colon), mode = colon < name.size() ? name.substr(colon + 1) : "";
  std::vector<std::string> names;
  for (const Sensor& sensor : builtinSensors()) {
    if (sameWord(sensor.name, name)) return sensor;
    if (sameWord(sensor.name, bare))
      throw Error(ErrorCode::invalidArgument, "the sensor " + sensor.name +
                                                  " is an ideal head of the paper and has no modes, so '" + name +
                                                  "' is none; leave out ':" + mode + "'");
    names.push_back(sensor.name);
  }
  for (const CatalogueHead& head : sensorCatalogue()) {
    names.push_back(head.name);
    if (!sameWord(head.name, bare)) continue;
    std::string modes;
    for (const std::string& known : head.modes) {
      modes += (modes.empty() ? "" : ", ") + known;
      if (colon < name.size() && !sameWord(known, mode)) continue;
      const auto figures = std::find_if(std::begin(kHeads), std::end(kHeads),
                                        [&](const HeadFigures& candidate) { return head.name == candidate.name; });
      Sensor sensor = figures == std::end(kHeads) ? listHead(head.name) : sensorOf(*figures, known);
      sensor.name = head.name + (head.modes.size() > 1 ? ":" + known : "");
      return sensor;
    }
    throw Error(ErrorCode::invalidArgument, "the sensor " + head.name + " has no mode '" + mode + "', but " + modes);
  }
  throw Error(ErrorCode::invalidArgument, "no built-in sensor is called '" + name + "'; " +
                                              nearestText(bare, std::move(names)) + "; gnosphere sensors lists all");
}

}  // namespace gnosphere
