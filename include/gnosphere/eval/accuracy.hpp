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
  double p10 = 0, p90 = 0;  ///< 10th and 90th percentile by the nearest-rank method
};

/// Computes the statistics of `values`; all are zero if there are no values.
GNOSPHERE_API Spread spreadOf(std::vector<double> values);

/// Times of one row of a report.
struct RowTimes {
  Spread wallMs;
  Spread gpuMs;                 ///< all zero if the device has no timestamps
  Spread ratio = {1, 1, 1, 1};  ///< over the runs: time relative to that of the report's base in the same run
  /// Returns the device time if it was measured, otherwise the wall time.
  const Spread& time() const { return gpuMs.median > 0 ? gpuMs : wallMs; }
};

/// Upper ends of the paper's bins (its Table 5), in metres; the last bin holds everything farther.
inline constexpr std::array<double, 7> kNearestBins = {0.2, 0.4, 0.6, 0.8, 1.2, 1.6, 2.0};
using NearestHistogram = std::array<uint64_t, kNearestBins.size() + 1>;

/// Counts the points of `other` by their distance from the nearest point of `reference` (exact nearest neighbour), in
/// the bins of kNearestBins. The paper reports this measure. The measure says little about the error of a single beam,
/// because a wrong point may lie near the point of another beam.
GNOSPHERE_API NearestHistogram nearestHistogram(const Scan& reference, const Scan& other);

/// Error and time of one accuracy setting; the base of its ratio is `standard`.
struct AccuracyRow : RowTimes {
  std::string name;
  AccuracyParts accuracyParts;
  Comparison error;  ///< against the double-precision reference, summed over the poses
  /// Share of all beams that are missed, falsely hit or at a wrong range, without ties.
  GNOSPHERE_API double wrongShare() const;
  /// Largest range error in metres if no beam is missed or falsely hit, without ties; infinity otherwise, and if all
  /// hits are ties.
  GNOSPHERE_API double errorBound() const;
  NearestHistogram nearest{};     ///< all zero if only a sample of the beams was compared
  std::vector<StageTime> stages;  ///< median time of each stage
};

/// Error and time of each accuracy setting, on one device.
struct AccuracyReport {
  DeviceInfo device;
  uint64_t beams = 0;                 ///< number of beams compared with the reference, over all poses
  bool sampled = false;               ///< true if only a sample of the beams was compared
  uint32_t runs = 0;                  ///< number of timed runs per row
  std::vector<AccuracyRow> settings;  ///< paper (unless it is left out), draft, standard, exact
  /// Why `paper` is not among the settings; empty if it is. The paper knows only even grids of a full turn.
  std::string withoutPaper;
  std::vector<AccuracyRow> parts;  ///< `standard` with one part replaced by a less accurate one
};

/// The options of an accuracy report.
struct AccuracyOptions {
  SimulatorOptions simulator;  ///< its `accuracy` and `accuracyParts` are ignored
  uint32_t runs = 20;   ///< timed scans per row; the rows take turns, so that slow drifts affect all of them alike
  bool parts = true;    ///< also measures the rows AccuracyReport::parts
  bool nearest = true;  ///< also computes the paper's histogram, AccuracyRow::nearest
  uint64_t sample = 0;  ///< approximate number of beams per pose to compare, chosen at random; 0 compares every beam
  uint32_t seed = 1;    ///< seed of the choice of the sample
  std::function<void(const char* step, uint64_t done, uint64_t total)> progress;
};

/// Measures the error and the time of every setting from each of the poses, on one device. Throws
/// Error(invalidArgument) if there is no pose or if the device is the reference, and whatever Simulator throws.
GNOSPHERE_API AccuracyReport measureAccuracy(const Scene& scene, const Sensor& sensor, const std::vector<Pose>& poses,
                                             const AccuracyOptions& options = {});

}  // namespace gnosphere
