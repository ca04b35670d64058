// SPDX-License-Identifier: Apache-2.0
#include "drive/schedule.hpp"

#include <algorithm>
#include <cmath>

namespace gnosphere::drive {
namespace {

/// The number of the first scan of a sensor that starts `time` seconds after the start of the drive, or later. A scan
/// that should start then is not lost by rounding.
uint64_t firstScan(const RigSensor& sensor, double time) {
  constexpr double kRounding = 1e-6;
  return static_cast<uint64_t>(std::max(0.0, std::ceil((time - sensor.offset) * sensor.rate - kRounding)));
}

}  // namespace

std::vector<PlannedScan> scansOf(const Drive& drive, uint64_t frame) {
  std::vector<PlannedScan> scans;
  const double begin = static_cast<double>(frame) / drive.rate,
               end = std::min(static_cast<double>(frame + 1) / drive.rate, drive.duration);
  for (size_t s = 0; s < drive.sensors.size(); ++s) {
    const RigSensor& sensor = drive.sensors[s];
    const uint64_t last = firstScan(sensor, end);
    for (uint64_t number = firstScan(sensor, begin); number < last; ++number)
      scans.push_back({s, number, drive.start + sensor.offset + static_cast<double>(number) / sensor.rate});
  }
  std::stable_sort(scans.begin(), scans.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  return scans;
}

}  // namespace gnosphere::drive
