// SPDX-License-Identifier: Apache-2.0
// Reads a drive file that fits the schema. Mistakes are collected, so that all of them are told at once.
#pragma once

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "base/json_text.hpp"
#include "base/nearest_text.hpp"
#include "base/path.hpp"
#include "drive/drive.hpp"
#include "drive/schema_check.hpp"
#include "drive/standing.hpp"

namespace gnosphere::drive {

/// Whether names that become parts of paths may have this character: letters of ASCII, digits, _ and -.
inline bool isPlain(unsigned char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
}

class DriveReader {
 public:
  /// The member `name` of `root`, which is the content of the drive file, must be set.
  DriveReader(const std::filesystem::path& file, const nlohmann::json& root)
      : folder_(file.parent_path()), root_(root) {
    drive_.name = root["name"].get<std::string>();
  }

  /// Returns the drive, or throws Error(format) with all mistakes.
  Drive read(const std::filesystem::path& file);

 private:
  /// Makes an Error that a step throws a mistake at this path.
  template <typename Step>
  void attempt(const std::string& path, const Step& step) {
    try {
      step();
    } catch (const Error& error) {
      mistakes_.push_back(path + ": " + error.what());
    }
  }
  void refuse(const std::string& path, const std::string& why) { mistakes_.push_back(path + ": " + why); }
  void warn(const std::string& path, const std::string& why);
  /// Returns the path of a file from its path in the drive file, which starts at the folder of that file.
  std::filesystem::path place(const std::string& name) const { return folder_ / pathOf(name); }
  /// Returns the same path of a file that is going to be read, and adds the file to the inputs of the drive.
  std::filesystem::path file(const std::string& name) { return drive_.inputs[name] = place(name); }

  /// Returns the index of a name, or adds a mistake.
  size_t find(const std::vector<std::string>& names, const nlohmann::json& name, const std::string& path) {
    const auto found = std::find(names.begin(), names.end(), name.get<std::string>());
    if (found != names.end()) return static_cast<size_t>(found - names.begin());
    refuse(path, inQuotes(name.get<std::string>()) + " is unknown; " +
                     (names.empty() ? "there are none" : nearestText(name.get<std::string>(), names)));
    return 0;
  }

  Quaternion orientation(const nlohmann::json& list, const std::string& path);
  Pose pose(const nlohmann::json& object, const std::string& path);
  Scene scene(const nlohmann::json& object, const std::string& path);
  std::optional<Animation> animation(const nlohmann::json& object, const std::string& path, const Scene& scene);
  Trajectory trajectory(const nlohmann::json& object, const std::string& path);
  std::vector<Trajectory::Stamp> fileStamps(const nlohmann::json& object, const std::string& format,
                                            const std::string& path);
  static std::optional<Direction> cut(const nlohmann::json& object, bool pitched,
                                      std::vector<Trajectory::Stamp>& stamps, std::vector<bool>& turned);
  std::vector<Trajectory::Stamp> waypoints(const nlohmann::json& list, double speed, const std::string& path,
                                           std::vector<bool>& turned);
  void warnOfRadians(const nlohmann::json& list, const std::vector<double>& along, const std::string& path);
  void warnOfLevel(const std::vector<Trajectory::Stamp>& stamps, const std::string& path);
  void warnOfTurns(const nlohmann::json& list, const std::string& path);
  Sensor sensor(const nlohmann::json& value, const std::string& path);
  Effects effects(const nlohmann::json& value, const std::string& path);
  void classes();
  void scenes();
  template <typename Named>
  void classify(const nlohmann::json& object, const std::string& path, const std::string& table, uint16_t usual,
                std::vector<Named>& all, std::set<std::string>& unknown);
  uint16_t classNamed(const nlohmann::json& name, const std::string& path);
  void takeBoxed(const nlohmann::json& object, const std::string& path, Scene& scene);
  void addStanding();
  void warnOfClasses(const std::set<std::string>& unknown, const std::string& path);
  void warnOfPositions(const nlohmann::json& object, const std::string& path, const Scene& scene);
  void models();
  void warnOfModelSizes();
  void warnOfScales();
  void warnOfInsideOut();
  void materialTable();
  void actors();
  void sensors();
  void ignores();
  void warnOfBodies();
  /// Returns fittedExtent() of an actor's model.
  const Vec3& extentOf(const Actor& actor);
  void findScales();
  void checkNumbers();
  void warnOfClocks();
  bool warnOfStamps();
  void warnOfOrientations();
  void warnOfJumps(bool ofEgo);
  void warnOfSensors();
  void warnOfRate(size_t sensor, const std::string& path);
  void warnOfMount(const Pose& mount, const std::string& path);
  void warnOfWeather(const RigSensor& sensor, const std::string& path);
  void warnOfMotion(size_t sensor, const std::string& path);
  void warnOfPaths(size_t sensor, const std::string& path);
  void warnOfSpeeds(size_t sensor, const std::string& path);
  void warnOfEnd();
  void warnOfDriver(const RigSensor& sensor, const std::string& path);
  void imu();
  void frames();
  void times();
  void checkName(const std::string& name, const std::string& path);
  void simulator();
  void weather();
  void outputs();
  void checkFolder(const std::string& name, const std::string& path);
  std::vector<size_t> sensorsOf(const nlohmann::json& output, bool oneSensor, const std::string& path);
  void checkTrace(const Output& output, const std::string& path);
  void checkRings(const Output& output, const std::string& path);
  void checkBag(const Output& output, bool chooses, const std::string& path);
  void warnOfSamples(const Output& output, const std::string& path);
  void warnOfCauses(const Output& output, const std::string& path);
  void survey(const nlohmann::json& object, Output& output, const std::string& path);

  std::filesystem::path folder_;
  const nlohmann::json& root_;
  Drive drive_;
  std::map<std::pair<size_t, std::optional<size_t>>, Vec3> extents_;  // of actors' models, by model and clip
  std::vector<std::string> mistakes_, classNames_;
  StandingActors standing_;
  std::map<std::string, std::string> names_;  // of the sensors and the inertial unit, by the same in small letters
  std::vector<std::string> folders_;          // of the outputs
};

/// Reads a list of three numbers.
Vec3 vectorOf(const nlohmann::json& list);
/// Returns a positive number with so many significant digits.
std::string roundedText(double value, double digits);
/// A member of an object, or null.
const nlohmann::json& memberOf(const nlohmann::json& object, const char* name);

}  // namespace gnosphere::drive
