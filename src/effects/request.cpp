// SPDX-License-Identifier: Apache-2.0
// {"seed": 1, "fog": {"use": "on", "visibility": 200}, "divergence": "off", "rain": {"rate": 5}}
// An effect is given by its use or by an object with its parameters; giving a parameter turns the effect on unless
// "use" says otherwise. Names, units and limits come from effectTable().
#include "effects/request.hpp"

#include "base/nearest_text.hpp"
#include "effects/effect_table.hpp"
#include "effects/parameter_text.hpp"
#include "gnosphere/error.hpp"
#include "sensor/carla_lidars.hpp"

namespace gnosphere {
namespace {

using nlohmann::json;

const EffectInfo& findEffect(const std::string& name) {
  for (const EffectInfo& info : effectTable())
    if (name == info.name) return info;
  refuseArgument("no effect is called '" + name + "'; " + nearestText(name, effectNames()));
}

const Parameter<Effects>& findParameter(const EffectInfo& info, const std::string& name) {
  std::vector<std::string> names;
  for (const Parameter<Effects>& parameter : info.parameters) {
    if (name == parameter.name) return parameter;
    names.push_back(parameter.name);
  }
  if (names.empty()) refuseArgument(std::string(info.name) + " has no '" + name + "', nor any other parameter");
  refuseArgument(std::string(info.name) + " has no '" + name + "'; " + nearestText(name, names));
}

EffectUse useOf(const json& value, const std::string& effect) {
  for (size_t i = 0; i < std::size(kUseWords); ++i)
    if (isText(value, kUseWords[i])) return static_cast<EffectUse>(i);
  refuseArgument(effect + " must be off, on or auto, is " + shown(value));
}

void readParameter(Effects& effects, const EffectInfo& info, const std::string& name, const json& value) {
  const Parameter<Effects>& parameter = findParameter(info, name);
  const std::string what = std::string(info.name) + "." + name;
  readValue(parameter, effects, what, value);
}

/// Turns on an effect one of whose parameters was given. Parameters that still ask for nothing, such as a rate of 0,
/// leave it to `auto`, which leaves it out, so that a series of rates may begin with 0.
void turnOn(Effects& effects, const EffectInfo& info) {
  info.use(effects) = info.isZero && info.isZero(effects) ? EffectUse::automatic : EffectUse::on;
}

void readEffect(Effects& effects, const EffectInfo& info, const json& value) {
  if (!value.is_object()) {
    info.use(effects) = useOf(value, info.name);
    return;
  }
  for (const auto& [name, parameter] : value.items()) {
    if (name == "use") continue;
    readParameter(effects, info, name, parameter);
    turnOn(effects, info);
  }
  if (value.contains("use")) info.use(effects) = useOf(value["use"], info.name + std::string(".use"));
}

}  // namespace

void validate(const Effects& effects) {
  Effects checked = effects;  // a copy, because parameters give access only to mutable members
  for (const EffectInfo& info : effectTable()) {
    if (info.use(checked) > EffectUse::automatic)
      refuseArgument(std::string(info.name) + " must be off, on or automatic");
    for (const Parameter<Effects>& parameter : info.parameters) {
      const std::string what = std::string(info.name) + "." + parameter.name;
      checkValue(parameter, checked, what);
    }
  }
}

Effects effectsFrom(const json& root, const std::string& source) {
  if (lacksCarlaType(root)) throw Error(ErrorCode::format, source + ": " + kLacksCarlaType);
  Effects effects;
  try {
    if (!root.is_object()) refuseArgument("a request is a JSON object");
    for (const auto& [name, value] : root.items()) {
      if (name == seedParameter().name)
        readValue(seedParameter(), effects, name, value);
      else
        readEffect(effects, findEffect(name), value);
    }
    validate(effects);
  } catch (const Error& problem) {
    throw Error(ErrorCode::format, source + ": " + problem.what());
  }
  return effects;
}

Effects effectsFromJson(std::string_view text, const std::string& source) {
  return effectsFrom(parseStrict(text, source), source);
}

std::string toJson(const Effects& effects) {
  validate(effects);
  Effects all = effects;
  std::string out = "{\n  \"seed\": " + std::to_string(effects.seed);
  for (const EffectInfo& info : effectTable()) {
    const std::string use = quoted(kUseWords[static_cast<size_t>(info.use(all))]);
    out += ",\n  " + quoted(info.name) + ": " + (info.parameters.empty() ? use : "{\"use\": " + use);
    for (const Parameter<Effects>& parameter : info.parameters) {
      out += ", " + quoted(parameter.name) + ": " + valueText(parameter, effects);
    }
    if (!info.parameters.empty()) out += "}";
  }
  return out + "\n}\n";
}

void assign(Effects& effects, const std::string& assignment) {
  const auto [name, value] = splitAssignment(assignment, "fog.visibility=200 or fog=off");
  Effects changed = effects;
  const size_t dot = name.find('.');
  if (name == seedParameter().name) {
    readValue(seedParameter(), changed, name, value);
  } else if (dot == name.npos) {
    const EffectInfo& info = findEffect(name);
    info.use(changed) = useOf(value, name);
  } else {
    const std::string effect = name.substr(0, dot);
    const EffectInfo& info = findEffect(effect);
    readParameter(changed, info, name.substr(dot + 1), value);
    turnOn(changed, info);
  }
  validate(changed);
  effects = std::move(changed);
}

}  // namespace gnosphere
