// SPDX-License-Identifier: Apache-2.0
// Every effect in one table: its parameters, which requests are read, checked, written and listed by, and how it is
// decided whether a scan can show it.
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

/// `of` gives the member of an Effects that a parameter stands for.
struct NumberParameter {
  double& (*of)(Effects&);
  double min, max;
  bool endsOnly = false;  ///< one of the two, and nothing between
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
  const char* unit;  ///< empty: none
  std::variant<NumberParameter, CountParameter, FlagParameter, ChoiceParameter, BeamsParameter, BoxesParameter> kind;
};

/// What a decision is made from.
struct Question {
  const Effects& effects;
  const Sensor& sensor;
  const Scene& scene;
  const std::vector<Field>& fields;
  const MaterialTable& materials;
  bool variableWeather = false;

  bool asksFor(Field field) const { return std::find(fields.begin(), fields.end(), field) != fields.end(); }
};

/// Whether an effect can be shown: what shows it, or what is missing and how to give it.
struct Answer {
  bool shows;
  std::string why;
  std::string wayOut = {};  ///< empty: `on` is accepted all the same
};
using Judge = Answer (*)(const Question&);

/// All that is known of one effect before its formulas.
struct EffectInfo {
  const char* name;
  uint32_t bit;  ///< of effects/bits.h
  EffectUse& (*use)(Effects&);
  Judge judge;  ///< null: intensity, which is in where another effect or a field needs it
  bool (*needsIntensity)(const Effects&);
  std::vector<Parameter> parameters;
};

/// In the order of effectNames().
const std::vector<EffectInfo>& effectTable();

inline constexpr const char* kUseWords[] = {"off", "on", "auto"};

/// The most that a box of Effects::Volumes takes away, 1/m: beyond it nothing is seen at a millimetre.
inline constexpr double kMaxExtinction = 1000;

/// What a parameter may be, for messages and lists: "0..500 mm/h", "uniform or gaussian".
std::string allowedText(const Parameter& parameter);
/// As JSON has it: 0.004, "gaussian", [].
std::string valueText(const Parameter& parameter, const Effects& effects);

}  // namespace gnosphere
