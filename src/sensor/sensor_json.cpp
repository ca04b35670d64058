// SPDX-License-Identifier: Apache-2.0
// {"name": "...", "columns": N, "range": {"min": m, "max": m}, "divergence_mrad": [h, v], "max_returns": N,
//  "rotation_period": s, "elevation_deg": [...], "azimuth_offset_deg": [...], "origin": [[x, y, z], ...],
//  "time_offset": [...]}
// Required are the name, columns, range and elevations. Instead of the lists, "channels": [{"elevation_deg": d,
// "azimuth_offset_deg": d, "origin": [x, y, z], "time_offset": s}, ...] may be given. toJson() writes the lists, and
// leaves out all that is 0.
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

std::vector<Channel> channelsFromLists(const Source& source, const json& root) {
  std::vector<Channel> channels;
  for (double elevation : numbers(source, member(source, root, "the sensor", "elevation_deg"), "elevation_deg")) {
    channels.push_back({elevation});
  }
  eachChannel(source, root, "azimuth_offset_deg", channels, [&](Channel& c, const json& v, const std::string& what) {
    c.azimuthOffsetDeg = number(source, v, what);
  });
  eachChannel(source, root, "origin", channels,
              [&](Channel& c, const json& v, const std::string& what) { c.origin = vector(source, v, what); });
  eachChannel(source, root, "time_offset", channels,
              [&](Channel& c, const json& v, const std::string& what) { c.timeOffset = number(source, v, what); });
  return channels;
}

std::vector<Channel> channelsFromObjects(const Source& source, const json& root) {
  for (const char* key : {"elevation_deg", "azimuth_offset_deg", "origin", "time_offset"}) {
    if (root.contains(key)) source.refuse("'channels' and '" + std::string(key) + "' are alternatives; keep one");
  }
  const json& list = root["channels"];
  if (!list.is_array()) source.refuse("'channels' must be a list");
  std::vector<Channel> channels;
  for (size_t j = 0; j < list.size(); ++j) {
    const std::string where = "channels[" + std::to_string(j) + "]";
    if (!list[j].is_object()) source.refuse("'" + where + "' must be an object");
    checkKeys(source, list[j], where, {"elevation_deg", "azimuth_offset_deg", "origin", "time_offset"});
    Channel channel;
    channel.elevationDeg = number(source, member(source, list[j], where, "elevation_deg"), where + ".elevation_deg");
    if (const auto offset = list[j].find("azimuth_offset_deg"); offset != list[j].end()) {
      channel.azimuthOffsetDeg = number(source, *offset, where + ".azimuth_offset_deg");
    }
    if (const auto origin = list[j].find("origin"); origin != list[j].end()) {
      channel.origin = vector(source, *origin, where + ".origin");
    }
    if (const auto offset = list[j].find("time_offset"); offset != list[j].end()) {
      channel.timeOffset = number(source, *offset, where + ".time_offset");
    }
    channels.push_back(channel);
  }
  return channels;
}

constexpr double kMilli = 1000;

/// Reads the optional properties beyond geometry.
void readPulses(const Source& source, const json& root, Sensor& sensor) {
  if (const auto divergence = root.find("divergence_mrad"); divergence != root.end()) {
    const std::vector<double> angles = numbers(source, *divergence, "divergence_mrad", 2);
    sensor.divergenceHorizontal = angles[0] / kMilli;
    sensor.divergenceVertical = angles[1] / kMilli;
  }
  if (const auto returns = root.find("max_returns"); returns != root.end()) {
    if (!returns->is_number_unsigned() || returns->get<uint64_t>() > 5) {
      source.refuse("'max_returns' must be a whole number from 1 to 5");
    }
    sensor.maxReturns = returns->get<uint32_t>();
  }
  if (const auto period = root.find("rotation_period"); period != root.end()) {
    sensor.rotationPeriod = number(source, *period, "rotation_period");
  }
}

Sensor sensorFromRoot(const Source& source, const json& root) {
  if (!root.is_object()) source.refuse("a sensor is a JSON object");
  checkKeys(source, root, "the sensor",
            {"name", "columns", "range", "divergence_mrad", "max_returns", "rotation_period", "elevation_deg",
             "azimuth_offset_deg", "origin", "time_offset", "channels"});
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

  readPulses(source, root, sensor);
  sensor.channels = root.contains("channels") ? channelsFromObjects(source, root) : channelsFromLists(source, root);
  return sensor;
}

/// Returns the shortest text that reads back to the same bits. JSON readers take "-0" for the integer 0, hence "-0.0".
std::string text(double value) {
  if (value == 0 && std::signbit(value)) return "-0.0";
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof(buffer), value).ptr};
}

std::string text(const Vec3& v) {
  return std::string("[").append(text(v.x)).append(", ").append(text(v.y)).append(", ").append(text(v.z)).append("]");
}

/// Returns the milliradians that divided by 1000 give the same radians: the product or one of its neighbours, in case
/// rounding went the other way. (If none does, no double does, and the last bit is lost.)
double milliradians(double radians) {
  const double product = radians * kMilli;
  for (double candidate : {product, std::nextafter(product, 0.0), std::nextafter(product, 1e9)}) {
    if (candidate / kMilli == radians) return candidate;
  }
  return product;
}

bool isZero(double value) {
  return std::bit_cast<uint64_t>(value) == 0;
}
bool isZero(const Vec3& v) {
  return isZero(v.x) && isZero(v.y) && isZero(v.z);
}

/// Lists `member` of every channel.
template <class Member>
std::string listText(const std::vector<Channel>& channels, Member Channel::*member) {
  constexpr size_t kLineWidth = 100;
  std::string all = "[";
  std::string line;
  for (size_t j = 0; j < channels.size(); ++j) {
    const std::string word = text(channels[j].*member) + (j + 1 < channels.size() ? ", " : "");
    if (line.size() + word.size() > kLineWidth) {
      all += "\n    " + line.substr(0, line.find_last_not_of(' ') + 1);
      line.clear();
    }
    line += word;
  }
  if (all.size() == 1) return all + line + "]";
  return all + "\n    " + line + "\n  ]";
}

/// Lists a member, or returns nothing if it is 0 in every channel.
template <class Member>
std::string optionalList(const char* key, const std::vector<Channel>& channels, Member Channel::*member) {
  const bool stated =
      std::any_of(channels.begin(), channels.end(), [&](const Channel& channel) { return !isZero(channel.*member); });
  return stated ? std::string(",\n  \"") + key + "\": " + listText(channels, member) : "";
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
  std::string out = "{\n  \"name\": " + name + ",\n  \"columns\": " + std::to_string(sensor.columns) +
                    ",\n  \"range\": {\"min\": " + text(sensor.rangeMin) + ", \"max\": " + text(sensor.rangeMax) + "}";
  if (!isZero(sensor.divergenceHorizontal) || !isZero(sensor.divergenceVertical)) {
    out += ",\n  \"divergence_mrad\": [" + text(milliradians(sensor.divergenceHorizontal)) + ", " +
           text(milliradians(sensor.divergenceVertical)) + "]";
  }
  if (sensor.maxReturns != 1) out += ",\n  \"max_returns\": " + std::to_string(sensor.maxReturns);
  if (!isZero(sensor.rotationPeriod)) out += ",\n  \"rotation_period\": " + text(sensor.rotationPeriod);
  out += ",\n  \"elevation_deg\": " + listText(sensor.channels, &Channel::elevationDeg);
  out += optionalList("azimuth_offset_deg", sensor.channels, &Channel::azimuthOffsetDeg);
  out += optionalList("origin", sensor.channels, &Channel::origin);
  out += optionalList("time_offset", sensor.channels, &Channel::timeOffset);
  return out + "\n}\n";
}

Sensor sensorFromJson(std::string_view text, const std::string& source) {
  Sensor sensor;
  try {
    sensor = sensorFromRoot({source}, json::parse(text));
    validate(sensor);
  } catch (const json::exception& problem) {
    // "[json.exception.parse_error.101] parse error at line 1, ...": the readable part follows the bracket.
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
