// SPDX-License-Identifier: Apache-2.0
// The values of a drive file that occur in several places: poses, scenes, trajectories, sensors, effects.
#include "drive/drive_reader.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <system_error>

#include "base/file.hpp"
#include "base/units.hpp"
#include "drive/pose_math.hpp"
#include "drive/schema_check.hpp"
#include "scene/readers.hpp"

namespace gnosphere::drive {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Returns the built-in sensor or preset of this name, or else loads the file of this name.
template <typename T, typename Load>
T namedOrFile(const std::string& name, const fs::path& place, T (*named)(const std::string&), const Load& load) {
  try {
    return named(name);
  } catch (const Error& unknown) {
    std::error_code ignored;
    if (!fs::is_regular_file(place, ignored))
      throw Error(unknown.code(), std::string(unknown.what()) + "; or give a file");
  }
  return load(name);
}

/// Returns a difference of angles in degrees without the rounding of its subtraction.
std::string degreesText(double angle) {
  return gnosphere::numberText(std::round(1e6 * angle) / 1e6);
}

}  // namespace

Vec3 vectorOf(const json& list) {
  return {list[0].get<double>(), list[1].get<double>(), list[2].get<double>()};
}

const json& memberOf(const json& object, const char* name) {
  static const json kNothing;
  const auto found = object.find(name);
  return found == object.end() ? kNothing : *found;
}

Quaternion DriveReader::orientation(const json& list, const std::string& path) {
  const Quaternion q = {list[0].get<double>(), list[1].get<double>(), list[2].get<double>(), list[3].get<double>()};
  if (isUnit(q)) return normalized(q);
  refuse(path, "must be a quaternion qx, qy, qz, qw of length 1, is " + shown(list));
  return {};
}

Pose DriveReader::pose(const json& object, const std::string& path) {
  Pose pose;
  if (object.is_null()) return pose;
  if (object.contains("position")) pose.position = vectorOf(object["position"]);
  std::string stated;  // the word that states the orientation
  const auto states = [&](const char* name) {
    if (!object.contains(name)) return false;
    if (!stated.empty()) refuse(memberPath(path, name), "is an alternative to " + stated + "; keep one");
    stated = name;
    return true;
  };
  if (states("orientation")) pose.orientation = orientation(object["orientation"], path + ".orientation");
  if (states("yaw_pitch_roll_deg")) {
    const Vec3 angles = kDegree * vectorOf(object["yaw_pitch_roll_deg"]);
    pose.orientation = yawPitchRoll(angles.x, angles.y, angles.z);
  }
  if (states("yaw_deg")) pose.orientation = yawPitchRoll(kDegree * object["yaw_deg"].get<double>(), 0, 0);
  return pose;
}

/// A file of triangles at its pose.
Scene DriveReader::scene(const json& object, const std::string& path) {
  LoadOptions options;
  if (object.contains("up")) options.up = isText(object["up"], "y") ? UpAxis::y : UpAxis::z;
  options.scale = object.value("scale", 1.0);
  Scene scene;
  const auto name = object["file"].get<std::string>();
  std::vector<std::string> beside;
  attempt(path + ".file", [&] { scene = loadScene(file(name), options, beside); });
  for (const std::string& other : beside) {
    const std::u8string from = (pathOf(name).parent_path() / pathOf(other)).generic_u8string();
    file({from.begin(), from.end()});
  }
  const Transform place = transformOf(pose(memberOf(object, "pose"), memberPath(path, "pose")));
  for (Instance& instance : scene.instances) instance.transform = place * instance.transform;
  scene.animation.root = place * scene.animation.root;
  for (const std::string& line : scene.leftOut) warn(path + ".file", "left out are " + line);
  return scene;
}

/// The animation of an object that has one. A scene without instances could not be read, which has been told.
std::optional<Animation> DriveReader::animation(const json& object, const std::string& path, const Scene& scene) {
  const json& given = memberOf(object, "animation");
  if (given.is_null() || scene.instances.empty()) return {};
  Animation animation;
  attempt(path + ".animation.clip", [&] {
    const auto wanted = given["clip"].get<std::string>();
    const Clip& clip = clipNamed(scene, wanted);
    animation.clip = static_cast<size_t>(&clip - scene.animation.clips.data());
  });
  animation.speed = given.value("speed", 1.0);
  animation.offset = given.value("offset", 0.0);
  animation.end = given.value("loop", true) ? ClipEnd::loop : ClipEnd::hold;
  return animation;
}

/// Warns of yaws that are half a turn or more apart: orientations turn the shorter way.
void DriveReader::warnOfTurns(const json& list, const std::string& path) {
  size_t first = 0, count = 0;
  for (size_t i = 1; i < list.size(); ++i) {
    if (!list[i - 1].contains("yaw_deg") || !list[i].contains("yaw_deg")) continue;
    if (std::abs(list[i]["yaw_deg"].get<double>() - list[i - 1]["yaw_deg"].get<double>()) < 180) continue;
    if (count++ == 0) first = i;
  }
  if (count == 0) return;
  const double apart = list[first]["yaw_deg"].get<double>() - list[first - 1]["yaw_deg"].get<double>();
  warn(entryPath(path, first) + ".yaw_deg",
       "is " + degreesText(apart) + " degrees from the one before, and a vehicle turns the shorter way, by " +
           degreesText(std::remainder(apart, 360)) + " degrees; for the longer way give waypoints between them" +
           (count > 1 ? " (so do " + std::to_string(count) + " waypoints)" : ""));
}

/// Warns of yaws in radians: all fit the way as such, and as degrees one of them is more than 60 degrees off.
/// `along` has the yaw of each waypoint along the way.
void DriveReader::warnOfRadians(const json& list, const std::vector<double>& along, const std::string& path) {
  constexpr double kFits = 0.2;  // rad
  size_t wrong = list.size();
  for (size_t i = 0; i < list.size(); ++i) {
    if (!list[i].contains("yaw_deg")) return;
    const double yaw = list[i]["yaw_deg"].get<double>(), way = along[i];
    const auto offBy = [&](double angle) { return std::abs(std::remainder(way - angle, 2 * M_PI)); };
    if (std::abs(yaw) > 2 * M_PI || offBy(yaw) > kFits) return;
    if (wrong == list.size() && offBy(kDegree * yaw) > M_PI / 3) wrong = i;
  }
  if (wrong == list.size()) return;
  warn(entryPath(path, wrong) + ".yaw_deg",
       "is " + shown(list[wrong]["yaw_deg"]) +
           ", and the way leads elsewhere; the yaws are in degrees, and along the way these would be radians");
}

/// Warns of something that looks along its way, but is level where it climbs or descends.
void DriveReader::warnOfLevel(const std::vector<Trajectory::Stamp>& stamps, const std::string& path) {
  constexpr double kLevel = 0.03;
  const double steepest = steepestOf(stamps);
  if (steepest <= kLevel) return;
  warn(path,
       "has a slope of " + gnosphere::numberText(std::round(100 * steepest)) +
           " %, and what faces its direction of travel stays level; \"pitch\": true inclines it along its way, and "
           "false keeps it level without this warning");
}

/// Returns the stamps of waypoints, none if their times are refused, and appends to `turned` whether each states an
/// angle. With a speed (m/s, else 0) the times follow from the distances between them; the first is 0.
std::vector<Trajectory::Stamp> DriveReader::waypoints(const json& list, double speed, const std::string& path,
                                                      std::vector<bool>& turned) {
  std::vector<Trajectory::Stamp> stamps;
  bool sound = true;
  const auto refuseTime = [&](const std::string& at, const std::string& why) {
    refuse(at, why);
    sound = false;
  };
  for (size_t i = 0; i < list.size(); ++i) {
    const std::string at = entryPath(path, i);
    if (speed > 0 && list[i].contains("time"))
      refuseTime(at + ".time", "follows from the 'speed' of the trajectory; keep one");
    else if (speed == 0 && !list[i].contains("time"))
      refuseTime(at, "needs a 'time', or the trajectory a 'speed'");
    const Pose placed = pose(list[i], at);
    double time = list[i].value("time", 0.0);
    if (speed > 0 && i > 0) {
      const double way = lengthOf(placed.position - stamps[i - 1].pose.position);
      if (!(way > 0)) refuseTime(at, "is at the place of the one before, so with a 'speed' it has no time of its own");
      time = stamps[i - 1].time + way / speed;
    }
    stamps.push_back({time, placed});
    turned.push_back(list[i].contains("orientation") || list[i].contains("yaw_pitch_roll_deg") ||
                     list[i].contains("yaw_deg"));
  }
  if (!sound) return {};
  warnOfRadians(list, yawsAlong(stamps), path);
  warnOfTurns(list, path);
  return stamps;
}

/// Returns the stamps of a pose file, none if it is refused. Of poses with the same time the first counts.
std::vector<Trajectory::Stamp> DriveReader::fileStamps(const json& object, const std::string& format,
                                                       const std::string& path) {
  TrajectoryFileOptions options;
  if (object.contains("times")) options.times = file(object["times"]);
  options.route = object.value("route", "");
  options.speed = object.value("speed", 0.0);
  std::vector<Trajectory::Stamp> stamps;
  attempt(path + ".file", [&] { stamps = readTrajectory(file(object["file"]), format, options); });
  // Recordings may have a time twice; other disorder is a mistake.
  const auto sameTime = [](const auto& a, const auto& b) { return a.time == b.time; };
  const size_t count = stamps.size();
  stamps.erase(std::unique(stamps.begin(), stamps.end(), sameTime), stamps.end());
  if (stamps.size() < count)
    warn(path, std::to_string(count - stamps.size()) + " poses have the time of the pose before them and are left out");
  return stamps;
}

/// Keeps the stamps from the `from` of a trajectory to its `to`, and what `turned` has of them. Returns the direction
/// of the last way up to the first of them, in which who stands there looks.
std::optional<Direction> DriveReader::cut(const json& object, bool pitched, std::vector<Trajectory::Stamp>& stamps,
                                          std::vector<bool>& turned) {
  // INFINITY is a float, which value() would round the times to.
  constexpr double kEver = std::numeric_limits<double>::infinity();
  const double from = object.value("from", -kEver), to = object.value("to", kEver);
  size_t kept = 0;
  std::optional<Direction> before;
  for (size_t i = 0; i < stamps.size(); ++i) {
    if (stamps[i].time < from || stamps[i].time > to) continue;
    if (kept == 0) before = directionOfLastWay(std::span(stamps).first(i + 1), pitched);
    stamps[kept] = stamps[i];
    turned[kept++] = turned[i];
  }
  stamps.resize(kept);
  turned.resize(kept);
  return before;
}

Trajectory DriveReader::trajectory(const json& object, const std::string& path) {
  const std::string format = object.value("format", "tum");
  const auto only = [&](const char* name, const char* owner) {
    if (object.contains(name) && (format != owner || !object.contains("file")))
      refuse(memberPath(path, name), std::string("is only for files of the format ") + owner);
  };
  only("times", "kitti");
  only("route", "carla-route");
  if (!object.contains("waypoints")) only("speed", "carla-route");
  if (object.contains("file") == object.contains("waypoints")) {
    refuse(path, object.contains("file") ? "has a file and waypoints; keep one" : "needs a file or waypoints");
    return {};
  }
  std::vector<Trajectory::Stamp> stamps;
  std::vector<bool> turned;  // by stamp, whether it has an orientation of its own
  if (object.contains("waypoints")) {
    if (object.contains("format")) refuse(memberPath(path, "format"), "is only for files");
    stamps = waypoints(object["waypoints"], object.value("speed", 0.0), path + ".waypoints", turned);
  } else {
    stamps = fileStamps(object, format, path);
  }
  if (stamps.empty()) return {};
  const bool looksAlong =
      object.value("heading", false) || (object.contains("file") && (format == "carla" || format == "carla-route"));
  turned.resize(stamps.size(), true);
  if (looksAlong) turned.assign(stamps.size(), false);
  const auto someAre = [&](bool turnedOnes) { return std::ranges::find(turned, turnedOnes) != turned.end(); };
  const bool pitched = object.value("pitch", false);
  if (pitched && !someAre(false))
    refuse(memberPath(path, "pitch"), "is for waypoints without an orientation, or with \"heading\": true");
  const std::optional<Direction> before = cut(object, pitched, stamps, turned);
  if (stamps.empty()) {
    refuse(path, "has no pose from 'from' to 'to'");
    return {};
  }
  const double shift = object.contains("begin") ? object["begin"].get<double>() - stamps.front().time : 0;
  const Vec3 moved = object.contains("shift") ? vectorOf(object["shift"]) : Vec3{};
  for (auto& stamp : stamps) {
    stamp.time += shift;
    stamp.pose.position = stamp.pose.position + moved;
  }
  if (!object.contains("pitch") && !someAre(true)) warnOfLevel(stamps, path);
  Trajectory result;
  attempt(path, [&] {
    result = !someAre(false) ? Trajectory(std::move(stamps))
                             : Trajectory::alongWay(std::move(stamps), std::move(turned), pitched, before);
  });
  return result;
}

Sensor DriveReader::sensor(const json& value, const std::string& path) {
  Sensor sensor;
  const auto load = [&](const std::string& name) {
    SensorFile read = readSensorFile(file(name));
    for (const std::string& text : read.assumed) warn(path, "assumed: " + text);
    for (const std::string& text : read.ignored) warn(path, "ignored: " + text);
    return std::move(read.sensor);
  };
  attempt(path, [&] {
    sensor = value.is_string() ? namedOrFile(value.get<std::string>(), place(value), builtinSensor, load)
                               : sensorFromJson(jsonText(value), "the sensor");
    validate(sensor);
  });
  return sensor;
}

Effects DriveReader::effects(const json& value, const std::string& path) {
  Effects effects;
  bool hasSeed = value.is_object() && value.contains("seed");
  // A preset has no seed of its own, and CARLA's attributes have one for every kind of sensor, stated or not.
  const auto load = [&](const std::string& name) {
    const fs::path read = file(name);
    Effects loaded = loadEffects(read);
    const json content = parseStrict(readWholeFile(read), read.string());
    hasSeed = content.is_object() && content.contains("seed");
    return loaded;
  };
  attempt(path, [&] {
    if (value.is_string())
      effects = namedOrFile(value.get<std::string>(), place(value), effectPreset, load);
    else if (value.is_object())
      effects = effectsFromJson(jsonText(value), "the effects");
  });
  if (!hasSeed) effects.seed = drive_.seed;
  return effects;
}

}  // namespace gnosphere::drive
