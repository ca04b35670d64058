// SPDX-License-Identifier: Apache-2.0
// Data that the readers of sensor files share: the file, its options, and the result that they fill in.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/text.hpp"
#include "gnosphere/error.hpp"
#include "gnosphere/sensor.hpp"

namespace gnosphere {

/// A sensor file that is being read.
struct SensorSource {
  std::string_view bytes;
  std::string name;  ///< of the file, as messages give it
  const SensorFileOptions& options;
  SensorFile& file;
  bool rateAsked = false;     ///< whether the caller states the scan rate, rather than the head that completes the file
  bool columnsAsked = false;  ///< the same of the columns

  /// Throws Error(format) with the name of the file. The reason may quote the file, which may have any bytes.
  [[noreturn]] void refuse(const std::string& why) const {
    throw Error(ErrorCode::format, name + ": " + plainAscii(why));
  }
  void assume(const std::string& what) { file.assumed.push_back(what); }
  void ignore(const std::string& what) { file.ignored.push_back(what); }
  /// Throws Error(invalidArgument) if an option is given, because it does not apply to `what`, the kind of the file.
  void refuseOption(bool given, const char* option, const char* what) const {
    if (given) throw Error(ErrorCode::invalidArgument, name + ": " + option + " does not apply to " + what);
  }
  /// Starts the scans of a file that states no rate as often as the caller says.
  void takeAskedRate() {
    if (rateAsked) file.sensor.scanPeriod = 1 / options.scanRate;
  }
};

/// The readers, one per family. Each fills in source.file.sensor but for its name, and throws Error(format).
void readVelodyneYaml(SensorSource& source);
void readVelodyneXml(SensorSource& source);
void readSdf(SensorSource& source);
void readHelios(SensorSource& source);
/// Says that an XML file is of no lidar.
void refuseXml(SensorSource& source);
void readIsaacUsd(SensorSource& source);
void readOuster(SensorSource& source, const nlohmann::json& root);
void readIsaac(SensorSource& source, const nlohmann::json& root);
void readCarla(SensorSource& source, const nlohmann::json& root);
void readHesaiCsv(SensorSource& source);
void readHesaiDat(SensorSource& source);
void readRobosenseCsv(SensorSource& source);
void readBeamCsv(SensorSource& source);
void readNpy(SensorSource& source);
void readRayMatrices(SensorSource& source);

/// One laser of a Velodyne calibration, in the file's sense: radians and metres.
struct VelodyneLaser {
  double rotCorrection = 0, vertCorrection = 0, vertOffset = 0, horizOffset = 0;
};
/// Makes the sensor of a Velodyne calibration. `distanceResolution` is in metres, or 0 if not stated.
void fromVelodyneLasers(SensorSource& source, std::vector<VelodyneLaser> lasers, double distanceResolution);

/// Firing times of a Hesai head: the times of channel c in columns of kind k are `seconds[k][c]`; a NaN does not fire.
/// Columns take the kinds in turn.
using FireTimes = std::vector<std::vector<double>>;
FireTimes readFireTimes(SensorSource& source, size_t channels);
/// Returns when the first beam fires, in seconds after the first column, and says so if it is before it; 0 if no beam
/// fires before the column.
double startOfScan(SensorSource& source, const FireTimes& times);

// Steps that several readers take.

/// Sets a turn from `startDeg` on, clockwise seen from above, of the columns and the scan rate that the options give,
/// or else the defaults, which are noted as assumed.
void setTurn(SensorSource& source, double startDeg);
/// Refuses a grid of more than 100 million beams, far more than any head has. A scan of more would take minutes to
/// prepare.
void checkBeamCount(const SensorSource& source, double columns, size_t channels);
/// Notes that the largest range is not stated, and takes `metres`.
void assumeRange(SensorSource& source, double metres, const std::string& why = "");
/// Adds the firing time of a channel, and the angle by which the head turns until then.
void delay(Channel& channel, double seconds, double degreesPerSecond);
/// Appends a direction to a list of beams. Refuses one that is not finite or has no length.
void addDirection(const SensorSource& source, BeamList& list, const Vec3& direction);
/// Unit vector of an azimuth, counter-clockwise from x, and an elevation in degrees. Refuses what is no angle.
Vec3 directionOfAngles(const SensorSource& source, double azimuthDeg, double elevationDeg, size_t beam);
/// Makes a list of beams the sensor's: as one pattern, or cut as SensorFileOptions::beamsPerScan says. Times that are
/// not those of one scan are left out, and beams without times spread over a scan if its rate is known.
void setBeams(SensorSource& source, BeamList list);
/// The same for lists that are patterns of their own.
void setPatterns(SensorSource& source, std::vector<BeamList> patterns);

/// Splits a text into lines without their ends, and a line into cells without surrounding spaces.
std::vector<std::string_view> linesOf(std::string_view text);
std::vector<std::string_view> cellsOf(std::string_view line);
/// Refuses a row whose cells beyond the first `expected` are not all empty; `where` names it in the message. Decimal
/// commas make such rows.
void refuseSurplus(const SensorSource& source, const std::vector<std::string_view>& cells, size_t expected,
                   const std::string& where);
/// Parses a finite number; `where` names it in the message, such as "line 3, Elevation".
double numberOf(const SensorSource& source, std::string_view text, const std::string& where);

/// A number for a message, as short as it can be.
std::string shownNumber(double value);

/// Numbers that are members of a JSON object. Every message names the key.
double numberIn(const SensorSource& source, const nlohmann::json& object, const std::string& key);
double numberIn(const SensorSource& source, const nlohmann::json& object, const std::string& key, double otherwise);
std::vector<double> numbersIn(const SensorSource& source, const nlohmann::json& object, const std::string& key);

}  // namespace gnosphere
