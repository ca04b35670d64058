// SPDX-License-Identifier: Apache-2.0
// scan --max-error: chooses the fastest setting whose error is within a limit.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "gnosphere/eval/accuracy.hpp"
#include "scanning.hpp"

namespace gnosphere::cli {

/// The chosen setting and the figures behind the choice.
struct AccuracyChoice {
  std::optional<AccuracyRow> chosen;  ///< none: no setting is within the limit
  AccuracyReport report;
  double limit = 0;  ///< metres
  std::string why;   ///< a line that explains the result, whether a setting was chosen or not
};

/// Returns the first setting of `byTime`, which starts with the fastest, whose error is at most `limit` metres and
/// which loses no beam between triangles. The result is `standard` unless another setting is clearly faster.
std::optional<AccuracyRow> cheapestWithin(double limit, const std::vector<AccuracyRow>& byTime);

/// Throws Error(invalidArgument) for a limit that is negative or not finite.
void checkMaxError(double limit);

/// Measures every setting on a sample of the beams and tries them from the fastest to the slowest.
AccuracyChoice chooseAccuracy(const Scene& scene, const Sensor& sensor, const Pose& pose,
                              const SimulatorOptions& options, double limit);

}  // namespace gnosphere::cli
