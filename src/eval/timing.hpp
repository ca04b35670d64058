// SPDX-License-Identifier: Apache-2.0
// The parts that the reports share: the settings of their simulators, and the times of rows that take turns.
#pragma once

#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "gnosphere/eval/accuracy.hpp"

namespace gnosphere {

/// Returns the settings of a report's simulators, which time whole scans, without reuse of still instances. The
/// simulators have the same scene, so each would give the same warnings, which the settings hand on once.
inline SimulatorOptions settingsOf(SimulatorOptions options) {
  options.tuning.keepStill = false;
  if (options.warn)
    options.warn = [warn = options.warn, told = std::make_shared<std::set<std::string>>()](const std::string& message) {
      if (told->insert(message).second) warn(message);
    };
  return options;
}

/// Scans once with each row in turn, so that other load of the machine affects all rows alike. The poses are spread
/// over the runs. `scan(row, pose)` returns the timings of a scan. Returns the timings by row and run.
template <class ScanRow>
std::vector<std::vector<Timings>> timeInTurn(size_t rows, size_t poses, uint32_t runs,
                                             const std::function<void(const char*, uint64_t, uint64_t)>& progress,
                                             ScanRow scan) {
  std::vector<std::vector<Timings>> timings(rows);
  for (uint32_t run = 0; run < runs; ++run) {
    if (progress) progress("time run", run + 1, runs);
    const size_t pose = poses <= runs ? run % poses : run * poses / runs;
    for (size_t row = 0; row < rows; ++row) timings[row].push_back(scan(row, pose));
  }
  return timings;
}

/// Computes the spreads of a row's timings, and its ratio to the timings of `base` in the same runs.
inline void storeTimes(const std::vector<Timings>& runs, const std::vector<Timings>& base, RowTimes& row) {
  std::vector<double> wall, gpu, ratios;
  for (size_t run = 0; run < runs.size(); ++run) {
    wall.push_back(runs[run].wallMs);
    gpu.push_back(runs[run].gpuMs);
    const bool stamped = base[run].gpuMs > 0;
    ratios.push_back(stamped ? runs[run].gpuMs / base[run].gpuMs : runs[run].wallMs / base[run].wallMs);
  }
  row.wallMs = spreadOf(wall);
  row.gpuMs = spreadOf(gpu);
  row.ratio = spreadOf(ratios);
}

}  // namespace gnosphere
