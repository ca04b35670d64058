// SPDX-License-Identifier: Apache-2.0
// Which scans a drive has, and when.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "drive/drive.hpp"

namespace gnosphere::drive {

/// One scan of a sensor of the rig.
struct PlannedScan {
  size_t sensor = 0;
  uint64_t number = 0;  ///< among the scans of its sensor; Shot::frame
  double time = 0;      ///< of its start, on the clock of the trajectories
};

/// The scans that start within a frame, in order of time, then of sensors. Scans depend on nothing but the drive file.
std::vector<PlannedScan> scansOf(const Drive& drive, uint64_t frame);

/// When a scan starts and ends, on the clock of the trajectories.
struct ScanSpan {
  double start = 0, end = 0;
};

/// Returns the span of the last scan of a sensor in the frames up to this one; none if it makes none.
std::optional<ScanSpan> lastScanOf(const Drive& drive, size_t sensor, uint64_t frame);

/// Returns when the last scan of the frames up to this one ends, on the clock of the trajectories, or the frame itself
/// if that is later.
double endOfScans(const Drive& drive, uint64_t frame);

}  // namespace gnosphere::drive
