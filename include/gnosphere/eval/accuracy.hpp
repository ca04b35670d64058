// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "gnosphere/export.hpp"
#include "gnosphere/output.hpp"
#include "gnosphere/simulator.hpp"

namespace gnosphere {

/// Times of many runs, in milliseconds.
struct Spread {
  double median = 0, min = 0;
  double p10 = 0, p90 = 0;  ///< nearest rank
};

/// All zero for no values.
GNOSPHERE_API Spread spreadOf(std::vector<double> values);

/// Upper ends of the paper's bins (its Table 5), in metres; the last bin holds everything farther.
inline constexpr std::array<double, 7> kNearestBins = {0.2, 0.4, 0.6, 0.8, 1.2, 1.6, 2.0};
using NearestHistogram = std::array<uint64_t, kNearestBins.size() + 1>;

/// How far each point of `other` is from the nearest point of `reference`: an exact nearest neighbour. It says little
/// of a beam's own error, since a point may lie near the point of another beam; it is what the paper reports.
GNOSPHERE_API NearestHistogram nearestHistogram(const Scan& reference, const Scan& other);

/// What one setting of the dial gets wrong, and what it costs.
struct AccuracyRow {
  std::string name;
  AccuracyParts accuracyParts;
  Comparison error;  ///< against the double-precision reference, summed over the poses
  /// Beams of the reference that are lost, false or at another range, as a share of all beams; outside ties.
  GNOSPHERE_API double wrongShare() const;
  /// No beam outside ties is missed or false, and no range is further off than this; infinite otherwise.
  GNOSPHERE_API double errorBound() const;
  NearestHistogram nearest{};  ///< only of all beams, not of a sample
  Spread wallMs;
  Spread gpuMs;                   ///< zero where the device has no timestamps
  std::vector<StageTime> stages;  ///< medians
  double ratio = 1;               ///< of times to `standard`: the median of the ratios run by run
  /// Device time where there is one, else wall time.
  const Spread& time() const { return gpuMs.median > 0 ? gpuMs : wallMs; }
};

struct AccuracyReport {
  DeviceInfo device;
  uint64_t beams = 0;                 ///< compared with the reference, over all poses
  bool sampled = false;               ///< not every beam was
  uint32_t runs = 0;                  ///< timed, of each row
  std::vector<AccuracyRow> settings;  ///< paper, draft, standard, exact
  std::vector<AccuracyRow> parts;     ///< `standard` with one exactness taken away
};

struct AccuracyOptions {
  SimulatorOptions simulator;  ///< its `accuracy` and `exactness` are not looked at
  uint32_t runs = 20;          ///< timed scans of each row, one row after the other, over and over
  bool parts = true;           ///< measure what each exactness buys, too
  bool nearest = true;         ///< the paper's histogram, too
  uint64_t sample = 0;         ///< compare about so many beams per pose, chosen by seed; 0 = every beam
  uint32_t seed = 1;           ///< of the sample
  std::function<void(const char* step, uint64_t done, uint64_t total)> progress;
};

/// Measures error and time of every setting from each of the poses, on one device. Throws Error(invalidArgument) for no
/// pose or the reference as device; and what Simulator throws.
GNOSPHERE_API AccuracyReport measureAccuracy(const Scene& scene, const Sensor& sensor, const std::vector<Pose>& poses,
                                             const AccuracyOptions& options = {});

}  // namespace gnosphere
