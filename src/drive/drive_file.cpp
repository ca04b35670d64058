// SPDX-License-Identifier: Apache-2.0
// JSON -> Drive. The schema decides what the words are and which values they take; what it cannot say is checked here:
// names that refer to something, and the files.
#include <fnmatch.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "base/file.hpp"
#include "drive/drive.hpp"
#include "drive/fingerprint.hpp"
#include "drive/pose_math.hpp"
#include "drive/schema_check.hpp"
#include "drive_schema.h"
#include "effects/strict_json.hpp"

namespace gnosphere::drive {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kDegree = std::numbers::pi / 180;
constexpr const char* kDefaultFields = "x,y,z,intensity,ring,time,class,instance,true_range";

const json& memberOf(const json& object, const char* name) {
  static const json kNothing;
  const auto found = object.find(name);
  return found == object.end() ? kNothing : *found;
}

Vec3 vectorOf(const json& list) {
  return {list[0].get<double>(), list[1].get<double>(), list[2].get<double>()};
}

class Reader {
 public:
  Reader(fs::path file, const json& root) : folder_(file.parent_path()), root_(root) {
    drive_.name = root.value("name", file.stem().string());
  }

  /// Returns the drive, or throws Error(format) with all mistakes.
  Drive read(const fs::path& file);

 private:
  /// Runs a step; what it throws becomes a mistake at this path.
  template <typename Step>
  void attempt(const std::string& path, const Step& step) {
    try {
      step();
    } catch (const Error& error) {
      mistakes_.push_back(path + ": " + error.what());
    }
  }
  void refuse(const std::string& path, const std::string& why) { mistakes_.push_back(path + ": " + why); }
  fs::path file(const json& name) const { return folder_ / name.get<std::string>(); }

  /// Returns the index of a name, or adds a mistake.
  size_t find(const std::vector<std::string>& names, const json& name, const std::string& path) {
    const auto found = std::find(names.begin(), names.end(), name.get<std::string>());
    if (found != names.end()) return static_cast<size_t>(found - names.begin());
    refuse(path, inQuotes(name.get<std::string>()) + " is unknown; " +
                     (names.empty() ? "there are none" : nearestText(name.get<std::string>(), names)));
    return 0;
  }

  Quaternion orientation(const json& list, const std::string& path);
  Pose pose(const json& object, const std::string& path);
  Scene scene(const json& object, const std::string& path);
  Trajectory trajectory(const json& object, const std::string& path);
  std::vector<Trajectory::Stamp> waypoints(const json& list, const std::string& path);
  Sensor sensor(const json& value, const std::string& path);
  Effects effects(const json& value, const std::string& path);
  void classes();
  void scenes();
  void classifyInstances(const json& object, const std::string& path, Scene& scene);
  void models();
  void actors();
  void sensors();
  void times();
  void weather();
  void outputs();

  fs::path folder_;
  const json& root_;
  Drive drive_;
  std::vector<std::string> mistakes_, classNames_, modelNames_;
};

Quaternion Reader::orientation(const json& list, const std::string& path) {
  const Quaternion q = {list[0].get<double>(), list[1].get<double>(), list[2].get<double>(), list[3].get<double>()};
  const double length = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  if (std::abs(length - 1) < 0.01) return normalized(q);
  refuse(path, "must be a quaternion qx, qy, qz, qw of length 1, is " + shown(list));
  return {};
}

Pose Reader::pose(const json& object, const std::string& path) {
  Pose pose;
  if (object.is_null()) return pose;
  if (object.contains("position")) pose.position = vectorOf(object["position"]);
  if (object.contains("orientation")) pose.orientation = orientation(object["orientation"], path + ".orientation");
  if (!object.contains("yaw_pitch_roll_deg")) return pose;
  if (object.contains("orientation"))
    refuse(memberPath(path, "yaw_pitch_roll_deg"), "is an alternative to orientation; keep one");
  const Vec3 angles = kDegree * vectorOf(object["yaw_pitch_roll_deg"]);
  pose.orientation = yawPitchRoll(angles.x, angles.y, angles.z);
  return pose;
}

/// A file of triangles at its pose.
Scene Reader::scene(const json& object, const std::string& path) {
  LoadOptions options;
  if (object.contains("up")) options.up = object["up"] == "y" ? UpAxis::y : UpAxis::z;
  options.scale = object.value("scale", 1.0);
  Scene scene;
  attempt(path + ".file", [&] { scene = loadScene(file(object["file"]), options); });
  const Transform place = transformOf(pose(memberOf(object, "pose"), memberPath(path, "pose")));
  for (Instance& instance : scene.instances) instance.transform = place * instance.transform;
  return scene;
}

std::vector<Trajectory::Stamp> Reader::waypoints(const json& list, const std::string& path) {
  std::vector<Trajectory::Stamp> stamps;
  for (const json& waypoint : list)
    stamps.push_back({waypoint["time"].get<double>(), {vectorOf(waypoint["position"]), {}}});
  headAlong(stamps);
  for (size_t i = 0; i < list.size(); ++i) {
    const std::string at = entryPath(path, i);
    Quaternion& turn = stamps[i].pose.orientation;
    if (list[i].contains("orientation")) turn = orientation(list[i]["orientation"], at + ".orientation");
    if (!list[i].contains("yaw_deg")) continue;
    if (list[i].contains("orientation")) refuse(at + ".yaw_deg", "is an alternative to orientation; keep one");
    turn = yawPitchRoll(kDegree * list[i]["yaw_deg"].get<double>(), 0, 0);
  }
  return stamps;
}

Trajectory Reader::trajectory(const json& object, const std::string& path) {
  const std::string format = object.value("format", "tum");
  const auto only = [&](const char* name, const char* owner) {
    if (object.contains(name) && (format != owner || !object.contains("file")))
      refuse(memberPath(path, name), std::string("is only for files of the format ") + owner);
  };
  only("times", "kitti");
  only("route", "carla-route");
  only("speed", "carla-route");
  if (object.contains("file") == object.contains("waypoints")) {
    refuse(path, object.contains("file") ? "has a file and waypoints; keep one" : "needs a file or waypoints");
    return {};
  }
  std::vector<Trajectory::Stamp> stamps;
  if (object.contains("waypoints")) {
    if (object.contains("format")) refuse(memberPath(path, "format"), "is only for files");
    stamps = waypoints(object["waypoints"], path + ".waypoints");
  } else {
    TrajectoryFileOptions options;
    if (object.contains("times")) options.times = file(object["times"]);
    options.route = object.value("route", "");
    options.speed = object.value("speed", 0.0);
    attempt(path + ".file", [&] { stamps = readTrajectory(file(object["file"]), format, options); });
    if (stamps.empty()) return {};
  }
  const double from = object.value("from", -INFINITY), to = object.value("to", INFINITY);
  std::erase_if(stamps, [&](const auto& stamp) { return stamp.time < from || stamp.time > to; });
  if (stamps.empty()) {
    refuse(path, "has no pose from 'from' to 'to'");
    return {};
  }
  if (object.value("heading", false)) headAlong(stamps);
  const double shift = object.contains("begin") ? object["begin"].get<double>() - stamps.front().time : 0;
  const Vec3 moved = object.contains("shift") ? vectorOf(object["shift"]) : Vec3{};
  for (auto& stamp : stamps) {
    stamp.time += shift;
    stamp.pose.position = stamp.pose.position + moved;
  }
  Trajectory result;
  attempt(path, [&] { result = Trajectory(std::move(stamps)); });
  return result;
}

/// Takes what a built-in name stands for, or else a file.
template <typename T>
T namedOrFile(const std::string& name, const fs::path& file, T (*named)(const std::string&),
              T (*load)(const fs::path&)) {
  try {
    return named(name);
  } catch (const Error& unknown) {
    std::error_code ignored;
    if (!fs::is_regular_file(file, ignored))
      throw Error(unknown.code(), std::string(unknown.what()) + "; or give a file");
  }
  return load(file);
}

Sensor Reader::sensor(const json& value, const std::string& path) {
  Sensor sensor;
  attempt(path, [&] {
    sensor = value.is_string() ? namedOrFile(value.get<std::string>(), file(value), builtinSensor, loadSensor)
                               : sensorFromJson(value.dump(), "the sensor");
    validate(sensor);
  });
  return sensor;
}

Effects Reader::effects(const json& value, const std::string& path) {
  Effects effects;
  attempt(path, [&] {
    if (value.is_string())
      effects = namedOrFile(value.get<std::string>(), file(value), effectPreset, loadEffects);
    else if (value.is_object())
      effects = effectsFromJson(value.dump(), "the effects");
  });
  if (!value.is_object() || !value.contains("seed")) effects.seed = root_.value("seed", uint64_t{1});
  return effects;
}

void Reader::classes() {
  for (const auto& [name, object] : memberOf(root_, "classes").items()) {
    const uint16_t id = object["id"].get<uint16_t>();
    drive_.classes.push_back({name, id, object.value("moving_id", id)});
    classNames_.push_back(name);
  }
}

/// Gives each instance the class of the longest pattern that its name matches.
void Reader::classifyInstances(const json& object, const std::string& path, Scene& scene) {
  const auto idOf = [&](const json& name, const std::string& at) {
    const size_t found = find(classNames_, name, at);
    return found < drive_.classes.size() ? drive_.classes[found].id : uint16_t{0};
  };
  if (object.contains("class"))
    for (Instance& instance : scene.instances) instance.classId = idOf(object["class"], path + ".class");
  std::vector<size_t> lengths(scene.instances.size());
  for (const auto& [pattern, name] : memberOf(object, "instances").items()) {
    const uint16_t id = idOf(name, memberPath(path + ".instances", pattern));
    bool matches = false;
    for (size_t i = 0; i < scene.instances.size(); ++i) {
      if (fnmatch(pattern.c_str(), scene.instances[i].name.c_str(), 0) != 0) continue;
      matches = true;
      if (pattern.size() < lengths[i]) continue;
      lengths[i] = pattern.size();
      scene.instances[i].classId = id;
    }
    if (!matches) drive_.warnings.push_back(path + ".instances: '" + pattern + "' matches no instance");
  }
}

void Reader::scenes() {
  for (size_t i = 0; i < root_["scenes"].size(); ++i) {
    const std::string path = entryPath("scenes", i);
    Scene scene = this->scene(root_["scenes"][i], path);
    classifyInstances(root_["scenes"][i], path, scene);
    drive_.scenes.push_back(std::move(scene));
  }
}

void Reader::models() {
  for (const auto& [name, object] : memberOf(root_, "models").items()) {
    modelNames_.push_back(name);
    drive_.models.push_back(scene(object, memberPath("models", name)));
    if (drive_.models.back().instances.empty() && mistakes_.empty())
      refuse(memberPath("models", name), "has no triangles");
  }
}

void Reader::actors() {
  std::set<std::string> names;
  const json& list = memberOf(root_, "actors");
  for (size_t i = 0; i < list.size(); ++i) {
    const std::string path = entryPath("actors", i);
    Actor actor;
    actor.name = list[i]["name"].get<std::string>();
    if (!names.insert(actor.name).second) refuse(path + ".name", inQuotes(actor.name) + " is there twice");
    actor.model = find(modelNames_, list[i]["model"], path + ".model");
    actor.category = find(classNames_, list[i]["class"], path + ".class");
    if (list[i].contains("size")) actor.size = vectorOf(list[i]["size"]);
    actor.trajectory = trajectory(list[i]["trajectory"], path + ".trajectory");
    actor.goneOutside = list[i].value("outside", "hold") == "gone";
    drive_.actors.push_back(std::move(actor));
  }
}

void Reader::sensors() {
  std::set<std::string> names;
  for (size_t i = 0; i < root_["sensors"].size(); ++i) {
    const json& object = root_["sensors"][i];
    const std::string path = entryPath("sensors", i);
    RigSensor rigged;
    rigged.name = object["name"].get<std::string>();
    const auto isPlain = [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-'; };
    if (!std::all_of(rigged.name.begin(), rigged.name.end(), isPlain))
      refuse(path + ".name", "must have letters, digits, _ and - only, is " + shown(object["name"]));
    if (!names.insert(rigged.name).second) refuse(path + ".name", inQuotes(rigged.name) + " is there twice");
    rigged.sensor = sensor(object["sensor"], path + ".sensor");
    rigged.effects = effects(memberOf(object, "effects"), path + ".effects");
    rigged.mount = pose(memberOf(object, "mount"), path + ".mount");
    const double period = rigged.sensor.rotationPeriod;
    rigged.rate = object.value("rate", period * drive_.rate > 1 ? 1 / period : drive_.rate);
    rigged.offset = object.value("offset", 0.0);
    if (rigged.rate * period > 1 + 1e-9)
      refuse(path + ".rate", "is " + shown(object["rate"]) + " scans a second, but the sensor takes " +
                                 std::to_string(period) + " s for one");
    drive_.sensors.push_back(std::move(rigged));
  }
}

void Reader::times() {
  drive_.rate = root_.value("rate", 10.0);
  drive_.epoch = root_.value("epoch", 0.0);
  drive_.ego = trajectory(root_["ego"]["trajectory"], "ego.trajectory");
  drive_.start = root_.value("start", drive_.ego.begin());
  drive_.duration = root_.value("duration", drive_.ego.end() - drive_.start);
  if (!(drive_.duration > 0) && mistakes_.empty())
    refuse("duration", "is missing, and the ego's trajectory ends at the start of the drive");
  if (drive_.duration * drive_.rate > 1e9) refuse("duration", "would have more than a thousand million frames");
}

void Reader::weather() {
  const json& list = memberOf(root_, "weather");
  for (size_t i = 0; i < list.size(); ++i) {
    WeatherStamp stamp;
    stamp.time = list[i]["time"].get<double>();
    stamp.fog = list[i].contains("visibility") ? 1 / list[i]["visibility"].get<double>() : 0;
    stamp.rain = list[i].value("rain", 0.0);
    stamp.snow = list[i].value("snow", 0.0);
    if (i > 0 && stamp.time < drive_.weather.back().time)
      refuse(entryPath("weather", i) + ".time", "comes before the entry in front of it");
    drive_.weather.push_back(stamp);
  }
}

void Reader::outputs() {
  std::vector<std::string> names;
  for (const RigSensor& sensor : drive_.sensors) names.push_back(sensor.name);
  std::set<std::string> folders;
  for (size_t i = 0; i < root_["outputs"].size(); ++i) {
    const json& object = root_["outputs"][i];
    const std::string path = entryPath("outputs", i);
    Output output;
    output.format = object["format"].get<std::string>();
    output.folder = object.value("folder", output.format);
    const bool kitti = output.format.find("kitti") != std::string::npos;
    const bool rows = output.format == "pcd" || output.format == "npy";
    const fs::path folder = fs::path(output.folder).lexically_normal();
    if (folder.is_absolute() || *folder.begin() == ".." || *folder.begin() == "." || *folder.begin() == "manifest")
      refuse(path + ".folder", "must be a folder in the output folder, other than manifest");
    if (!folders.insert(folder.generic_string()).second) refuse(path + ".folder", "another output writes there, too");
    const json& listed = memberOf(object, "sensors");
    for (size_t s = 0; s < listed.size(); ++s)
      output.sensors.push_back(find(names, listed[s], entryPath(path + ".sensors", s)));
    if (listed.is_null())
      for (size_t s = 0; s < (kitti ? 1 : names.size()); ++s) output.sensors.push_back(s);
    if (kitti && output.sensors.size() > 1) refuse(path + ".sensors", "KITTI has one lidar; name one sensor");
    if (object.contains("fields") && !rows) refuse(path + ".fields", "is only for pcd and npy");
    if (rows) attempt(path + ".fields", [&] { output.fields = parseFields(object.value("fields", kDefaultFields)); });
    if (object.contains("keyframes") && output.format != "nuscenes")
      refuse(path + ".keyframes", "is only for nuscenes");
    output.keyframes = object.value("keyframes", uint64_t{5});
    drive_.outputs.push_back(std::move(output));
  }
}

/// All mistakes in one line.
[[noreturn]] void refuseAll(const fs::path& file, const std::vector<std::string>& mistakes) {
  constexpr size_t kShown = 8;
  std::string text = file.string() + ": ";
  for (size_t i = 0; i < std::min(kShown, mistakes.size()); ++i) text += (i ? "; " : "") + mistakes[i];
  if (mistakes.size() > kShown) text += "; and " + std::to_string(mistakes.size() - kShown) + " more mistakes";
  throw Error(ErrorCode::format, text);
}

Drive Reader::read(const fs::path& file) {
  drive_.accuracy = std::map<std::string, Accuracy>{
      {"paper", Accuracy::paper},
      {"draft", Accuracy::draft},
      {"standard", Accuracy::standard},
      {"exact",
       Accuracy::exact}}.at(root_.value("accuracy", "standard"));
  classes();
  times();
  sensors();
  weather();
  outputs();
  scenes();
  models();
  actors();
  if (!mistakes_.empty()) refuseAll(file, mistakes_);
  drive_.fingerprint = fingerprintOf(drive_, root_.dump());
  return std::move(drive_);
}

}  // namespace

Drive readDrive(const fs::path& file) {
  static const json kSchema = json::parse(kDriveSchema);
  const json root = parseStrict(readWholeFile(file, uint64_t{1} << 28), file.string());
  const std::vector<std::string> mistakes = mistakesOf(root, kSchema);
  if (!mistakes.empty()) refuseAll(file, mistakes);
  return Reader(file, root).read(file);
}

}  // namespace gnosphere::drive
