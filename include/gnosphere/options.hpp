// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "gnosphere/export.hpp"
#include "gnosphere/simulator.hpp"

namespace gnosphere {

/// An accuracy setting with its name and parts.
struct AccuracySetting {
  Accuracy accuracy;
  const char* name;
  AccuracyParts parts;
  const char* doc;  ///< what it computes, and what it promises
};

/// Returns all accuracy settings, in the order of Accuracy.
GNOSPHERE_API std::span<const AccuracySetting> accuracySettings();

/// Sets an option by its name: "accuracy=exact", "tuning.binning=lists", "tuning.culling.rows=false". docs/options.md
/// lists the names, which are the members' in small letters. Throws Error(invalidArgument) that has the nearest known
/// names, or the values that the option takes; the options are then unchanged.
GNOSPHERE_API void assign(SimulatorOptions& options, const std::string& assignment);
/// As above, for the options of a sensor's request: "variable_weather=true", "ignored_instances=[3,4]".
GNOSPHERE_API void assign(SensorRequest& request, const std::string& assignment);

}  // namespace gnosphere
