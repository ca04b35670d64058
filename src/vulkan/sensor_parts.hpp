// SPDX-License-Identifier: Apache-2.0
// A sensor with more beams than the device's largest buffer holds is scanned in parts: sensors with fewer channels.
#pragma once

#include "pipeline/outputs.hpp"
#include "vulkan/device.hpp"

namespace gnosphere::vulkan {

struct SensorParts {
  std::vector<Sensor> parts;         ///< runs of channels, of every sensor one after the other
  std::vector<uint64_t> firstBeams;  ///< of each part, in its sensor
  std::vector<size_t> firsts;        ///< the first part of each sensor, and the end of the last

  size_t count(size_t sensor) const { return firsts[sensor + 1] - firsts[sensor]; }
  /// Of any one sensor.
  size_t maxCount() const;
};

/// As few parts as fit, of nearly equal size. Throws Error(outOfMemory) where one channel does not fit.
SensorParts cutToFit(const std::vector<SensorPlan>& plans, const Device& device);

}  // namespace gnosphere::vulkan
