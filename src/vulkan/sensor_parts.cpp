// SPDX-License-Identifier: Apache-2.0
#include "vulkan/sensor_parts.hpp"

#include <algorithm>

#include "vulkan/sensor_state.hpp"

namespace gnosphere::vulkan {
namespace {

size_t partCount(const Sensor& sensor, const Device& device) {
  if (sensor.channels.empty()) return 1;
  uint64_t bytesPerBeam = sizeof(uint64_t);  // a word
  for (const Output& output : kOutputs) bytesPerBeam = std::max<uint64_t>(bytesPerBeam, output.bytesPerBeam);
  const uint64_t beams = device.maxBufferBytes() / bytesPerBeam, channels = beams / sensor.columns;
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

SensorParts cutToFit(const std::vector<Sensor>& sensors, const Device& device) {
  SensorParts result;
  result.firsts.push_back(0);
  for (const Sensor& sensor : sensors) {
    const size_t count = partCount(sensor, device);
    for (size_t i = 0; i < count; ++i) {
      const auto channel = [&](size_t part) {
        return sensor.channels.begin() + static_cast<ptrdiff_t>(sensor.channels.size() * part / count);
      };
      result.parts.push_back(sensor);
      result.parts.back().channels.assign(channel(i), channel(i + 1));
    }
    result.firsts.push_back(result.parts.size());
  }
  return result;
}

}  // namespace gnosphere::vulkan
