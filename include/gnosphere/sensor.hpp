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
  /// Metres; if greater than 0, these replace the sensor's rangeMin and rangeMax for this laser.
  double rangeMin = 0, rangeMax = 0;
};

/// Beams in any directions, in the order in which a scan lists them: the beam in row r and column c of the organised
/// cloud has the index r * width + c. `directions` has one entry per beam. Every other list has as many entries or
/// none; then the value in its comment holds for all beams. Where the organised cloud has gaps, Sensor::maskedBeams
/// names them.
struct BeamList {
  std::vector<Vec3> directions;    ///< unit vectors in the sensor's frame; validate() accepts lengths of 1 +- 1e-4
  std::vector<Vec3> origins;       ///< metres in the sensor's frame, at most 1 km from its origin; if empty, its origin
  std::vector<double> times;       ///< seconds from the scan's start, 0..10, the last 0 or at least 1e-9; if empty, 0
  std::vector<float> rangeMin;     ///< metres; if empty, the sensor's
  std::vector<float> rangeMax;     ///< metres; if empty, the sensor's
  std::vector<uint16_t> rings;     ///< values of Field::ring; if empty, 0
  uint32_t width = 0, height = 0;  ///< of the organised cloud; if 0, it has one row of all beams

  size_t size() const { return directions.size(); }
};

/// Treatment of a surface that is nearer than a beam's least range.
enum class NearHits {
  seeThrough,  ///< the beam passes through and hits what is behind
  hide,        ///< the surface blocks the beam, which has no return
};

/// A lidar: a grid of beams, or lists of beams.
///
/// In a grid, the beam in column i of channel j has the elevation `channels[j].elevationDeg` and the azimuth
/// `azimuthStartDeg` + `azimuthSpanDeg` i / columns + `channels[j].azimuthOffsetDeg` degrees (counter-clockwise seen
/// from above, 0 = x axis). The beam leaves the sensor's origin, or `channels[j].origin` if that is not zero. Beam
/// index = channel * columns + column: the organised cloud has one row per channel.
///
/// If `patterns` is not empty, the beams are those of a list: scan number n (Shot::frame) uses pattern n modulo their
/// number. All patterns have the same number of beams; columns and channels must be 0 and empty.
struct Sensor {
  std::string name;
  uint32_t columns = 0;
  std::vector<Channel> channels;
  double rangeMin = 0;  ///< metres; a hit counts if rangeMin <= range <= rangeMax
  double rangeMax = 0;  ///< metres
  /// Full angles of a beam's elliptical footprint in radians (to 1/e^2 if its profile is gaussian); 0 makes it a line.
  double divergenceHorizontal = 0, divergenceVertical = 0;
  uint32_t maxReturns = 1;  ///< number of echoes that the sensor reports per beam, 1..15
  /// Seconds in which a grid sweeps azimuthSpanDeg, less than those of a turn if that is a sector: column i fires at
  /// i / columns of them. If 0, all columns fire at once. The beams of a list fire at BeamList::times.
  double rotationPeriod = 0;
  /// Azimuths that the columns cover, at most 360 degrees; negative if the head turns clockwise.
  double azimuthStartDeg = -180, azimuthSpanDeg = 360;
  NearHits nearHits = NearHits::seeThrough;
  std::vector<uint32_t> maskedBeams;  ///< indices of beams that never fire; their entries in a scan have no return
  std::vector<BeamList> patterns;
  /// Metres from which on a Lambertian target that reflects 10 % is no longer detected; 0 if this is not stated.
  double rangeAt10Percent = 0;
  /// Seconds from the start of a scan to that of the next, at least those in which its beams fire; if 0, this is not
  /// stated, and the scans of a grid follow each other every rotationPeriod.
  double scanPeriod = 0;

  bool isGrid() const { return patterns.empty(); }
  size_t beamCount() const { return isGrid() ? size_t{columns} * channels.size() : patterns[0].size(); }
  /// Columns of the organised cloud.
  GNOSPHERE_API uint32_t width() const;
  /// Rows of the organised cloud: the channels of a grid.
  GNOSPHERE_API uint32_t height() const;
  /// Unit vector of a beam in the sensor's frame, for a list in its first pattern.
  GNOSPHERE_API Vec3 direction(size_t beam) const;
};

/// Returns the beams that scan number `frame` fires, for any sensor. The lists `origins`, `times`, `rangeMin` and
/// `rangeMax` are empty if all beams have the value that an empty list stands for.
GNOSPHERE_API BeamList beamsOf(const Sensor& sensor, uint64_t frame = 0);

/// Throws Error(invalidArgument) that names the field if a sensor has zero columns, angles or ranges that are not
/// finite or out of bounds, divergences above 100 mrad, returns outside 1..15, a channel's origin beyond 1 m or a
/// listed beam's beyond 1 km, a rotation period above 10 s or, unless it is 0, below 1e-9 s, a scan period that is not
/// finite or shorter than a scan, time offsets above 1 s or a rotation period, a channel whose own range window is
/// empty, lists of unequal lengths, patterns of unequal sizes or without beams, organised clouds of another size, or
/// more than 2,147,483,647 beams. Zero channels are allowed, but not in a file: the cloud is then empty.
GNOSPHERE_API void validate(const Sensor& sensor);

/// Returns the five models of Table 2 of the GnoSphere360 paper.
GNOSPHERE_API const std::vector<Sensor>& builtinSensors();

/// A real head of the catalogue. An empty text or a 0 means that its source does not state it.
struct CatalogueHead {
  std::string name;                ///< such as "OS1-64"; builtinSensor() takes it, or "OS1-64:2048x10"
  std::string product;             ///< vendor and product
  std::vector<std::string> modes;  ///< the first one is the default; none if the head has one mode only
  std::string source;              ///< documents from which the figures are
  std::string remarks;             ///< what the model simplifies, and what the source does not state
  double rangeAt10Percent = 0;     ///< Sensor::rangeAt10Percent
};

/// Returns the real heads that are built in.
GNOSPHERE_API const std::vector<CatalogueHead>& sensorCatalogue();

/// The built-in model of that name, one of builtinSensors() or of sensorCatalogue(), the latter with ":MODE" if wanted;
/// case does not matter. Throws Error(invalidArgument) with the nearest names, or the modes that are known.
GNOSPHERE_API Sensor builtinSensor(const std::string& name);

/// Values for what a sensor file leaves open.
struct SensorFileOptions {
  /// Name of a built-in sensor. Calibration files state angles only, so they take its ranges, divergence and returns;
  /// of a grid with as many channels also the columns, the rotation, the firing times, and the origins if they have
  /// none; of a list the beams per scan. Other files take the range at 10 % and the divergence that they do not state.
  std::string head;
  /// One of several that a file describes: a lidar mode (Ouster), the name of a sensor (SDF), the id of a scanner
  /// (HELIOS++), with ":RATE" for its pulses a second if wanted, or of a lidar (CARLA), an operational state (firing
  /// times of Hesai). If empty, that of the file, or its first.
  std::string mode;
  /// Scans per second; if 0, what the file or the head states, or else 10. Of a mirror that sweeps lines (HELIOS++) a
  /// scan is one period if this is 0.
  double scanRate = 0;
  /// Columns of a turn, or pulses in a mirror's period; if 0, what the file or the head states, or else 1800.
  uint32_t columns = 0;
  uint32_t beamsPerScan = 0;        ///< cuts a list of beams into patterns of that many; if 0, a scan fires all of them
  std::filesystem::path fireTimes;  ///< Hesai's file of firing times that goes with an angle correction file
};

/// A sensor file, and how it was understood.
struct SensorFile {
  Sensor sensor;
  std::string family;                ///< such as "Ouster metadata"
  std::vector<std::string> assumed;  ///< what the file does not state, and the value that was taken
  std::vector<std::string> ignored;  ///< what the file states, and a Sensor does not hold
};

/// Reads a sensor file of any family that docs/sensors.md lists. The content decides which family it is. Throws
/// Error(file) if it cannot be read, and Error(format) if its content is bad or belies the ending of its name.
GNOSPHERE_API SensorFile readSensorFile(const std::filesystem::path& file, const SensorFileOptions& options = {});
/// Reads a sensor file from memory; the ending of `name` says what it is expected to be.
GNOSPHERE_API SensorFile readSensorFile(std::string_view bytes, const std::string& name,
                                        const SensorFileOptions& options = {});

/// Writes a sensor as JSON. sensorFromJson(toJson(s)) restores every field bit by bit, except that a divergence, which
/// JSON states in milliradians, may differ in its last bit.
GNOSPHERE_API std::string toJson(const Sensor& sensor);
/// Reads a sensor from JSON; `source` names the text in messages. Throws Error(format) if the text is invalid.
GNOSPHERE_API Sensor sensorFromJson(std::string_view json, const std::string& source);

}  // namespace gnosphere
