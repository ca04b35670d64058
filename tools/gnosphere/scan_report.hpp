// SPDX-License-Identifier: Apache-2.0
// The report of a scan: a summary for people, --stats for programs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "gnosphere/gnosphere.hpp"
#include "json.hpp"
#include "max_error.hpp"
#include "scan_trajectory.hpp"

namespace gnosphere::cli {

/// All data of the report, after the last run.
struct ScanReport {
  std::string sceneFile;
  const Scene& scene;
  const Sensor& sensor;
  std::string head;  ///< what follows the sensor's name: which built-in head it is; empty for a sensor of a file
  const Simulator& simulator;
  Scan scan;             ///< the last scan, or summaryOf() a trajectory
  std::string accuracy;  ///< as requested
  std::vector<Timings> runs;
  std::vector<TrajectoryScan> trajectory;  ///< only with --trajectory
  double loadMs = 0, setUpMs = 0;
  const AccuracyChoice* choice = nullptr;  ///< only with --max-error
  std::string media;                       ///< the effects whose particles give returns; empty without any
  uint64_t ofMedium = 0;                   ///< beams whose returns all come from these
  double totalMs = 0;                      ///< all scans, including writing files
  Json madeBy;                             ///< what another person needs to make the scan anew; only for --stats
};

void printSummary(const ScanReport& report);
std::string statsJson(const ScanReport& report);

}  // namespace gnosphere::cli
