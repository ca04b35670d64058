// SPDX-License-Identifier: Apache-2.0
// The table of effects: the parameters of each, used to read, check, write and list requests, and the function that
// decides whether a scan can show the effect.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "effects/parameter.hpp"
#include "gnosphere/effects.hpp"
#include "gnosphere/scan.hpp"
#include "gnosphere/scene.hpp"
#include "gnosphere/sensor.hpp"

namespace gnosphere {

/// The input of a decision.
struct Question {
  const Effects& effects;
  const Sensor& sensor;
  const Scene& scene;
  const std::vector<Field>& fields;
  const MaterialTable& materials;
  const std::vector<uint32_t>& ignoredInstances;
  bool variableWeather = false;

  bool asksFor(Field field) const { return std::find(fields.begin(), fields.end(), field) != fields.end(); }
};

/// Whether an effect can be shown, and why.
struct Answer {
  bool shows;               ///< true if the scan can show the effect
  std::string why;          ///< what shows the effect, or what is missing
  std::string wayOut = {};  ///< how to supply what is missing; if empty, `on` is accepted nevertheless
  bool wrong = false;       ///< true if the request does not fit the sensor, an error even if the effect is automatic
};
using Applies = Answer (*)(const Question&);

/// The description of one effect, without its formulas.
struct EffectInfo {
  const char* name;
  uint32_t bit;  ///< bit of the effect in effects/bits.h
  EffectUse& (*use)(Effects&);
  Applies applies;  ///< null for intensity, which is planned if another effect or a field needs it
  bool (*needsIntensity)(const Effects&);
  const char* doc;  ///< the sentences of effects.hpp
  std::vector<Parameter<Effects>> parameters;
  /// Whether the parameters ask for nothing, such as a rate of 0; null if the effect has something to show with any.
  bool (*isZero)(const Effects&) = nullptr;
};

/// Returns all effects in the order of effectNames().
const std::vector<EffectInfo>& effectTable();

inline constexpr const char* kUseWords[] = {"off", "on", "auto"};

/// Returns Effects::seed as a row.
const Parameter<Effects>& seedParameter();

}  // namespace gnosphere
