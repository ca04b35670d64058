// SPDX-License-Identifier: Apache-2.0
// {"name": "...", "columns": N, "range": {"min": m, "max": m}, "elevation_deg": [...], "azimuth_offset_deg": [...]}
// The offsets may be left out, and "channels": [{"elevation_deg": d, "azimuth_offset_deg": d}, ...] may stand for both
// lists. toJson() writes the lists.
#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <initializer_list>
#include <nlohmann/json.hpp>

#include "gnosphere/error.hpp"
#include "gnosphere/sensor.hpp"

namespace gnosphere {
namespace {

using nlohmann::json;

/// The JSON under work, for messages: "FILE: 'range' ...".
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

std::vector<Channel> channelsFromLists(const Source& source, const json& root) {
  const auto elevations = numbers(source, member(source, root, "the sensor", "elevation_deg"), "elevation_deg");
  std::vector<double> offsets(elevations.size(), 0.0);
  if (const auto found = root.find("azimuth_offset_deg"); found != root.end()) {
    offsets = numbers(source, *found, "azimuth_offset_deg");
  }
  if (offsets.size() != elevations.size()) {
    source.refuse("'elevation_deg' has " + std::to_string(elevations.size()) + " entries, 'azimuth_offset_deg' has " +
                  std::to_string(offsets.size()) + "; there must be one per channel in both");
  }
  std::vector<Channel> channels;
  for (size_t j = 0; j < elevations.size(); ++j) channels.push_back({elevations[j], offsets[j]});
  return channels;
}

std::vector<Channel> channelsFromObjects(const Source& source, const json& root) {
  for (const char* key : {"elevation_deg", "azimuth_offset_deg"}) {
    if (root.contains(key)) source.refuse("'channels' and '" + std::string(key) + "' say the same thing; keep one");
  }
  const json& list = root["channels"];
  if (!list.is_array()) source.refuse("'channels' must be a list");
  std::vector<Channel> channels;
  for (size_t j = 0; j < list.size(); ++j) {
    const std::string where = "channels[" + std::to_string(j) + "]";
    if (!list[j].is_object()) source.refuse("'" + where + "' must be an object");
    checkKeys(source, list[j], where, {"elevation_deg", "azimuth_offset_deg"});
    Channel channel;
    channel.elevationDeg = number(source, member(source, list[j], where, "elevation_deg"), where + ".elevation_deg");
    if (const auto offset = list[j].find("azimuth_offset_deg"); offset != list[j].end()) {
      channel.azimuthOffsetDeg = number(source, *offset, where + ".azimuth_offset_deg");
    }
    channels.push_back(channel);
  }
  return channels;
}

Sensor sensorFromRoot(const Source& source, const json& root) {
  if (!root.is_object()) source.refuse("a sensor is a JSON object");
  checkKeys(source, root, "the sensor",
            {"name", "columns", "range", "elevation_deg", "azimuth_offset_deg", "channels"});
  Sensor sensor;
  const json& name = member(source, root, "the sensor", "name");
  if (!name.is_string()) source.refuse("'name' must be a text");
  sensor.name = name.get<std::string>();

  const json& columns = member(source, root, "the sensor", "columns");
  if (!columns.is_number_unsigned() || columns.get<uint64_t>() > 0xffffffffu) {
    source.refuse("'columns' must be a whole number from 1 to 4294967295");
  }
  sensor.columns = columns.get<uint32_t>();

  const json& range = member(source, root, "the sensor", "range");
  if (!range.is_object()) source.refuse("'range' must be an object with 'min' and 'max'");
  checkKeys(source, range, "range", {"min", "max"});
  if (range.contains("min")) sensor.rangeMin = number(source, range["min"], "range.min");
  sensor.rangeMax = number(source, member(source, range, "range", "max"), "range.max");

  sensor.channels = root.contains("channels") ? channelsFromObjects(source, root) : channelsFromLists(source, root);
  return sensor;
}

/// Shortest text that reads back to the same bits. JSON readers take "-0" for the integer 0, so that one has a point.
std::string text(double value) {
  if (value == 0 && std::signbit(value)) return "-0.0";
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof(buffer), value).ptr};
}

template <class Get>
std::string listText(const std::vector<Channel>& channels, Get get) {
  constexpr size_t kLineWidth = 100;
  std::string all = "[";
  std::string line;
  for (size_t j = 0; j < channels.size(); ++j) {
    const std::string word = text(get(channels[j])) + (j + 1 < channels.size() ? ", " : "");
    if (line.size() + word.size() > kLineWidth) {
      all += "\n    " + line.substr(0, line.find_last_not_of(' ') + 1);
      line.clear();
    }
    line += word;
  }
  if (all.size() == 1) return all + line + "]";
  return all + "\n    " + line + "\n  ]";
}

}  // namespace

std::string toJson(const Sensor& sensor) {
  validate(sensor);
  std::string name;
  try {
    name = json(sensor.name).dump();
  } catch (const json::exception&) {
    throw Error(ErrorCode::invalidArgument, "the sensor's name is not UTF-8, JSON cannot hold it");
  }
  std::string out =
      "{\n  \"name\": " + name + ",\n  \"columns\": " + std::to_string(sensor.columns) +
      ",\n  \"range\": {\"min\": " + text(sensor.rangeMin) + ", \"max\": " + text(sensor.rangeMax) +
      "},\n  \"elevation_deg\": " + listText(sensor.channels, [](const Channel& c) { return c.elevationDeg; });
  const bool offsets = std::any_of(sensor.channels.begin(), sensor.channels.end(),
                                   [](const Channel& c) { return std::bit_cast<uint64_t>(c.azimuthOffsetDeg) != 0; });
  if (offsets) {
    out += ",\n  \"azimuth_offset_deg\": " +
           listText(sensor.channels, [](const Channel& c) { return c.azimuthOffsetDeg; });
  }
  return out + "\n}\n";
}

Sensor sensorFromJson(std::string_view text, const std::string& source) {
  Sensor sensor;
  try {
    sensor = sensorFromRoot({source}, json::parse(text));
    validate(sensor);
  } catch (const json::exception& problem) {
    // "[json.exception.parse_error.101] parse error at line 1, ...": the part for people comes after the bracket.
    const std::string what = problem.what();
    const size_t bracket = what.find("] ");
    throw Error(ErrorCode::format, source + ": is not JSON: " + what.substr(bracket == what.npos ? 0 : bracket + 2));
  } catch (const Error& problem) {
    if (problem.code() != ErrorCode::invalidArgument) throw;
    throw Error(ErrorCode::format, source + ": " + problem.what());
  }
  return sensor;
}

}  // namespace gnosphere
