// SPDX-License-Identifier: Apache-2.0
// Every effect and every parameter of a request, in one table: what a request may say is read, checked, written and
// listed from here.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "gnosphere/effects.hpp"

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

struct EffectInfo {
  const char* name;
  Use& (*use)(Effects&);
  std::vector<Parameter> parameters;
};

/// In the order of effectNames() and of the bits of effects/plan.h.
const std::vector<EffectInfo>& effectTable();

inline constexpr const char* kUseWords[] = {"off", "on", "auto"};

/// The most that a box of Effects::Volumes takes away, 1/m: beyond it nothing is seen at a millimetre.
inline constexpr double kMaxExtinction = 1000;

/// What a parameter may be, for messages and lists: "0..500 mm/h", "uniform or gaussian".
std::string allowedText(const Parameter& parameter);
/// As JSON has it: 0.004, "gaussian", [].
std::string valueText(const Parameter& parameter, const Effects& effects);

}  // namespace gnosphere
