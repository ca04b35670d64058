// SPDX-License-Identifier: Apache-2.0
// OmniLidar prims in USD's text, as NVIDIA's Isaac Sim 5 and later have them. Their attributes omni:sensor:Core:NAME
// are those of a profile, so they become one, and its reader does the rest.
#include <algorithm>
#include <cmath>
#include <map>

#include "base/text.hpp"
#include "sensor/files/source.hpp"

namespace gnosphere {
namespace {

using nlohmann::json;

constexpr std::string_view kPrefix = "omni:sensor:Core:", kStates = "emitterState:";

/// A value of USD: a token in quotes, a number, true or false, or a list of numbers in brackets or parentheses.
json valueOf(const SensorSource& source, std::string_view text, const std::string& name) {
  text = trimmed(text);
  if (text.size() >= 2 && text.front() == '"') return std::string(text.substr(1, text.find('"', 1) - 1));
  if (text == "true" || text == "false") return text == "true";
  if (!text.starts_with('[')) return text.starts_with('(') ? json() : json(numberOf(source, text, "'" + name + "'"));
  json list = json::array();
  text.remove_prefix(1);
  if (text.ends_with(']')) text.remove_suffix(1);
  if (text.find('(') != text.npos) return json();  // pairs, such as ranges, which are not read
  for (const std::string_view cell : cellsOf(text))
    if (!trimmed(cell).empty())
      list.push_back(trimmed(cell).front() == '"' ? json() : json(numberOf(source, trimmed(cell), "'" + name + "'")));
  return list;
}

/// Where the value that starts at `at` ends: at the end of its line, or behind its bracket.
size_t endOfValue(const SensorSource& source, std::string_view text, size_t at) {
  const size_t line = std::min(text.find('\n', at), text.size());
  const size_t bracket = text.find('[', at);
  if (bracket >= line) return line;
  const size_t end = text.find(']', bracket);
  if (end == text.npos) source.refuse("a list that starts with [ has no end");
  return end + 1;
}

}  // namespace

void readIsaacUsd(SensorSource& source) {
  const std::string_view text = source.bytes;
  if (text.starts_with("PXR-USDC")) source.refuse("is binary USD: usdcat writes it as text, a .usda");
  const size_t prim = text.find("OmniLidar");
  if (prim == text.npos) source.refuse("is USD without an OmniLidar prim");
  json profile = json::object();
  std::map<std::string, json> states;
  for (size_t at = text.find(kPrefix, prim); at != text.npos; at = text.find(kPrefix, at)) {
    at += kPrefix.size();
    const size_t equals = text.find('=', at);
    const size_t line = std::min(text.find('\n', at), text.size());
    if (equals >= line) continue;  // a declaration without a value
    const std::string name(trimmed(text.substr(at, equals - at)));
    const size_t end = endOfValue(source, text, equals + 1);
    const json value = valueOf(source, text.substr(equals + 1, end - equals - 1), name);
    at = end;
    if (value.is_null()) {
      source.ignore(name);
    } else if (!name.starts_with(kStates)) {
      if (profile.contains(name)) source.refuse("'" + name + "' is there twice: a file of one OmniLidar is read");
      profile[name] = value;
    } else if (const size_t colon = name.find(':', kStates.size()); colon != name.npos) {
      states[name.substr(kStates.size(), colon - kStates.size())][name.substr(colon + 1)] = value;
    }
  }
  if (states.empty() || !states.begin()->second.contains("azimuthDeg"))
    source.refuse("'omni:sensor:Core:emitterState:s001:azimuthDeg' is missing; the default of its schema is not read");
  profile["emitterStates"] = json::array();
  for (auto& [name, state] : states) {
    // Channels may be counted from 1 on; a profile's rings are counted from 0.
    json& ids = state["channelId"];
    if (!ids.is_array() || !std::all_of(ids.begin(), ids.end(), [](const json& id) { return id.is_number(); }))
      state.erase("channelId");
    else if (std::none_of(ids.begin(), ids.end(), [](const json& id) { return id.get<double>() < 1; }))
      for (json& id : ids) id = id.get<double>() - 1;
    profile["emitterStates"].push_back(state);
  }
  const auto has = [&](const char* name) { return profile.contains(name) && profile[name].is_number(); };
  if (!profile.contains("scanType")) source.refuse("'omni:sensor:Core:scanType' is missing, ROTARY or SOLID_STATE");
  if (has("rotPatternFiringResDeg") && has("scanRateBaseHz") && !has("patternFiringRateHz") &&
      profile["rotPatternFiringResDeg"].get<double>() > 0)
    profile["patternFiringRateHz"] =
        std::round(360 * profile["scanRateBaseHz"].get<double>() / profile["rotPatternFiringResDeg"].get<double>());
  profile.erase("rotPatternFiringResDeg");
  if (has("patternFiringRateHz")) profile.erase("reportRateBaseHz");
  if (!has("farRangeM")) {
    profile["farRangeM"] = 200.0;
    source.assume("a largest range of 200 m");
  }
  if (!profile.contains("rotationDirection")) source.assume("that the head turns clockwise");
  readIsaac(source, json{{"name", ""}, {"profile", profile}});
}

}  // namespace gnosphere
