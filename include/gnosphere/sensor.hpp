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
  /// Where the laser leaves the head, in metres: x points forward along the beam's azimuth, y left, z up.
  Vec3 origin;
  double timeOffset = 0;  ///< seconds between the column's time and the firing of this laser
};

/// A grid of beams. The beam in column i of channel j has the elevation `channels[j].elevationDeg` and the azimuth
/// -180 + 360 i / columns + `channels[j].azimuthOffsetDeg` degrees (counter-clockwise seen from above, 0 = x axis). It
/// leaves the sensor's origin, or `channels[j].origin` if that is not zero. Beam index = channel * columns + column:
/// the organised cloud has one row per channel.
struct Sensor {
  std::string name;
  uint32_t columns = 0;
  std::vector<Channel> channels;
  double rangeMin = 0;  ///< metres; a hit counts if rangeMin <= range <= rangeMax
  double rangeMax = 0;  ///< metres
  /// Full angles of a beam's elliptical footprint in radians (to 1/e^2 if its profile is gaussian); 0 makes it a line.
  double divergenceHorizontal = 0, divergenceVertical = 0;
  uint32_t maxReturns = 1;    ///< number of echoes that the sensor reports per beam, 1..5
  double rotationPeriod = 0;  ///< seconds; column i fires at i / columns of it. If 0, all beams fire at once

  size_t beamCount() const { return size_t{columns} * channels.size(); }
  /// Unit vector of a beam in the sensor's frame.
  GNOSPHERE_API Vec3 direction(size_t beam) const;
};

/// Throws Error(invalidArgument) that names the field if a sensor has zero columns, angles or ranges that are not
/// finite or out of bounds, divergences above 100 mrad, returns outside 1..5, origins beyond 1 m, a rotation period
/// above 10 s, time offsets above 1 s, or more beams than a 32-bit index holds. Zero channels are allowed: the cloud is
/// then empty.
GNOSPHERE_API void validate(const Sensor& sensor);

/// Returns the five models of Table 2 of the GnoSphere360 paper.
GNOSPHERE_API const std::vector<Sensor>& builtinSensors();

/// The built-in model of that name; case does not matter. Throws Error(invalidArgument) with the names that are known.
GNOSPHERE_API Sensor builtinSensor(const std::string& name);

/// Reads a sensor from a JSON file. Throws Error(file) or Error(format).
GNOSPHERE_API Sensor loadSensor(const std::filesystem::path& file);

/// Writes a sensor as JSON. sensorFromJson(toJson(s)) restores every field bit by bit, except that a divergence, which
/// JSON states in milliradians, may differ in its last bit.
GNOSPHERE_API std::string toJson(const Sensor& sensor);
/// Reads a sensor from JSON; `source` names the text in messages. Throws Error(format).
GNOSPHERE_API Sensor sensorFromJson(std::string_view json, const std::string& source);

}  // namespace gnosphere
