// SPDX-License-Identifier: Apache-2.0
#include "effects/request_table.hpp"

#include <cstdio>

#include "effects/bits.h"

namespace gnosphere {
namespace {

/// The member of a nested struct: at<&Effects::fog, &Effects::Fog::visibility>(effects).
template <auto kGroup, auto kMember>
auto& at(Effects& effects) {
  return effects.*kGroup.*kMember;
}

template <auto kGroup, auto kMember>
Parameter number(const char* name, const char* unit, double min, double max, bool endsOnly = false) {
  return {name, unit, NumberParameter{&at<kGroup, kMember>, min, max, endsOnly}};
}

template <auto kGroup, auto kMember>
Parameter count(const char* name, uint32_t min, uint32_t max) {
  return {name, "", CountParameter{&at<kGroup, kMember>, min, max}};
}

template <auto kGroup, auto kMember>
Parameter choice(const char* name, std::vector<const char*> words) {
  const auto get = [](const Effects& effects) { return static_cast<size_t>(effects.*kGroup.*kMember); };
  const auto set = [](Effects& effects, size_t word) {
    auto& member = at<kGroup, kMember>(effects);
    member = static_cast<std::remove_reference_t<decltype(member)>>(word);
  };
  return {name, "", ChoiceParameter{std::move(words), get, set}};
}

template <auto kGroup>
EffectInfo effect(const char* name, std::vector<Parameter> parameters) {
  return {name, [](Effects& effects) -> Use& { return (effects.*kGroup).use; }, std::move(parameters)};
}

using E = Effects;

// Limits are there to catch a wrong unit, not to say what is usual.
std::vector<EffectInfo> makeTable() {
  return {
      effect<&E::intensity>("intensity",
                            {choice<&E::intensity, &E::Intensity::model>("model", {"physical", "carla"}),
                             choice<&E::intensity, &E::Intensity::scale>("scale", {"raw", "unit", "byte"}),
                             number<&E::intensity, &E::Intensity::wavelength>("wavelength", "nm", 905, 1550, true),
                             number<&E::intensity, &E::Intensity::attenuation>("attenuation", "1/m", 0, 10)}),
      effect<&E::detection>("detection",
                            {number<&E::detection, &E::Detection::reflectance>("reflectance", "", 0.001, 1),
                             number<&E::detection, &E::Detection::range>("range", "m", 0, 1e6),
                             number<&E::detection, &E::Detection::softness>("softness", "", 0, 10)}),
      effect<&E::dropOut>("drop-out",
                          {number<&E::dropOut, &E::DropOut::generalRate>("general_rate", "", 0, 1),
                           number<&E::dropOut, &E::DropOut::intensityLimit>("intensity_limit", "", 0.001, 1),
                           number<&E::dropOut, &E::DropOut::zeroIntensityRate>("zero_intensity_rate", "", 0, 1),
                           {"dead_beams", "", BeamsParameter{&at<&E::dropOut, &E::DropOut::deadBeams>}}}),
      effect<&E::rangeNoise>("range-noise",
                             {number<&E::rangeNoise, &E::RangeNoise::bias>("bias", "m", -100, 100),
                              number<&E::rangeNoise, &E::RangeNoise::sigma>("sigma", "m", 0, 100),
                              number<&E::rangeNoise, &E::RangeNoise::sigmaPerMetre>("sigma_per_metre", "", 0, 1),
                              number<&E::rangeNoise, &E::RangeNoise::step>("step", "m", 0, 100)}),
      effect<&E::angleNoise>("angle-noise",
                             {number<&E::angleNoise, &E::AngleNoise::azimuth>("azimuth", "rad", 0, 0.1),
                              number<&E::angleNoise, &E::AngleNoise::elevation>("elevation", "rad", 0, 0.1),
                              choice<&E::angleNoise, &E::AngleNoise::at>("at", {"beam", "point"})}),
      effect<&E::intensityNoise>("intensity-noise",
                                 {number<&E::intensityNoise, &E::IntensityNoise::sigma>("sigma", "", 0, 1)}),
      effect<&E::divergence>("divergence",
                             {count<&E::divergence, &E::Divergence::subRays>("sub_rays", 1, 61),
                              choice<&E::divergence, &E::Divergence::profile>("profile", {"uniform", "gaussian"}),
                              number<&E::divergence, &E::Divergence::horizontal>("horizontal", "rad", 0, 0.1),
                              number<&E::divergence, &E::Divergence::vertical>("vertical", "rad", 0, 0.1)}),
      effect<&E::returns>("returns", {choice<&E::returns, &E::Returns::mode>(
                                          "mode", {"first", "second", "last", "strongest", "second-strongest",
                                                   "first-second", "first-last", "first-strongest", "last-strongest",
                                                   "strongest-second-strongest", "all"}),
                                      count<&E::returns, &E::Returns::count>("count", 0, 5),
                                      number<&E::returns, &E::Returns::separation>("separation", "m", 0, 100),
                                      number<&E::returns, &E::Returns::pulseWidth>("pulse_width", "s", 1e-12, 1e-6)}),
      effect<&E::transmission>("transmission", {}),
      effect<&E::cutOuts>("cut-outs", {}),
      effect<&E::sensorMotion>("sensor-motion",
                               {{"deskew", "", FlagParameter{&at<&E::sensorMotion, &E::SensorMotion::deskew>}}}),
      effect<&E::objectMotion>("object-motion", {}),
      effect<&E::fog>("fog", {number<&E::fog, &E::Fog::visibility>("visibility", "m", 0, 1e6)}),
      effect<&E::rain>("rain", {number<&E::rain, &E::Rain::rate>("rate", "mm/h", 0, 500)}),
      effect<&E::snow>("snow", {number<&E::snow, &E::Snow::rate>("rate", "mm/h", 0, 100)}),
      effect<&E::volumes>("volumes", {{"boxes", "", BoxesParameter{&at<&E::volumes, &E::Volumes::boxes>}}}),
      effect<&E::radialSpeed>("radial-speed", {}),
  };
}

std::string text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof(buffer), "%.10g", value);
  return buffer;
}

std::string withUnit(std::string range, const Parameter& parameter) {
  return *parameter.unit ? range + " " + parameter.unit : range;
}

}  // namespace

const std::vector<EffectInfo>& effectTable() {
  static const std::vector<EffectInfo> table = makeTable();
  return table;
}

const std::vector<std::string>& effectNames() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const EffectInfo& info : effectTable()) all.push_back(info.name);
    return all;
  }();
  return names;
}

Effects Effects::none() {
  Effects effects;
  for (const EffectInfo& info : effectTable()) info.use(effects) = Use::off;
  return effects;
}

std::string allowedText(const Parameter& parameter) {
  if (const auto* n = std::get_if<NumberParameter>(&parameter.kind)) {
    return withUnit(text(n->min) + (n->endsOnly ? " or " : "..") + text(n->max), parameter);
  }
  if (const auto* n = std::get_if<CountParameter>(&parameter.kind)) {
    return "a whole number, " + std::to_string(n->min) + ".." + std::to_string(n->max);
  }
  if (const auto* n = std::get_if<ChoiceParameter>(&parameter.kind)) {
    std::string list = n->words.front();
    for (size_t i = 1; i < n->words.size(); ++i) {
      list.append(i + 1 < n->words.size() ? ", " : " or ").append(n->words[i]);
    }
    return list;
  }
  if (std::holds_alternative<FlagParameter>(parameter.kind)) return "true or false";
  if (std::holds_alternative<BeamsParameter>(parameter.kind)) return "a list of beam indices";
  return "a list of {\"min\": [x, y, z], \"max\": [x, y, z], \"extinction\": 1/m}";
}

}  // namespace gnosphere
