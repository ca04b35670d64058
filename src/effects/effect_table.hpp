// SPDX-License-Identifier: Apache-2.0
// The table of effects: the parameters of each, used to read, check, write and list requests, and the function that
// decides whether a scan can show the effect.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "gnosphere/effects.hpp"
#include "gnosphere/scan.hpp"
#include "gnosphere/scene.hpp"
#include "gnosphere/sensor.hpp"

namespace gnosphere {

/// In each kind of parameter `of` returns the member of Effects that the parameter sets.
struct NumberParameter {
  double& (*of)(Effects&);
  double min, max;
  bool endsOnly = false;  ///< only min and max are allowed, no value between
};
struct CountParameter {
  uint32_t& (*of)(Effects&);
  uint32_t min, max;
};
struct FlagParameter {
  bool& (*of)(Effects&);
};
struct ChoiceParameter {
  std::vector<const char*> words;  ///< in the order of the enum
  size_t (*get)(const Effects&);
  void (*set)(Effects&, size_t);
};
struct BeamsParameter {
  std::vector<uint32_t>& (*of)(Effects&);
};
struct BoxesParameter {
  std::vector<Effects::Volume>& (*of)(Effects&);
};

struct Parameter {
  const char* name;
  const char* unit;  ///< empty for a parameter without a unit
  std::variant<NumberParameter, CountParameter, FlagParameter, ChoiceParameter, BeamsParameter, BoxesParameter> kind;
};

/// The input of a decision.
struct Question {
  const Effects& effects;
  const Sensor& sensor;
  const Scene& scene;
  const std::vector<Field>& fields;
  const MaterialTable& materials;
  bool variableWeather = false;

  bool asksFor(Field field) const { return std::find(fields.begin(), fields.end(), field) != fields.end(); }
};

/// Whether an effect can be shown, and why.
struct Answer {
  bool shows;               ///< true if the scan can show the effect
  std::string why;          ///< what shows the effect, or what is missing
  std::string wayOut = {};  ///< how to supply what is missing; if empty, `on` is accepted nevertheless
};
using Judge = Answer (*)(const Question&);

/// The description of one effect, without its formulas.
struct EffectInfo {
  const char* name;
  uint32_t bit;  ///< bit of the effect in effects/bits.h
  EffectUse& (*use)(Effects&);
  Judge judge;  ///< null for intensity, which is planned if another effect or a field needs it
  bool (*needsIntensity)(const Effects&);
  std::vector<Parameter> parameters;
};

/// Returns all effects in the order of effectNames().
const std::vector<EffectInfo>& effectTable();

inline constexpr const char* kUseWords[] = {"off", "on", "auto"};

/// Largest extinction of a box of Effects::Volumes in 1/m; with it the visible depth is about a millimetre.
inline constexpr double kMaxExtinction = 1000;

/// Returns the allowed values for messages and lists: "0..500 mm/h", "uniform or gaussian".
std::string allowedText(const Parameter& parameter);
/// Returns the value as JSON text: 0.004, "gaussian", [].
std::string valueText(const Parameter& parameter, const Effects& effects);

}  // namespace gnosphere
