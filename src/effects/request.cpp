// SPDX-License-Identifier: Apache-2.0
// {"seed": 1, "fog": {"use": "on", "visibility": 200}, "divergence": "off", "rain": {"rate": 5}}
// An effect is given by its use or by an object with its parameters; giving a parameter turns the effect on unless
// "use" says otherwise. Names, units and limits come from effectTable().
#include <algorithm>
#include <charconv>
#include <cmath>

#include "effects/effect_table.hpp"
#include "effects/strict_json.hpp"
#include "gnosphere/effects.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere {
namespace {

using nlohmann::json;

[[noreturn]] void refuse(const std::string& why) {
  throw Error(ErrorCode::invalidArgument, why);
}

/// Returns the shortest text that reads back to the same bits.
std::string text(double value) {
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof(buffer), value).ptr};
}

double number(const json& value, const std::string& what, const std::string& allowed) {
  if (!value.is_number()) refuse(what + " must be " + allowed + ", is " + shown(value));
  return value.get<double>();
}

uint32_t wholeNumber(const json& value, const std::string& what, const std::string& allowed) {
  if (!value.is_number_unsigned() || value.get<uint64_t>() > 0xffffffffu) {
    refuse(what + " must be " + allowed + ", is " + shown(value));
  }
  return value.get<uint32_t>();
}

Vec3 point(const json& box, const char* key, const std::string& what) {
  const auto found = box.find(key);
  if (found == box.end() || !found->is_array() || found->size() != 3) {
    refuse(what + ": '" + key + "' must be [x, y, z], three numbers of metres");
  }
  const std::string name = what + "." + key;
  return {number((*found)[0], name, "three numbers"), number((*found)[1], name, "three numbers"),
          number((*found)[2], name, "three numbers")};
}

Effects::Volume volume(const json& box, const std::string& what) {
  if (!box.is_object()) refuse(what + " must be {\"min\": [x, y, z], \"max\": [x, y, z], \"extinction\": 1/m}");
  for (const auto& [key, value] : box.items()) {
    if (key != "min" && key != "max" && key != "extinction") {
      refuse(what + ": unknown key '" + key + "'; known are min, max, extinction");
    }
  }
  Effects::Volume volume = {point(box, "min", what), point(box, "max", what)};
  if (!box.contains("extinction")) refuse(what + ": 'extinction' is missing");
  volume.extinction = number(box["extinction"], what + ".extinction", "a number of 1/m");
  return volume;
}

/// Reads one value; validate() checks its range later.
struct Reader {
  Effects& effects;
  const Parameter& parameter;
  const std::string& what;
  const json& value;

  void operator()(const NumberParameter& n) const { n.of(effects) = number(value, what, allowedText(parameter)); }
  void operator()(const CountParameter& n) const { n.of(effects) = wholeNumber(value, what, allowedText(parameter)); }
  void operator()(const FlagParameter& flag) const {
    if (!value.is_boolean()) refuse(what + " must be true or false, is " + shown(value));
    flag.of(effects) = value.get<bool>();
  }
  void operator()(const ChoiceParameter& choice) const {
    const auto& words = choice.words;
    const auto found = std::find_if(words.begin(), words.end(), [&](const char* word) { return value == word; });
    if (found == words.end()) refuse(what + " must be " + allowedText(parameter) + ", is " + shown(value));
    choice.set(effects, static_cast<size_t>(found - words.begin()));
  }
  void operator()(const BeamsParameter& beams) const {
    if (!value.is_array()) refuse(what + " must be " + allowedText(parameter) + ", is " + shown(value));
    beams.of(effects).clear();
    for (const json& beam : value) beams.of(effects).push_back(wholeNumber(beam, what, allowedText(parameter)));
  }
  void operator()(const BoxesParameter& boxes) const {
    if (!value.is_array()) refuse(what + " must be " + allowedText(parameter) + ", is " + shown(value));
    boxes.of(effects).clear();
    for (size_t i = 0; i < value.size(); ++i) {
      boxes.of(effects).push_back(volume(value[i], what + "[" + std::to_string(i) + "]"));
    }
  }
};

/// Checks values that a C++ caller may also have set: ranges, and NaN.
struct Checker {
  Effects& effects;
  const Parameter& parameter;
  const std::string& what;

  void operator()(const NumberParameter& n) const {
    const double value = n.of(effects);
    const bool between = value >= n.min && value <= n.max;
    if (between && (!n.endsOnly || value == n.min || value == n.max)) return;
    refuse(what + " must be " + allowedText(parameter) + ", is " + text(value));
  }
  void operator()(const CountParameter& n) const {
    const uint32_t value = n.of(effects);
    if (value < n.min || value > n.max) {
      refuse(what + " must be " + allowedText(parameter) + ", is " + std::to_string(value));
    }
  }
  void operator()(const ChoiceParameter& choice) const {
    if (choice.get(effects) >= choice.words.size()) refuse(what + " must be " + allowedText(parameter));
  }
  void operator()(const BoxesParameter& boxes) const {
    for (size_t i = 0; i < boxes.of(effects).size(); ++i) {
      const auto& [min, max, extinction] = boxes.of(effects)[i];
      const std::string box = what + "[" + std::to_string(i) + "]";
      for (double value : {min.x, min.y, min.z, max.x, max.y, max.z}) {
        if (!std::isfinite(value)) refuse(box + ": its corners must be finite");
      }
      if (!(min.x <= max.x && min.y <= max.y && min.z <= max.z)) refuse(box + ": its min is beyond its max");
      if (!(extinction >= 0 && extinction <= kMaxExtinction)) {
        refuse(box + ".extinction must be 0.." + text(kMaxExtinction) + " 1/m, is " + text(extinction));
      }
    }
  }
  void operator()(const FlagParameter&) const {}
  void operator()(const BeamsParameter&) const {}  // decide() checks the indices against the sensor
};

std::string quoted(const char* word) {
  return std::string("\"").append(word).append("\"");
}

std::string vectorText(const Vec3& v) {
  return std::string("[").append(text(v.x) + ", " + text(v.y) + ", " + text(v.z)).append("]");
}

struct Writer {
  Effects& effects;

  std::string operator()(const NumberParameter& n) const { return text(n.of(effects)); }
  std::string operator()(const CountParameter& n) const { return std::to_string(n.of(effects)); }
  std::string operator()(const FlagParameter& flag) const { return flag.of(effects) ? "true" : "false"; }
  std::string operator()(const ChoiceParameter& choice) const { return quoted(choice.words[choice.get(effects)]); }
  std::string operator()(const BeamsParameter& beams) const {
    std::string list;
    for (uint32_t beam : beams.of(effects)) list += (list.empty() ? "" : ", ") + std::to_string(beam);
    return std::string("[").append(list).append("]");
  }
  std::string operator()(const BoxesParameter& boxes) const {
    std::string list;
    for (const auto& [min, max, extinction] : boxes.of(effects)) {
      list += std::string(list.empty() ? "" : ",") + "\n    {\"min\": " + vectorText(min) +
              ", \"max\": " + vectorText(max) + ", \"extinction\": " + text(extinction) + "}";
    }
    return std::string("[").append(list).append("]");
  }
};

const EffectInfo& findEffect(const std::string& name) {
  for (const EffectInfo& info : effectTable())
    if (name == info.name) return info;
  refuse("no effect is called '" + name + "'; " + nearestText(name, effectNames()));
}

const Parameter& findParameter(const EffectInfo& info, const std::string& name) {
  std::vector<std::string> names;
  for (const Parameter& parameter : info.parameters) {
    if (name == parameter.name) return parameter;
    names.push_back(parameter.name);
  }
  if (names.empty()) refuse(std::string(info.name) + " has no '" + name + "', nor any other parameter");
  refuse(std::string(info.name) + " has no '" + name + "'; " + nearestText(name, names));
}

EffectUse useOf(const json& value, const std::string& effect) {
  for (size_t i = 0; i < std::size(kUseWords); ++i)
    if (value == kUseWords[i]) return static_cast<EffectUse>(i);
  refuse(effect + " must be off, on or auto, is " + shown(value));
}

void readParameter(Effects& effects, const EffectInfo& info, const std::string& name, const json& value) {
  const Parameter& parameter = findParameter(info, name);
  const std::string what = std::string(info.name) + "." + name;
  std::visit(Reader{effects, parameter, what, value}, parameter.kind);
}

void readEffect(Effects& effects, const EffectInfo& info, const json& value) {
  if (!value.is_object()) {
    info.use(effects) = useOf(value, info.name);
    return;
  }
  for (const auto& [name, parameter] : value.items()) {
    if (name == "use") continue;
    readParameter(effects, info, name, parameter);
    info.use(effects) = EffectUse::on;
  }
  if (value.contains("use")) info.use(effects) = useOf(value["use"], info.name + std::string(".use"));
}

void readSeed(Effects& effects, const json& value) {
  if (!value.is_number_unsigned()) refuse("seed must be a whole number, 0..18446744073709551615, is " + shown(value));
  effects.seed = value.get<uint64_t>();
}

}  // namespace

void validate(const Effects& effects) {
  Effects checked = effects;  // a copy, because parameters give access only to mutable members
  for (const EffectInfo& info : effectTable()) {
    if (info.use(checked) > EffectUse::automatic) refuse(std::string(info.name) + " must be off, on or automatic");
    for (const Parameter& parameter : info.parameters) {
      const std::string what = std::string(info.name) + "." + parameter.name;
      std::visit(Checker{checked, parameter, what}, parameter.kind);
    }
  }
}

Effects effectsFromJson(std::string_view text, const std::string& source) {
  const json root = parseStrict(text, source);
  Effects effects;
  try {
    if (!root.is_object()) refuse("a request is a JSON object");
    for (const auto& [name, value] : root.items()) {
      if (name == "seed")
        readSeed(effects, value);
      else
        readEffect(effects, findEffect(name), value);
    }
    validate(effects);
  } catch (const Error& problem) {
    throw Error(ErrorCode::format, source + ": " + problem.what());
  }
  return effects;
}

std::string valueText(const Parameter& parameter, const Effects& effects) {
  Effects all = effects;
  return std::visit(Writer{all}, parameter.kind);
}

std::string toJson(const Effects& effects) {
  validate(effects);
  Effects all = effects;
  std::string out = "{\n  \"seed\": " + std::to_string(effects.seed);
  for (const EffectInfo& info : effectTable()) {
    const std::string use = quoted(kUseWords[static_cast<size_t>(info.use(all))]);
    out += ",\n  " + quoted(info.name) + ": " + (info.parameters.empty() ? use : "{\"use\": " + use);
    for (const Parameter& parameter : info.parameters) {
      out += ", " + quoted(parameter.name) + ": " + valueText(parameter, effects);
    }
    if (!info.parameters.empty()) out += "}";
  }
  return out + "\n}\n";
}

void assign(Effects& effects, const std::string& assignment) {
  const size_t equals = assignment.find('=');
  if (equals == assignment.npos) refuse("'" + assignment + "' is not NAME=VALUE, as fog.visibility=200 or fog=off");
  const std::string name = assignment.substr(0, equals), word = assignment.substr(equals + 1);
  json value = json::parse(word, nullptr, false);
  if (value.is_discarded()) value = word;  // a word on a command line needs no quotes
  Effects changed = effects;
  const size_t dot = name.find('.');
  if (name == "seed") {
    readSeed(changed, value);
  } else if (dot == name.npos) {
    const EffectInfo& info = findEffect(name);
    info.use(changed) = useOf(value, name);
  } else {
    const std::string effect = name.substr(0, dot);
    const EffectInfo& info = findEffect(effect);
    readParameter(changed, info, name.substr(dot + 1), value);
    info.use(changed) = EffectUse::on;
  }
  validate(changed);
  effects = std::move(changed);
}

}  // namespace gnosphere
