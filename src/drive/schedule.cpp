// SPDX-License-Identifier: Apache-2.0
#include "drive/schedule.hpp"

#include <algorithm>
#include <cmath>

#include "sensor/beams.hpp"

namespace gnosphere::drive {
namespace {

/// The number of the first scan of a sensor that starts `time` seconds after the start of the drive, or later. A scan
/// that should start then is not lost by rounding.
uint64_t firstScan(const RigSensor& sensor, double time) {
  constexpr double kRounding = 1e-6;
  return static_cast<uint64_t>(std::max(0.0, std::ceil((time - sensor.offset) * sensor.rate - kRounding)));
}

/// Seconds after the start of the drive at which a frame ends.
double endOf(const Drive& drive, uint64_t frame) {
  return std::min(static_cast<double>(frame + 1) / drive.rate, drive.duration);
}

double startOf(const Drive& drive, const RigSensor& sensor, uint64_t number) {
  return drive.start + sensor.offset + static_cast<double>(number) / sensor.rate;
}

}  // namespace

std::vector<PlannedScan> scansOf(const Drive& drive, uint64_t frame) {
  std::vector<PlannedScan> scans;
  const double begin = static_cast<double>(frame) / drive.rate, end = endOf(drive, frame);
  for (size_t s = 0; s < drive.sensors.size(); ++s) {
    const RigSensor& sensor = drive.sensors[s];
    const uint64_t last = firstScan(sensor, end);
    for (uint64_t number = firstScan(sensor, begin); number < last; ++number)
      scans.push_back({s, number, startOf(drive, sensor, number)});
  }
  std::stable_sort(scans.begin(), scans.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  return scans;
}

std::optional<ScanSpan> lastScanOf(const Drive& drive, size_t sensor, uint64_t frame) {
  const RigSensor& rigged = drive.sensors[sensor];
  const uint64_t count = firstScan(rigged, endOf(drive, frame));
  if (count == 0) return {};
  const double start = startOf(drive, rigged, count - 1);
  return ScanSpan{start, start + durationOf(rigged.sensor, count - 1)};
}

double endOfScans(const Drive& drive, uint64_t frame) {
  double end = drive.start + endOf(drive, frame);
  for (size_t s = 0; s < drive.sensors.size(); ++s)
    if (const auto last = lastScanOf(drive, s, frame)) end = std::max(end, last->end);
  return end;
}

}  // namespace gnosphere::drive
