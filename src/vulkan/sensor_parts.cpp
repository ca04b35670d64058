// SPDX-License-Identifier: Apache-2.0
#include "vulkan/sensor_parts.hpp"

#include <algorithm>

namespace gnosphere::vulkan {
namespace {

size_t partCount(const Sensor& sensor, uint64_t beamBytes, const Device& device) {
  if (sensor.channels.empty()) return 1;
  const uint64_t beams = device.maxBufferBytes() / beamBytes, channels = beams / sensor.columns;
  if (channels == 0)
    throw Error(ErrorCode::outOfMemory, "sensor '" + sensor.name + "' has " + std::to_string(sensor.columns) +
                                            " columns; one buffer of the device '" + device.capabilities().info.name +
                                            "' holds " + std::to_string(beams) + " beams, less than one channel");
  return (sensor.channels.size() + channels - 1) / channels;
}

}  // namespace

size_t SensorParts::maxCount() const {
  size_t most = 0;
  for (size_t sensor = 0; sensor + 1 < firsts.size(); ++sensor) most = std::max(most, count(sensor));
  return most;
}

SensorParts cutToFit(const std::vector<SensorPlan>& plans, const Device& device) {
  SensorParts result;
  result.firsts.push_back(0);
  for (const SensorPlan& plan : plans) {
    const Sensor& sensor = plan.sensor;
    const size_t count = partCount(sensor, mostBytesPerBeam(plan), device);
    for (size_t i = 0; i < count; ++i) {
      const auto channel = [&](size_t part) {
        return sensor.channels.begin() + static_cast<ptrdiff_t>(sensor.channels.size() * part / count);
      };
      result.parts.push_back(sensor);
      result.parts.back().channels.assign(channel(i), channel(i + 1));
      result.firstBeams.push_back(size_t{sensor.columns} * (sensor.channels.size() * i / count));
    }
    result.firsts.push_back(result.parts.size());
  }
  return result;
}

}  // namespace gnosphere::vulkan
