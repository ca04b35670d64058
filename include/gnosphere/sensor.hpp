// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "gnosphere/export.hpp"
#include "gnosphere/scene.hpp"

namespace gnosphere {

/// One laser of a spinning sensor.
struct Channel {
  double elevationDeg = 0;      ///< above the horizon, -90..90
  double azimuthOffsetDeg = 0;  ///< added to the column's azimuth
  /// Where the laser leaves the head, metres: x forward along the beam's azimuth, y left, z up.
  Vec3 origin;
  double timeOffset = 0;  ///< seconds after its column's time
};

/// A grid of beams that all leave the sensor's origin. Column i of channel j points at elevation `elevationDeg[j]` and
/// azimuth -180 + 360 i / columns + `azimuthOffsetDeg[j]` degrees (counter-clockwise seen from above, 0 = x axis).
/// Beam index = channel * columns + column: the organised cloud has one row per channel.
struct Sensor {
  std::string name;
  uint32_t columns = 0;
  std::vector<Channel> channels;
  double rangeMin = 0;  ///< metres; a hit counts if rangeMin <= range <= rangeMax
  double rangeMax = 0;  ///< metres
  /// Full angles of a beam's elliptical footprint, radians (1/e^2 where its profile is gaussian); 0: a line.
  double divergenceHorizontal = 0, divergenceVertical = 0;
  uint32_t maxReturns = 1;    ///< echoes that the sensor reports per beam, 1..5
  double rotationPeriod = 0;  ///< seconds: column i fires at i / columns of it; 0: all beams fire at once

  size_t beamCount() const { return size_t{columns} * channels.size(); }
  /// Unit vector of a beam in the sensor's frame.
  GNOSPHERE_API Vec3 direction(size_t beam) const;
};

/// Throws Error(invalidArgument) that names the field: zero columns, angles or ranges that are not finite or out of
/// bounds, divergences beyond 100 mrad, returns beyond 1..5, origins beyond 1 m, a rotation beyond 10 s, time offsets
/// beyond 1 s, more beams than a 32-bit index holds. Zero channels are allowed: the cloud is empty.
GNOSPHERE_API void validate(const Sensor& sensor);

/// The five models of Table 2 of the GnoSphere360 paper.
GNOSPHERE_API const std::vector<Sensor>& builtinSensors();

/// The built-in model of that name; case does not matter. Throws Error(invalidArgument) with the names that are known.
GNOSPHERE_API Sensor builtinSensor(const std::string& name);

/// Reads a sensor from a JSON file. Throws Error(file) or Error(format).
GNOSPHERE_API Sensor loadSensor(const std::filesystem::path& file);

/// JSON of a sensor; sensorFromJson(toJson(s)) has the same bytes in every field (a divergence, stated in milliradians,
/// may lose its last bit).
GNOSPHERE_API std::string toJson(const Sensor& sensor);
GNOSPHERE_API Sensor sensorFromJson(std::string_view json, const std::string& source);

}  // namespace gnosphere
