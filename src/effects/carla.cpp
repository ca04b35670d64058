// SPDX-License-Identifier: Apache-2.0
// Attributes of CARLA's lidars that are effects here. The laws are those of CARLA 0.9: ComputeIntensity(),
// PreprocessRays() and PostprocessDetection() of RayCastLidar.cpp.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <system_error>

#include "base/json_text.hpp"
#include "base/text.hpp"
#include "effects/effect_table.hpp"
#include "effects/parameter_text.hpp"
#include "effects/request.hpp"
#include "gnosphere/error.hpp"
#include "sensor/carla_lidars.hpp"

namespace gnosphere {
namespace {

using nlohmann::json;

const Parameter<Effects>& parameterOf(const CarlaParameter& carla) {
  if (std::string_view(carla.effect).empty()) return seedParameter();
  const auto isNamed = [](const char* name) {
    return [name](const auto& row) { return std::string(row.name) == name; };
  };
  const EffectInfo& info = *std::ranges::find_if(effectTable(), isNamed(carla.effect));
  return *std::ranges::find_if(info.parameters, isNamed(carla.parameter));
}

/// A number that an attribute states as such or as a text, as CARLA's blueprints do; another text stays what it is.
json plainNumber(const json& value) {
  if (!value.is_string()) return value;
  const auto& text = value.get_ref<const std::string&>();
  double number = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (problem != std::errc() || end != text.data() + text.size()) return value;
  if (number >= 0 && number <= 9e15 && number == std::floor(number)) return static_cast<uint64_t>(number);
  return number;
}

void readAttribute(const Parameter<Effects>& parameter, const json& value, const std::string& name, Effects& effects) {
  readValue(parameter, effects, name, plainNumber(value));
  checkValue(parameter, effects, name);
}

Effects effectsOfLidar(const json& lidar) {
  if (!hasCarlaEffects(lidar)) return Effects::none();
  Effects effects = effectPreset("carla");
  effects.seed = 0;  // CARLA's default
  for (const CarlaParameter& carla : kCarlaParameters) {
    const std::string attribute = carla.attribute;
    const auto found = lidar.find(attribute);
    if (found == lidar.end()) continue;
    // No intensity is at or below a limit of zero, so that none is lost by it.
    const json value = plainNumber(*found);
    if (attribute == "dropoff_intensity_limit" && value.is_number() && value.get<double>() <= 0)
      effects.dropOut.intensityLimit = 0;
    else
      readAttribute(parameterOf(carla), value, "'" + attribute + "'", effects);
  }
  if (effects.dropOut.intensityLimit == 0) {
    effects.dropOut.intensityLimit = 1;
    effects.dropOut.zeroIntensityRate = 0;
  }
  if (effects.dropOut.generalRate == 0 && effects.dropOut.zeroIntensityRate == 0)
    effects.dropOut.use = EffectUse::off;  // an effect that is on must have something to do
  if (effects.rangeNoise.sigma > 0) effects.rangeNoise.use = EffectUse::on;
  return effects;
}

}  // namespace

Effects effectsOfCarla(const json& root, const std::string& source, const std::string& mode) {
  const auto refuse = [&](const std::string& why) { throw Error(ErrorCode::format, source + ": " + plainAscii(why)); };
  std::vector<const json*> lidars = carlaLidars(root);
  const std::string ids = idsOf(lidars);
  if (lidars.empty()) refuse("describes sensors of CARLA, but no 'sensor.lidar.ray_cast'");
  if (!mode.empty())
    std::erase_if(lidars, [&](const json* lidar) { return !lidar->contains("id") || !isText(lidar->at("id"), mode); });
  if (lidars.empty()) refuse("has no lidar '" + mode + "', but " + ids);
  Effects effects;
  std::string first;
  for (const json* lidar : lidars) {
    try {
      effects = effectsOfLidar(*lidar);
    } catch (const Error& problem) {
      refuse(problem.what());
    }
    const std::string text = toJson(effects);
    if (!first.empty() && text != first)
      refuse("the effects of the lidars " + ids +
             " differ: choose one by its id, as `gnosphere effects FILE --mode ID` does");
    first = text;
  }
  return effects;
}

}  // namespace gnosphere
