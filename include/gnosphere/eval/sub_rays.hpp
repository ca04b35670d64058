// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "gnosphere/eval/accuracy.hpp"
#include "gnosphere/export.hpp"
#include "gnosphere/simulator.hpp"

namespace gnosphere {

/// Error and time of a footprint of so many sub-rays. Errors are those of beams that return something, both here and in
/// the truth. A return is compared with the return of the truth that is nearest in range. The base of the ratio is the
/// scan of geometry alone.
struct SubRayRow : RowTimes {
  uint32_t subRays = 0;             ///< 0: a scan of geometry alone, of which only the time is known
  uint64_t beams = 0;               ///< beams of which this footprint or the truth returns something
  double rangeErrorMax = 0;         ///< metres, of any return
  double rangeError999 = 0;         ///< metres; 99.9 % of the beams are not further off with any return
  double rangeErrorRms = 0;         ///< metres, over the returns
  double wrongRange = 0;            ///< share of the beams with a return that is off by more than the tolerance
  double wrongReturns = 0;          ///< share of the beams with another number of returns
  double wrong = 0;                 ///< share of the beams of which either is wrong
  double intensityErrorMedian = 0;  ///< relative; half of the returns are not further off
  double intensityError99 = 0;      ///< relative; 99 % of the returns are not further off
};

/// Error and time of each number of sub-rays, on one device.
struct SubRayReport {
  DeviceInfo device;
  uint64_t beams = 0;           ///< number of beams compared with the reference, over all poses
  bool sampled = false;         ///< true if only a sample of the beams was compared
  uint32_t runs = 0;            ///< number of timed runs per row
  uint32_t truth = 0;           ///< sub-rays of the reference
  double tolerance = 0;         ///< metres; it is the standard deviation of range noise where that is more
  std::string footprint;        ///< size of the footprint, as in the plan
  std::vector<SubRayRow> rows;  ///< geometry alone, then the counts in the order in which they were asked for
};

/// The options of a report on sub-rays.
struct SubRayOptions {
  SimulatorOptions simulator;
  std::vector<uint32_t> counts = {1, 7, 19, 37, 61};
  uint32_t truth = 331;  ///< sub-rays of the reference, on 10 rings
  /// metres by which a range may be off; with range noise, or its standard deviation (without that of weak echoes)
  double tolerance = 0.01;
  uint32_t runs = 10;       ///< timed scans per row; the rows take turns
  uint64_t sample = 5'000;  ///< number of beams per pose to compare, chosen at random; 0 compares every beam
  uint32_t seed = 1;        ///< seed of the choice of the sample
  std::function<void(const char* step, uint64_t done, uint64_t total)> progress;
};

/// Measures what footprints of fewer sub-rays cost and get wrong, from each of the poses, on one device, beside the
/// double-precision reference with many. All other effects of the request are simulated, too. Throws
/// Error(invalidArgument) if there is no pose, if the device is the reference, or if the request plans no divergence,
/// and whatever Simulator throws.
GNOSPHERE_API SubRayReport measureSubRays(const Scene& scene, const SensorRequest& request,
                                          const std::vector<Pose>& poses, const SubRayOptions& options = {});

}  // namespace gnosphere
