// SPDX-License-Identifier: Apache-2.0
#include "gnosphere/sensor.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "base/file.hpp"
#include "base/text.hpp"
#include "gnosphere/error.hpp"
#include "sensor/beams.hpp"

namespace gnosphere {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

struct SinCos {
  double sin, cos;
};

/// Reduces the angle in degrees, where 90 is exact: axes and diagonals come out exact, and every quadrant has the same
/// bits.
SinCos sinCosDegrees(double degrees) {
  int quadrant = 0;
  const double rest = std::remquo(degrees, 90.0, &quadrant);
  const double s = std::sin(rest * std::numbers::pi / 180);
  const double c = std::cos(rest * std::numbers::pi / 180);
  switch (quadrant & 3) {
    case 0: return {s, c};
    case 1: return {c, -s};
    case 2: return {-s, -c};
    default: return {-c, s};
  }
}

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

[[noreturn]] void refuse(const Sensor& sensor, const std::string& why) {
  throw Error(ErrorCode::invalidArgument,
              "sensor " + (sensor.name.empty() ? "without a name" : sensor.name) + ": " + why);
}

/// Size limit. The angle lists of the largest sensor models take a few megabytes.
constexpr size_t kMaxFileBytes = size_t{64} << 20;

}  // namespace

Vec3 Sensor::direction(size_t beam) const {
  const Channel& channel = channels[beam / columns];
  const auto column = static_cast<double>(beam % columns);
  // -180 + 360 i / columns is rounded once, then reduced to one turn before it becomes radians.
  const double columnDeg = (360.0 * column - 180.0 * columns) / columns;
  const SinCos azimuth = sinCosDegrees(std::remainder(columnDeg + channel.azimuthOffsetDeg, 360.0));
  const SinCos elevation = sinCosDegrees(channel.elevationDeg);
  return {elevation.cos * azimuth.cos, elevation.cos * azimuth.sin, elevation.sin};
}

void validate(const Sensor& sensor) {
  if (sensor.columns == 0) refuse(sensor, "columns must be at least 1");
  if (sensor.beamCount() > 0xfffffffeu) {
    refuse(sensor, std::to_string(sensor.columns) + " columns x " + std::to_string(sensor.channels.size()) +
                       " channels are more beams than a 32-bit index holds (4294967294)");
  }
  for (size_t j = 0; j < sensor.channels.size(); ++j) {
    const Channel& channel = sensor.channels[j];
    if (!(std::abs(channel.elevationDeg) <= 90)) {
      refuse(sensor, "elevation of channel " + std::to_string(j) + " must be within -90..90 degrees, is " +
                         std::to_string(channel.elevationDeg));
    }
    if (!(std::abs(channel.azimuthOffsetDeg) <= 360)) {
      refuse(sensor, "azimuth offset of channel " + std::to_string(j) + " must be within -360..360 degrees, is " +
                         std::to_string(channel.azimuthOffsetDeg));
    }
    const Vec3& o = channel.origin;
    if (!(o.x * o.x + o.y * o.y + o.z * o.z <= 1)) {
      refuse(sensor, "origin of channel " + std::to_string(j) + " must be within 1 m of the sensor's, is [" +
                         std::to_string(o.x) + ", " + std::to_string(o.y) + ", " + std::to_string(o.z) + "]");
    }
    if (!(std::abs(channel.timeOffset) <= 1)) {
      refuse(sensor, "time offset of channel " + std::to_string(j) + " must be within -1..1 s, is " +
                         std::to_string(channel.timeOffset));
    }
  }
  if (!std::isfinite(sensor.rangeMin) || sensor.rangeMin < 0) refuse(sensor, "range min must be finite and at least 0");
  if (!std::isfinite(sensor.rangeMax)) refuse(sensor, "range max must be finite");
  if (sensor.rangeMin > sensor.rangeMax) {
    refuse(sensor,
           "range min " + std::to_string(sensor.rangeMin) + " is beyond range max " + std::to_string(sensor.rangeMax));
  }
  for (double divergence : {sensor.divergenceHorizontal, sensor.divergenceVertical}) {
    if (!(divergence >= 0 && divergence <= 0.1)) {
      refuse(sensor, "divergence must be within 0..100 mrad, is " + std::to_string(1000 * divergence));
    }
  }
  if (sensor.maxReturns < 1 || sensor.maxReturns > 5) {
    refuse(sensor, "max returns must be within 1..5, is " + std::to_string(sensor.maxReturns));
  }
  if (!(sensor.rotationPeriod >= 0 && sensor.rotationPeriod <= 10)) {
    refuse(sensor, "rotation period must be within 0..10 s, is " + std::to_string(sensor.rotationPeriod));
  }
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

double timeOf(const Sensor& sensor, size_t beam) {
  const size_t column = beam % sensor.columns, channel = beam / sensor.columns;
  return sensor.rotationPeriod * static_cast<double>(column) / sensor.columns + sensor.channels[channel].timeOffset;
}

double azimuthOf(const Sensor& sensor, size_t beam) {
  const double column = -180 + 360.0 * static_cast<double>(beam % sensor.columns) / sensor.columns;
  const double degrees = column + sensor.channels[beam / sensor.columns].azimuthOffsetDeg;
  return kDegree * std::remainder(degrees, 360);
}

double elevationOf(const Sensor& sensor, size_t beam) {
  return kDegree * sensor.channels[beam / sensor.columns].elevationDeg;
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
