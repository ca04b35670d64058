// SPDX-License-Identifier: Apache-2.0
// scan --max-error: the cheapest setting that is right enough.
#pragma once

#include <optional>
#include <string>

#include "scanning.hpp"

namespace gnosphere::cli {

/// What was chosen and the figures that say why.
struct AccuracyChoice {
  std::optional<AccuracyRow> chosen;  ///< none: no setting is within the limit
  AccuracyReport report;
  double limit = 0;  ///< metres
  std::string why;   ///< a line for people, whether one was chosen or not
};

/// Throws Error(invalidArgument) for a limit that is negative or not finite.
void checkMaxError(double limit);

/// Measures every setting on a sample of the beams and goes from the cheapest to the dearest.
AccuracyChoice chooseAccuracy(const Scene& scene, const Sensor& sensor, const Pose& pose,
                              const SimulatorOptions& options, double limit);

}  // namespace gnosphere::cli
