// SPDX-License-Identifier: Apache-2.0
// Writes the JSON that sensor_json.cpp reads.
#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <concepts>
#include <nlohmann/json.hpp>

#include "base/json_text.hpp"
#include "base/units.hpp"
#include "gnosphere/error.hpp"
#include "gnosphere/sensor.hpp"

namespace gnosphere {
namespace {

using nlohmann::json;

/// Returns the shortest text that reads back to the same bits. JSON readers take "-0" for the integer 0, hence "-0.0".
template <std::floating_point T>
std::string text(T value) {
  if (value == 0 && std::signbit(value)) return "-0.0";
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof(buffer), value).ptr};
}

template <std::unsigned_integral T>
std::string text(T value) {
  return std::to_string(value);
}

std::string text(const Vec3& v) {
  return std::string("[").append(text(v.x)).append(", ").append(text(v.y)).append(", ").append(text(v.z)).append("]");
}

/// Returns the milliradians that divided by 1000 give the same radians: the product or one of its neighbours, in case
/// rounding went the other way. (If none does, no double does, and the last bit is lost.)
double milliradians(double radians) {
  const double product = radians * kMilliPerUnit;
  for (double candidate : {product, std::nextafter(product, 0.0), std::nextafter(product, 1e9)}) {
    if (candidate / kMilliPerUnit == radians) return candidate;
  }
  return product;
}

bool isZero(double value) {
  return std::bit_cast<uint64_t>(value) == 0;
}
bool isZero(const Vec3& v) {
  return isZero(v.x) && isZero(v.y) && isZero(v.z);
}

/// Lists what get(i) returns for `count` entries, in lines of limited width.
template <class Get>
std::string listText(size_t count, Get get) {
  constexpr size_t kLineWidth = 100;
  std::string all = "[";
  std::string line;
  for (size_t i = 0; i < count; ++i) {
    const std::string word = text(get(i)) + (i + 1 < count ? ", " : "");
    if (line.size() + word.size() > kLineWidth) {
      all += "\n    " + line.substr(0, line.find_last_not_of(' ') + 1);
      line.clear();
    }
    line += word;
  }
  if (all.size() == 1) return all + line + "]";
  return all + "\n    " + line + "\n  ]";
}

template <typename T>
std::string listText(const std::vector<T>& list) {
  return listText(list.size(), [&](size_t i) { return list[i]; });
}

/// Lists `member` of every channel.
template <class Member>
std::string listText(const std::vector<Channel>& channels, Member Channel::*member) {
  return listText(channels.size(), [&](size_t j) { return channels[j].*member; });
}

/// Lists a member, or returns nothing if it is 0 in every channel.
template <class Member>
std::string optionalList(const char* key, const std::vector<Channel>& channels, Member Channel::*member) {
  const bool stated =
      std::any_of(channels.begin(), channels.end(), [&](const Channel& channel) { return !isZero(channel.*member); });
  return stated ? std::string(",\n  \"") + key + "\": " + listText(channels, member) : "";
}

std::string gridText(const Sensor& sensor) {
  std::string out = ",\n  \"elevation_deg\": " + listText(sensor.channels, &Channel::elevationDeg);
  out += optionalList("azimuth_offset_deg", sensor.channels, &Channel::azimuthOffsetDeg);
  out += optionalList("origin", sensor.channels, &Channel::origin);
  out += optionalList("time_offset", sensor.channels, &Channel::timeOffset);
  out += optionalList("range_min", sensor.channels, &Channel::rangeMin);
  out += optionalList("range_max", sensor.channels, &Channel::rangeMax);
  return out;
}

std::string patternsText(const std::vector<BeamList>& patterns) {
  std::string out = ",\n  \"patterns\": [";
  for (const BeamList& pattern : patterns) {
    out += &pattern == &patterns[0] ? "{" : ", {";
    if (pattern.width > 0 || pattern.height > 0)
      out += "\n  \"width\": " + text(pattern.width) + ", \"height\": " + text(pattern.height) + ",";
    out += "\n  \"directions\": " + listText(pattern.directions);
    const auto add = [&](const char* key, const auto& list) {
      if (!list.empty()) out.append(",\n  \"").append(key).append("\": ").append(listText(list));
    };
    add("origins", pattern.origins);
    add("times", pattern.times);
    add("range_min", pattern.rangeMin);
    add("range_max", pattern.rangeMax);
    add("rings", pattern.rings);
    out += "\n  }";
  }
  return out + "]";
}

}  // namespace

std::string toJson(const Sensor& sensor) {
  validate(sensor);
  const std::string name = jsonText(json(sensor.name));
  if (!isText(parseJson(name), sensor.name))
    throw Error(ErrorCode::invalidArgument, "the sensor's name is not UTF-8, JSON cannot hold it");
  std::string out = "{\n  \"name\": " + name +
                    (sensor.isGrid() ? ",\n  \"columns\": " + std::to_string(sensor.columns) : "") +
                    ",\n  \"range\": {\"min\": " + text(sensor.rangeMin) + ", \"max\": " + text(sensor.rangeMax) + "}";
  if (!isZero(sensor.divergenceHorizontal) || !isZero(sensor.divergenceVertical)) {
    out += ",\n  \"divergence_mrad\": [" + text(milliradians(sensor.divergenceHorizontal)) + ", " +
           text(milliradians(sensor.divergenceVertical)) + "]";
  }
  if (sensor.maxReturns != 1) out += ",\n  \"max_returns\": " + std::to_string(sensor.maxReturns);
  if (!isZero(sensor.rangeAt10Percent)) out += ",\n  \"range_at_10_percent\": " + text(sensor.rangeAt10Percent);
  if (!isZero(sensor.rotationPeriod)) out += ",\n  \"rotation_period\": " + text(sensor.rotationPeriod);
  if (!isZero(sensor.scanPeriod)) out += ",\n  \"scan_period\": " + text(sensor.scanPeriod);
  if (sensor.azimuthStartDeg != -180) out += ",\n  \"azimuth_start_deg\": " + text(sensor.azimuthStartDeg);
  if (sensor.azimuthSpanDeg != 360) out += ",\n  \"azimuth_span_deg\": " + text(sensor.azimuthSpanDeg);
  if (sensor.nearHits == NearHits::hide) out += ",\n  \"near_hits\": \"hide\"";
  out += sensor.isGrid() ? gridText(sensor) : patternsText(sensor.patterns);
  if (!sensor.maskedBeams.empty()) out += ",\n  \"masked_beams\": " + listText(sensor.maskedBeams);
  return out + "\n}\n";
}

}  // namespace gnosphere
