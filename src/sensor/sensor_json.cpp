// SPDX-License-Identifier: Apache-2.0
// {"name": "...", "columns": N, "range": {"min": m, "max": m}, "range_at_10_percent": m, "divergence_mrad": [h, v],
//  "max_returns": N, "rotation_period": s, "scan_period": s, "elevation_deg": [...], "azimuth_offset_deg": [...],
//  "origin": [[x, y, z], ...], "time_offset": [...], "range_min": [...], "range_max": [...], "azimuth_start_deg": d,
//  "azimuth_span_deg": d, "near_hits": "hide", "masked_beams": [...]}
// Required are the name, columns, range and elevations. Instead of the lists, "channels": [{"elevation_deg": d,
// "azimuth_offset_deg": d, "origin": [x, y, z], "time_offset": s, "range_min": m, "range_max": m}, ...] may be given.
// Instead of columns and channels, a sensor has "patterns": [{"width": N, "height": N, "directions": [[x, y, z], ...],
// "origins": [[x, y, z], ...], "times": [...], "range_min": [...], "range_max": [...], "rings": [...]}, ...]. Instead
// of directions, a pattern may have "azimuth_deg": [...] and "elevation_deg": [...]. toJson() writes the lists, and
// leaves out all that has its default.
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/json_text.hpp"
#include "base/limits.hpp"
#include "base/text.hpp"
#include "base/units.hpp"
#include "gnosphere/error.hpp"
#include "gnosphere/sensor.hpp"
#include "sensor/beams.hpp"
#include "sensor/carla_lidars.hpp"

namespace gnosphere {
namespace {

using nlohmann::json;

/// The name of the JSON that is read, for messages such as "FILE: 'range' ...".
struct Source {
  const std::string& name;
  [[noreturn]] void refuse(const std::string& why) const { throw Error(ErrorCode::format, name + ": " + why); }
};

void checkKeys(const Source& source, const json& object, const std::string& where,
               std::initializer_list<std::string_view> known) {
  for (const auto& [key, value] : object.items()) {
    if (std::find(known.begin(), known.end(), std::string_view(key)) != known.end()) continue;
    std::string list;
    for (std::string_view k : known) list.append(list.empty() ? "" : ", ").append(k);
    source.refuse("unknown key '" + key + "' in " + where + "; known are " + list);
  }
}

const json& member(const Source& source, const json& object, std::string_view where, const char* key) {
  const auto found = object.find(key);
  if (found == object.end()) source.refuse(std::string("'").append(key).append("' is missing in ").append(where));
  return *found;
}

double number(const Source& source, const json& value, const std::string& what) {
  if (!value.is_number()) source.refuse("'" + what + "' must be a number");
  return value.get<double>();
}

std::vector<double> numbers(const Source& source, const json& value, const std::string& what) {
  if (!value.is_array()) source.refuse("'" + what + "' must be a list of numbers");
  std::vector<double> list;
  list.reserve(value.size());
  for (size_t j = 0; j < value.size(); ++j) {
    list.push_back(number(source, value[j], what + "[" + std::to_string(j) + "]"));
  }
  return list;
}

/// Reads a list of exactly `count` numbers.
std::vector<double> numbers(const Source& source, const json& value, const std::string& what, size_t count) {
  const std::vector<double> list = numbers(source, value, what);
  if (list.size() != count) {
    source.refuse("'" + what + "' must be " + std::to_string(count) + " numbers, has " + std::to_string(list.size()));
  }
  return list;
}

Vec3 vector(const Source& source, const json& value, const std::string& what) {
  const std::vector<double> list = numbers(source, value, what, 3);
  return {list[0], list[1], list[2]};
}

/// Calls read(channel, entry, "KEY[j]") for the entries of an optional list that has one entry per channel.
template <class Read>
void eachChannel(const Source& source, const json& root, const std::string& key, std::vector<Channel>& channels,
                 Read read) {
  const auto found = root.find(key);
  if (found == root.end()) return;
  if (!found->is_array()) source.refuse("'" + key + "' must be a list, one entry per channel");
  if (found->size() != channels.size()) {
    source.refuse("'elevation_deg' has " + std::to_string(channels.size()) + " entries, '" + key + "' has " +
                  std::to_string(found->size()) + "; there must be one per channel in both");
  }
  for (size_t j = 0; j < channels.size(); ++j) read(channels[j], (*found)[j], key + "[" + std::to_string(j) + "]");
}

/// The key of an optional number, and the member that it sets.
template <typename Object>
struct NumberKey {
  const char* key;
  double Object::*member;
};
constexpr NumberKey<Channel> kChannelNumbers[] = {{"azimuth_offset_deg", &Channel::azimuthOffsetDeg},
                                                  {"time_offset", &Channel::timeOffset},
                                                  {"range_min", &Channel::rangeMin},
                                                  {"range_max", &Channel::rangeMax}};
constexpr NumberKey<Sensor> kSensorNumbers[] = {{"rotation_period", &Sensor::rotationPeriod},
                                                {"scan_period", &Sensor::scanPeriod},
                                                {"range_at_10_percent", &Sensor::rangeAt10Percent},
                                                {"azimuth_start_deg", &Sensor::azimuthStartDeg},
                                                {"azimuth_span_deg", &Sensor::azimuthSpanDeg}};

template <typename Object, size_t kCount>
void readNumbers(const Source& source, const json& from, const std::string& prefix,
                 const NumberKey<Object> (&keys)[kCount], Object& to) {
  for (const auto& [key, member] : keys)
    if (const auto found = from.find(key); found != from.end()) to.*member = number(source, *found, prefix + key);
}

std::vector<Channel> channelsFromLists(const Source& source, const json& root) {
  std::vector<Channel> channels;
  for (double elevation : numbers(source, member(source, root, "the sensor", "elevation_deg"), "elevation_deg")) {
    channels.push_back({elevation});
  }
  for (const NumberKey<Channel>& of : kChannelNumbers)
    eachChannel(source, root, of.key, channels,
                [&](Channel& c, const json& v, const std::string& what) { c.*of.member = number(source, v, what); });
  eachChannel(source, root, "origin", channels,
              [&](Channel& c, const json& v, const std::string& what) { c.origin = vector(source, v, what); });
  return channels;
}

std::vector<Channel> channelsFromObjects(const Source& source, const json& root) {
  const std::initializer_list<std::string_view> keys = {"elevation_deg", "azimuth_offset_deg", "origin",
                                                        "time_offset",   "range_min",          "range_max"};
  for (const std::string_view key : keys)
    if (root.contains(std::string(key)))
      source.refuse("'channels' and '" + std::string(key) + "' are alternatives; keep one");
  const json& list = root["channels"];
  if (!list.is_array()) source.refuse("'channels' must be a list");
  std::vector<Channel> channels;
  for (size_t j = 0; j < list.size(); ++j) {
    const std::string where = "channels[" + std::to_string(j) + "]";
    if (!list[j].is_object()) source.refuse("'" + where + "' must be an object");
    checkKeys(source, list[j], where, keys);
    Channel channel;
    channel.elevationDeg = number(source, member(source, list[j], where, "elevation_deg"), where + ".elevation_deg");
    readNumbers(source, list[j], where + ".", kChannelNumbers, channel);
    if (const auto origin = list[j].find("origin"); origin != list[j].end())
      channel.origin = vector(source, *origin, where + ".origin");
    channels.push_back(channel);
  }
  return channels;
}

/// A whole number from 0 to `most`, also one that is written as 100.0.
uint32_t whole(const Source& source, const json& value, const std::string& what, uint32_t most, uint32_t least = 0) {
  const double number = value.is_number() ? value.get<double>() : -1;
  if (!(number >= least && number <= most) || number != std::floor(number))
    source.refuse("'" + what + "' must be a whole number from " + std::to_string(least) + " to " +
                  std::to_string(most));
  return static_cast<uint32_t>(number);
}

/// Reads the optional properties that are numbers.
void readFigures(const Source& source, const json& root, Sensor& sensor) {
  if (const auto divergence = root.find("divergence_mrad"); divergence != root.end()) {
    const std::vector<double> angles = numbers(source, *divergence, "divergence_mrad", 2);
    sensor.divergenceHorizontal = angles[0] / kMilliPerUnit;
    sensor.divergenceVertical = angles[1] / kMilliPerUnit;
  }
  if (const auto returns = root.find("max_returns"); returns != root.end())
    sensor.maxReturns = whole(source, *returns, "max_returns", limits::kReturns.most, 1);
  readNumbers(source, root, "", kSensorNumbers, sensor);
}

template <typename T>
std::vector<T> wholes(const Source& source, const json& value, const std::string& what) {
  if (!value.is_array()) source.refuse("'" + what + "' must be a list of whole numbers");
  std::vector<T> list;
  for (size_t i = 0; i < value.size(); ++i)
    list.push_back(
        static_cast<T>(whole(source, value[i], what + "[" + std::to_string(i) + "]", std::numeric_limits<T>::max())));
  return list;
}

std::vector<Vec3> vectors(const Source& source, const json& value, const std::string& what) {
  if (!value.is_array()) source.refuse("'" + what + "' must be a list of [x, y, z]");
  std::vector<Vec3> list;
  for (size_t i = 0; i < value.size(); ++i)
    list.push_back(vector(source, value[i], what + "[" + std::to_string(i) + "]"));
  return list;
}

std::vector<float> floats(const Source& source, const json& value, const std::string& what) {
  std::vector<float> list;
  for (const double number : numbers(source, value, what)) {
    if (!(std::abs(number) <= std::numeric_limits<float>::max()))
      source.refuse("'" + what + "' has " + numberText(number) + ", which is no range");
    list.push_back(static_cast<float>(number));
  }
  return list;
}

/// Reads the directions of a pattern: unit vectors, or azimuths, counter-clockwise from x, and elevations.
std::vector<Vec3> directionsOf(const Source& source, const json& pattern, const std::string& where) {
  const bool asAngles = pattern.contains("azimuth_deg") || pattern.contains("elevation_deg");
  if (pattern.contains("directions")) {
    if (asAngles)
      source.refuse("'directions' of " + where +
                    " and its 'azimuth_deg' and 'elevation_deg' are alternatives; keep one");
    return vectors(source, pattern["directions"], where + ".directions");
  }
  if (!asAngles) source.refuse("'directions', or 'azimuth_deg' and 'elevation_deg', is missing in " + where);
  const auto anglesOf = [&](const char* key, double most) {
    const std::string what = where + "." + key;
    std::vector<double> angles = numbers(source, member(source, pattern, where, key), what);
    for (size_t i = 0; i < angles.size(); ++i)
      if (!(std::abs(angles[i]) <= most))
        source.refuse("'" + what + "[" + std::to_string(i) + "]' must be within -" + numberText(most) + ".." +
                      numberText(most) + " degrees, is " + numberText(angles[i]));
    return angles;
  };
  const std::vector<double> azimuths = anglesOf("azimuth_deg", 720), elevations = anglesOf("elevation_deg", 90);
  if (azimuths.size() != elevations.size())
    source.refuse("'azimuth_deg' of " + where + " has " + std::to_string(azimuths.size()) +
                  " entries, its 'elevation_deg' has " + std::to_string(elevations.size()) +
                  "; there must be one per beam in both");
  std::vector<Vec3> directions;
  directions.reserve(azimuths.size());
  for (size_t i = 0; i < azimuths.size(); ++i) directions.push_back(unitVectorAt(azimuths[i], elevations[i]));
  return directions;
}

std::vector<BeamList> patternsOf(const Source& source, const json& list) {
  if (!list.is_array() || list.empty()) source.refuse("'patterns' must be a list of patterns, with one at least");
  std::vector<BeamList> patterns;
  for (size_t i = 0; i < list.size(); ++i) {
    const json& entry = list[i];
    const std::string where = "patterns[" + std::to_string(i) + "]";
    if (!entry.is_object()) source.refuse("'" + where + "' must be an object");
    checkKeys(source, entry, where,
              {"width", "height", "directions", "azimuth_deg", "elevation_deg", "origins", "times", "range_min",
               "range_max", "rings"});
    const auto read = [&](const char* key, auto reader, auto& to) {
      if (const auto found = entry.find(key); found != entry.end()) to = reader(source, *found, where + "." + key);
    };
    BeamList& pattern = patterns.emplace_back();
    pattern.directions = directionsOf(source, entry, where);
    read("origins", vectors, pattern.origins);
    read(
        "times", [](const auto&... all) { return numbers(all...); }, pattern.times);
    read("range_min", floats, pattern.rangeMin);
    read("range_max", floats, pattern.rangeMax);
    read("rings", wholes<uint16_t>, pattern.rings);
    const auto size = [](const Source& from, const json& value, const std::string& what) {
      return whole(from, value, what, 0xffffffffu);
    };
    read("width", size, pattern.width);
    read("height", size, pattern.height);
  }
  return patterns;
}

/// Reads which beams never fire, and what near surfaces do.
void readSilence(const Source& source, const json& root, Sensor& sensor) {
  if (const auto masked = root.find("masked_beams"); masked != root.end())
    sensor.maskedBeams = wholes<uint32_t>(source, *masked, "masked_beams");
  const auto near = root.find("near_hits");
  if (near == root.end()) return;
  const bool hide = isText(*near, "hide");
  if (!hide && !isText(*near, "see_through")) source.refuse("'near_hits' must be \"hide\" or \"see_through\"");
  sensor.nearHits = hide ? NearHits::hide : NearHits::seeThrough;
}

/// Reads columns and channels of a grid.
void readGrid(const Source& source, const json& root, Sensor& sensor) {
  sensor.columns = whole(source, member(source, root, "the sensor", "columns"), "columns", 0xffffffffu);
  const bool asObjects = root.contains("channels");
  sensor.channels = asObjects ? channelsFromObjects(source, root) : channelsFromLists(source, root);
  if (sensor.channels.empty())
    source.refuse(std::string("'") + (asObjects ? "channels" : "elevation_deg") +
                  "' is empty; a sensor has one channel at least");
}

Sensor sensorFromRoot(const Source& source, const json& root) {
  if (!root.is_object()) source.refuse("a sensor is a JSON object");
  checkKeys(source, root, "the sensor",
            {"name",
             "columns",
             "range",
             "range_at_10_percent",
             "divergence_mrad",
             "max_returns",
             "rotation_period",
             "scan_period",
             "elevation_deg",
             "azimuth_offset_deg",
             "origin",
             "time_offset",
             "range_min",
             "range_max",
             "channels",
             "azimuth_start_deg",
             "azimuth_span_deg",
             "near_hits",
             "masked_beams",
             "patterns"});
  Sensor sensor;
  const json& name = member(source, root, "the sensor", "name");
  if (!name.is_string()) source.refuse("'name' must be a text");
  sensor.name = name.get<std::string>();

  const json& range = member(source, root, "the sensor", "range");
  if (!range.is_object()) source.refuse("'range' must be an object with 'min' and 'max'");
  checkKeys(source, range, "range", {"min", "max"});
  if (range.contains("min")) sensor.rangeMin = number(source, range["min"], "range.min");
  sensor.rangeMax = number(source, member(source, range, "range", "max"), "range.max");

  readFigures(source, root, sensor);
  readSilence(source, root, sensor);
  const auto patterns = root.find("patterns");
  if (patterns == root.end()) {
    readGrid(source, root, sensor);
    return sensor;
  }
  for (const char* key : {"columns", "elevation_deg", "azimuth_offset_deg", "origin", "time_offset", "range_min",
                          "range_max", "channels"})
    if (root.contains(key)) source.refuse("'patterns' and '" + std::string(key) + "' are alternatives; keep one");
  sensor.patterns = patternsOf(source, *patterns);
  return sensor;
}

}  // namespace

Sensor sensorFromJson(std::string_view text, const std::string& source) {
  Sensor sensor;
  try {
    const json root = parseStrict(text, source);
    if (lacksCarlaType(root)) Source{source}.refuse(kLacksCarlaType);
    sensor = sensorFromRoot({source}, root);
    validate(sensor);
  } catch (const Error& problem) {
    if (problem.code() != ErrorCode::invalidArgument) throw;
    throw Error(ErrorCode::format, source + ": " + problem.what());
  }
  return sensor;
}

}  // namespace gnosphere
