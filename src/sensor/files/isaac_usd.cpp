// SPDX-License-Identifier: Apache-2.0
// OmniLidar prims in USD's text, as NVIDIA's Isaac Sim 5 and later have them. Their attributes omni:sensor:Core:NAME
// are those of a profile, so they become one, and its reader does the rest.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

#include "base/json_text.hpp"
#include "base/text.hpp"
#include "sensor/files/source.hpp"

namespace gnosphere {
namespace {

using nlohmann::json;

constexpr std::string_view kPrefix = "omni:sensor:Core:", kStates = "emitterState:";
/// Characters of an attribute's name, with the point before timeSamples or connect.
constexpr std::string_view kNameCharacters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_:.";

/// A file's text with blanks in place of its comments, and the same with blanks also in place of what strings and asset
/// paths say, so that nothing in them is taken for an attribute. Both are as long as the file.
struct UsdText {
  std::string plain, bare;
};

/// Where the string or the asset path that starts at `at` ends. Three quotation marks in a row hold several lines.
size_t endOfString(std::string_view text, size_t at) {
  const char quote = text[at];
  const bool isLong = text.substr(at, 3) == std::string(3, quote);
  const std::string mark(isLong ? 3 : 1, quote);
  for (size_t i = at + mark.size(); i < text.size(); ++i) {
    if (text[i] == '\\' && (quote != '@' || isLong))
      ++i;
    else if (text.substr(i, mark.size()) == mark)
      return i + mark.size();
    else if (text[i] == '\n' && !isLong)
      return i;
  }
  return text.size();
}

UsdText withoutComments(std::string_view text) {
  UsdText result{std::string(text), std::string(text)};
  const auto blank = [](std::string& where, size_t from, size_t end) {
    for (size_t i = from; i < end; ++i)
      if (where[i] != '\n') where[i] = ' ';
  };
  for (size_t at = 0; at < text.size();) {
    const char c = text[at];
    size_t end = at + 1;
    if (c == '#') {
      end = std::min(text.find('\n', at), text.size());
      blank(result.plain, at, end);
      blank(result.bare, at, end);
    } else if (c == '"' || c == '\'' || c == '@') {
      end = endOfString(text, at);
      blank(result.bare, at + 1, end - 1);
    }
    at = end;
  }
  return result;
}

/// Reads a value of USD: a token in quotes, a number, true or false, or a list of numbers in brackets. Returns null for
/// other values, such as pairs, paths and lists of texts.
json valueOf(const SensorSource& source, std::string_view text, const std::string& name) {
  const auto one = [&](std::string_view word) -> json {
    if (word == "true" || word == "false") return word == "true";
    return numberOf(source, word, "'" + name + "'");
  };
  text = trimmed(text);
  if (text.starts_with('"') || text.starts_with('\''))
    return std::string(trimmed(text, std::string_view(text.data(), 1)));
  if (!text.starts_with('[')) return text.find_first_of("({@<") == 0 ? json() : one(text);
  text = text.substr(1, text.size() - 2);
  if (text.find_first_of("(\"'@<") != text.npos) return {};
  json list = json::array();
  for (const std::string_view cell : cellsOf(text))
    if (!trimmed(cell).empty()) list.push_back(one(trimmed(cell)));
  return list;
}

/// Where the value that starts behind `at` ends, in a text whose strings are blank: behind its bracket or its quotation
/// mark, or before the metadata or the end of its line.
size_t endOfValue(const SensorSource& source, std::string_view bare, size_t at) {
  const size_t first = bare.find_first_not_of(" \t\r", at);
  if (first == bare.npos) return bare.size();
  const char c = bare[first];
  if (c == '[') {
    const size_t end = bare.find(']', first);
    if (end == bare.npos) source.refuse("a list that starts with [ has no end");
    return end + 1;
  }
  if (c == '"' || c == '\'') return std::min(bare.find_first_of(std::string{c, '\n'}, first + 1), bare.size() - 1) + 1;
  return std::min(bare.find_first_of("\n;(", c == '(' ? first + 1 : first), bare.size());
}

/// The attributes of a prim: those of a profile, and those of each state of its emitters.
struct UsdAttributes {
  json profile = json::object();
  std::map<std::string, json> states;
};

UsdAttributes attributesOf(SensorSource& source) {
  const UsdText text = withoutComments(source.bytes);
  const size_t prim = text.bare.find("OmniLidar");
  if (prim == text.bare.npos) source.refuse("is USD without an OmniLidar prim");
  UsdAttributes found;
  for (size_t at = text.bare.find(kPrefix, prim); at != text.bare.npos; at = text.bare.find(kPrefix, at)) {
    at += kPrefix.size();
    const size_t nameEnd = std::min(text.bare.find_first_not_of(kNameCharacters, at), text.bare.size());
    const std::string name = text.bare.substr(at, nameEnd - at);
    const size_t equals = text.bare.find_first_not_of(" \t", nameEnd);
    if (equals == text.bare.npos || text.bare[equals] != '=') continue;  // a declaration without a value
    at = endOfValue(source, text.bare, equals + 1);
    const std::string_view stated = std::string_view(text.plain).substr(equals + 1, at - equals - 1);
    if (trimmed(stated) == "None") continue;
    if (name.ends_with(".timeSamples")) source.refuse("'" + name + "' changes with time; a sensor has one value of it");
    const json value = name.find('.') == name.npos ? valueOf(source, stated, name) : json();
    const size_t colon = name.starts_with(kStates) ? name.find(':', kStates.size()) : 0;
    if (value.is_null() || colon == name.npos) {
      source.ignore(name);
    } else {
      json& place = colon == 0
                        ? found.profile[name]
                        : found.states[name.substr(kStates.size(), colon - kStates.size())][name.substr(colon + 1)];
      if (!place.is_null()) source.refuse("'" + name + "' is there twice: a file of one OmniLidar is read");
      place = value;
    }
  }
  return found;
}

/// Takes a list out of a profile; an empty one if it is not there.
std::vector<double> takeList(const SensorSource& source, json& profile, const char* name) {
  std::vector<double> list;
  if (profile.contains(name)) list = numbersIn(source, profile, name);
  profile.erase(name);
  return list;
}

/// Turns rangesMinM and rangesMaxM into the ranges of a profile. These lists override nearRangeM and farRangeM. A
/// single range is that of all emitters; of several, rangeId says which one an emitter has.
void readRangeLists(SensorSource& source, UsdAttributes& found, double usualFar) {
  json& profile = found.profile;
  const std::vector<double> least = takeList(source, profile, "rangesMinM");
  const std::vector<double> most = takeList(source, profile, "rangesMaxM");
  const size_t count = std::max(least.size(), most.size());
  if (count == 0) return;
  if (!least.empty() && !most.empty() && least.size() != most.size())
    source.refuse("'rangesMinM' has " + std::to_string(least.size()) + " entries, 'rangesMaxM' " +
                  std::to_string(most.size()));
  if (const double stated = numberIn(source, profile, "rangeCount", static_cast<double>(count));
      stated != static_cast<double>(count))
    source.refuse("'rangeCount' is " + shownNumber(stated) + ", but rangesMinM and rangesMaxM have " +
                  std::to_string(count) + " entries");
  const double near = numberIn(source, profile, "nearRangeM", 0),
               far = numberIn(source, profile, "farRangeM", usualFar);
  std::vector<bool> used(count, count == 1);
  size_t naming = 0;
  for (const auto& [name, state] : found.states) {
    if (!state.contains("rangeId")) continue;
    ++naming;
    for (const double id : numbersIn(source, state, "rangeId")) {
      if (!(id >= 0 && id < static_cast<double>(count)) || id != std::floor(id))
        source.refuse("'rangeId' is " + shownNumber(id) + ", but rangesMinM and rangesMaxM have " +
                      std::to_string(count) + " entries, counted from 0");
      used[static_cast<size_t>(id)] = true;
    }
  }
  if (count > 1 && naming == 0)
    return source.ignore("rangesMinM and rangesMaxM, because no rangeId says which emitters have which range");
  profile["ranges"] = json::array();
  double nearest = INFINITY, farthest = 0;
  for (size_t i = 0; i < count; ++i) {
    const double from = least.empty() ? near : least[i], to = most.empty() ? far : most[i];
    if (count > 1) profile["ranges"].push_back({{"min", from}, {"max", to}});
    if (!used[i]) continue;
    nearest = std::min(nearest, from);
    farthest = std::max(farthest, to);
  }
  // Emitters of states without rangeId keep the ranges of the whole sensor.
  if (count > 1 && naming < found.states.size()) return;
  if (!least.empty()) profile["nearRangeM"] = nearest;
  if (!most.empty()) profile["farRangeM"] = farthest;
}

/// Drops the lists without entries, which state nothing.
void dropEmptyLists(std::map<std::string, json>& states) {
  for (auto& [name, state] : states)
    for (auto it = state.begin(); it != state.end();)
      it = it->is_array() && it->empty() ? state.erase(it) : std::next(it);
}

/// Returns the emitter states as profiles have them, where channels are counted from 0 and not from 1.
json statesOf(std::map<std::string, json>& states) {
  json list = json::array();
  for (auto& [name, state] : states) {
    json& ids = state["channelId"];  // channels that are counted from 0 stay
    if (!ids.is_array() || !std::all_of(ids.begin(), ids.end(), [](const json& id) { return id.is_number(); }))
      state.erase("channelId");
    else if (std::none_of(ids.begin(), ids.end(), [](const json& id) { return id.get<double>() < 1; }))
      for (json& id : ids) id = id.get<double>() - 1;
    list.push_back(state);
  }
  return list;
}

}  // namespace

void readIsaacUsd(SensorSource& source) {
  if (source.bytes.starts_with("PXR-USDC")) source.refuse("is binary USD: usdcat writes it as text, a .usda");
  UsdAttributes found = attributesOf(source);
  json& profile = found.profile;
  dropEmptyLists(found.states);
  if (found.states.empty() || !found.states.begin()->second.contains("azimuthDeg"))
    source.refuse("'omni:sensor:Core:emitterState:s001:azimuthDeg' is missing; the default of its schema is not read");
  const auto has = [&](const char* name) { return profile.contains(name) && profile[name].is_number(); };
  if (!profile.contains("scanType")) source.refuse("'omni:sensor:Core:scanType' is missing, ROTARY or SOLID_STATE");
  if (has("rotPatternFiringResDeg") && has("scanRateBaseHz") && !has("patternFiringRateHz") &&
      profile["rotPatternFiringResDeg"].get<double>() > 0)
    profile["patternFiringRateHz"] =
        std::round(360 * profile["scanRateBaseHz"].get<double>() / profile["rotPatternFiringResDeg"].get<double>());
  profile.erase("rotPatternFiringResDeg");
  if (has("patternFiringRateHz")) profile.erase("reportRateBaseHz");
  constexpr double kUsualFar = 200;
  readRangeLists(source, found, kUsualFar);
  if (!has("farRangeM")) {
    profile["farRangeM"] = kUsualFar;
    source.assume("a largest range of 200 m");
  }
  if (sameWord(textIn(profile, "scanType"), "ROTARY") && !profile.contains("rotationDirection"))
    source.assume("that the head turns clockwise");
  profile["emitterStates"] = statesOf(found.states);
  readIsaac(source, json{{"name", ""}, {"profile", profile}});
}

}  // namespace gnosphere
