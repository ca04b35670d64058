// SPDX-License-Identifier: Apache-2.0
// What a scan tells about itself: a summary for people, --stats for programs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "gnosphere/gnosphere.hpp"
#include "max_error.hpp"
#include "scan_trajectory.hpp"

namespace gnosphere::cli {

/// Everything there is to tell after the last run.
struct ScanReport {
  std::string sceneFile;
  const Scene& scene;
  const Sensor& sensor;
  const Simulator& simulator;
  Scan scan;                      ///< the last, or summaryOf() a trajectory
  std::string accuracy, binning;  ///< as asked for
  std::vector<Timings> runs;
  std::vector<TrajectoryScan> trajectory;  ///< of --trajectory, where it was given
  double loadMs = 0, setUpMs = 0;
  const AccuracyChoice* choice = nullptr;  ///< of --max-error, where it was given
  double totalMs = 0;                      ///< all scans, files written
};

void printSummary(const ScanReport& report);
std::string statsJson(const ScanReport& report);

}  // namespace gnosphere::cli
