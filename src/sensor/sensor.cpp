// SPDX-License-Identifier: Apache-2.0
#include "gnosphere/sensor.hpp"

#include <filesystem>

#include "base/file.hpp"
#include "base/text.hpp"
#include "gnosphere/error.hpp"
#include "sensor/beams.hpp"

namespace gnosphere {
namespace {

/// Sensors of Table 2 of the GnoSphere360 paper: elevations are evenly spaced, both ends included. Every angle is
/// rounded once, so a model that is symmetric about the horizon has exactly opposite channels.
Sensor evenSensor(const char* name, double lowestDeg, double highestDeg, uint32_t columns, uint32_t channels,
                  double rangeMax) {
  Sensor sensor;
  sensor.name = name;
  sensor.columns = columns;
  sensor.rangeMax = rangeMax;
  const double last = channels - 1;
  for (uint32_t j = 0; j < channels; ++j) {
    sensor.channels.push_back({(lowestDeg * (last - j) + highestDeg * j) / last, 0.0});
  }
  return sensor;
}

/// Size limit. The angle lists of the largest sensor models take a few megabytes.
constexpr size_t kMaxFileBytes = size_t{64} << 20;

}  // namespace

uint32_t Sensor::width() const {
  if (isGrid()) return columns;
  return patterns[0].width > 0 ? patterns[0].width : static_cast<uint32_t>(patterns[0].size());
}

uint32_t Sensor::height() const {
  if (isGrid()) return static_cast<uint32_t>(channels.size());
  return patterns[0].width > 0 ? patterns[0].height : 1;
}

Vec3 Sensor::direction(size_t beam) const {
  return directionOf(*this, beam, 0);
}

const std::vector<Sensor>& builtinSensors() {
  static const std::vector<Sensor> sensors = {
      evenSensor("VLP-16", -15, 15, 1800, 16, 100),
      evenSensor("VLP-32", -25, 15, 3600, 32, 100),
      evenSensor("HDL-64E", -25, 2, 4500, 64, 120),
      evenSensor("Hypothetical-256", -45, 45, 18000, 256, 200),
      evenSensor("Hypothetical-350", -45, 45, 18000, 350, 200),
  };
  return sensors;
}

Sensor builtinSensor(const std::string& name) {
  std::string names;
  for (const Sensor& sensor : builtinSensors()) {
    if (sameWord(sensor.name, name)) return sensor;
    names += (names.empty() ? "" : ", ") + sensor.name;
  }
  throw Error(ErrorCode::invalidArgument, "no built-in sensor is called '" + name + "'; known are " + names);
}

Sensor loadSensor(const std::filesystem::path& file) {
  return sensorFromJson(readWholeFile(file, kMaxFileBytes), file.string());
}

}  // namespace gnosphere
