// SPDX-License-Identifier: Apache-2.0
// Reads a Drive from JSON. The schema decides which words there are and which values they take. The rest is checked
// here: names that refer to something, and the files.
#include <algorithm>
#include <set>

#include "base/file.hpp"
#include "base/json_text.hpp"
#include "base/path.hpp"
#include "base/text.hpp"
#include "base/utf8.hpp"
#include "drive/drive_reader.hpp"
#include "drive/fingerprint.hpp"
#include "drive/schema_check.hpp"
#include "drive_schema.h"
#include "ros2/driver_cloud.hpp"
#include "sensor/beams.hpp"

namespace gnosphere::drive {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr double kLastTime = 9.2e9;  // s: the year 2261

/// All mistakes in one line.
[[noreturn]] void refuseAll(const fs::path& file, const std::vector<std::string>& mistakes) {
  constexpr size_t kShown = 8;
  std::string text = file.string() + ": ";
  for (size_t i = 0; i < std::min(kShown, mistakes.size()); ++i) text += (i ? "; " : "") + mistakes[i];
  if (mistakes.size() > kShown) text += "; and " + std::to_string(mistakes.size() - kShown) + " more mistakes";
  throw Error(ErrorCode::format, text);
}

/// Appends the options of an object, and of those in it, as NAME=VALUE.
void appendOptions(const json& object, const std::string& prefix, std::vector<std::string>& assignments) {
  for (const auto& [name, value] : object.items()) {
    if (value.is_object())
      appendOptions(value, prefix + name + ".", assignments);
    else
      assignments.push_back(prefix + name + "=" + jsonText(value));
  }
}

constexpr size_t kMostNameBytes = 100;  // the name of a file may have those of a drive and of a sensor, and 255 in all

/// Returns the name of a drive whose file states none: that of the file, with _ in place of other characters.
std::string nameOf(const fs::path& file) {
  std::string name;
  for (const char8_t c : file.stem().u8string())
    if (isPlain(c))
      name += static_cast<char>(c);
    else if (!name.ends_with('_'))
      name += '_';
  if (namesDevice(name)) name += '_';
  return name.substr(0, kMostNameBytes);
}

}  // namespace

std::string mistakeOfName(const std::string& name) {
  if (name.empty() || !std::ranges::all_of(name, isPlain))
    return "must have letters, digits, _ and - only, is " + shown(json(toUtf8(name)));
  if (name.size() > kMostNameBytes)
    return "has " + std::to_string(name.size()) + " characters, and names of files have room for " +
           std::to_string(kMostNameBytes) + "; choose a shorter one";
  if (namesDevice(name))
    return inQuotes(name) + " is the name of a device on Windows, where no folder can have it; choose another name";
  return "";
}

void DriveReader::actors() {
  std::set<std::string> names;
  const json& list = memberOf(root_, "actors");
  for (size_t i = 0; i < list.size(); ++i) {
    const std::string path = entryPath("actors", i);
    Actor actor;
    actor.name = list[i]["name"].get<std::string>();
    if (!names.insert(actor.name).second) refuse(path + ".name", inQuotes(actor.name) + " is there twice");
    actor.model = find(drive_.modelNames, list[i]["model"], path + ".model");
    actor.category = find(classNames_, list[i]["class"], path + ".class");
    if (list[i].contains("size")) actor.size = vectorOf(list[i]["size"]);
    actor.trajectory = trajectory(list[i]["trajectory"], path + ".trajectory");
    if (actor.model < drive_.models.size()) actor.animation = animation(list[i], path, drive_.models[actor.model]);
    actor.goneOutside = list[i].value("outside", "hold") == "gone";
    drive_.actors.push_back(std::move(actor));
  }
}

/// Checks the name of a sensor or of the inertial unit.
void DriveReader::checkName(const std::string& name, const std::string& path) {
  if (const std::string why = mistakeOfName(name); !why.empty()) refuse(path + ".name", why);
  const auto [other, isNew] = names_.emplace(lower(name), name);
  if (!isNew && other->second == name) refuse(path + ".name", inQuotes(name) + " is there twice");
  if (!isNew && other->second != name)
    refuse(path + ".name", inQuotes(name) + " differs from " + inQuotes(other->second) +
                               " by capital letters alone, so Windows and macOS have one folder for both; choose "
                               "another name");
}

void DriveReader::imu() {
  const json& object = memberOf(root_, "imu");
  if (object.is_null()) return;
  drive_.imu = {object.value("name", "imu"), pose(memberOf(object, "mount"), "imu.mount"), object.value("rate", 200.0)};
  checkName(drive_.imu->name, "imu");
}

void DriveReader::frames() {
  const json& object = memberOf(root_, "frames");
  if (object.is_null()) return;
  drive_.worldFrame = object.value("world", drive_.worldFrame);
  drive_.vehicleFrame = object.value("vehicle", drive_.vehicleFrame);
  if (drive_.worldFrame == drive_.vehicleFrame) refuse("frames", "the world and the vehicle need two names");
  for (const char* name : {"world", "vehicle"})
    if (const std::string frame = object.value(name, ""); frame.starts_with('/'))
      refuse(std::string("frames.") + name, "is " + inQuotes(frame) + "; tf2 refuses frames that begin with a slash");
}

void DriveReader::sensors() {
  for (size_t i = 0; i < root_["sensors"].size(); ++i) {
    const json& object = root_["sensors"][i];
    const std::string path = entryPath("sensors", i);
    RigSensor rigged;
    rigged.name = object["name"].get<std::string>();
    checkName(rigged.name, path);
    rigged.sensor = sensor(object["sensor"], path + ".sensor");
    if (object.contains("near_hits"))
      rigged.sensor.nearHits = object["near_hits"] == "hide" ? NearHits::hide : NearHits::seeThrough;
    rigged.effects = effects(memberOf(object, "effects"), path + ".effects");
    rigged.mount = pose(memberOf(object, "mount"), path + ".mount");
    const double period = scanPeriodOf(rigged.sensor);
    rigged.rate = object.value("rate", period * drive_.rate > 1 ? 1 / period : drive_.rate);
    rigged.offset = object.value("offset", 0.0);
    rigged.livoxCustom = object.value("driver", "") == "livox-custom";
    if (object.contains("driver")) {
      rigged.driver = ros2::driverNamed(object["driver"].get<std::string>());
      if (const std::string why = ros2::mistakeOfDriver(rigged.sensor, rigged.driver); !why.empty())
        refuse(path + ".driver", why);
    }
    if (rigged.rate * period > 1 + 1e-9)
      refuse(path + ".rate",
             "is " + shown(object["rate"]) + " scans a second, but the sensor takes " + shown(period) + " s for one");
    if (const double last = lastTimeOf(rigged.sensor); rigged.rate * last > 1 + 1e-9)
      refuse(path + ".rate", "is " + gnosphere::numberText(rigged.rate) +
                                 " scans a second, but the last beam of a scan fires " + gnosphere::numberText(last) +
                                 " s after its start");
    // A frame has all its scans in memory at once.
    constexpr double kMostScans = 10000;
    if (rigged.rate * std::min(1 / drive_.rate, drive_.duration) > kMostScans)
      refuse(path + ".rate", "is " + gnosphere::numberText(rigged.rate) + " scans a second, and the drive has " +
                                 gnosphere::numberText(drive_.rate) + " frames a second, so a frame has more than " +
                                 gnosphere::numberText(kMostScans) + " scans; give the drive a higher rate, or the " +
                                 "sensor a lower one");
    drive_.sensors.push_back(std::move(rigged));
  }
}

void DriveReader::simulator() {
  const json& object = memberOf(root_, "simulator");
  if (root_.contains("accuracy") && object.contains("accuracy"))
    refuse("simulator.accuracy", "is there twice, because the drive has an accuracy, too");
  drive_.simulator = {"accuracy=" + root_.value("accuracy", "standard")};
  if (object.is_object()) appendOptions(object, "", drive_.simulator);
}

void DriveReader::times() {
  drive_.rate = root_.value("rate", 10.0);
  drive_.epoch = root_.value("epoch", 0.0);
  drive_.ego = trajectory(root_["ego"]["trajectory"], "ego.trajectory");
  drive_.start = root_.value("start", drive_.ego.begin());
  drive_.duration = root_.value("duration", drive_.ego.end() - drive_.start);
  if (!(drive_.duration > 0) && mistakes_.empty())
    refuse("duration", "is missing, and the ego's trajectory ends at the start of the drive");
  if (drive_.duration * drive_.rate > 1e9) refuse("duration", "would have more than a thousand million frames");
  const double first = drive_.epoch + drive_.start, last = first + drive_.duration;
  if (first < -kLastTime || last > kLastTime)
    refuse("epoch", "leads to times from " + shown(first) + " s to " + shown(last) +
                        " s, which are beyond nanoseconds in 64 bits");
}

void DriveReader::weather() {
  const json& list = memberOf(root_, "weather");
  for (size_t i = 0; i < list.size(); ++i) {
    WeatherStamp stamp;
    stamp.time = list[i]["time"].get<double>();
    stamp.fog = list[i].contains("visibility") ? 1 / list[i]["visibility"].get<double>() : 0;
    stamp.rain = list[i].value("rain", 0.0);
    stamp.snow = list[i].value("snow", 0.0);
    drive_.weatherKinds.fog |= list[i].contains("visibility");
    drive_.weatherKinds.rain |= list[i].contains("rain");
    drive_.weatherKinds.snow |= list[i].contains("snow");
    if (i > 0 && stamp.time < drive_.weather.back().time)
      refuse(entryPath("weather", i) + ".time", "comes before the entry in front of it");
    drive_.weather.push_back(stamp);
  }
}

Drive DriveReader::read(const fs::path& file) {
  if (const std::string why = mistakeOfName(drive_.name); !why.empty()) refuse("name", why);
  drive_.seed = root_.value("seed", drive_.seed);
  simulator();
  classes();
  times();
  sensors();
  imu();
  frames();
  weather();
  outputs();
  scenes();
  models();
  materialTable();
  actors();
  addStanding();
  ignores();
  if (mistakes_.empty()) findScales();
  checkNumbers();
  if (!mistakes_.empty()) refuseAll(file, mistakes_);
  warnOfClocks();
  warnOfJumps(!warnOfStamps());
  warnOfOrientations();
  warnOfEnd();
  warnOfModelSizes();
  warnOfScales();
  warnOfInsideOut();
  warnOfSensors();
  drive_.file = jsonText(root_, 2) + "\n";
  drive_.fingerprint = fingerprintOf(drive_, jsonText(root_));
  return std::move(drive_);
}

Drive readDrive(const fs::path& file, std::optional<uint64_t> seed, const std::optional<std::string>& name) {
  static const json kSchema = parseJson(kDriveSchema);
  json root = parseStrict(readWholeFile(file, uint64_t{1} << 28), file.string());
  const std::vector<std::string> mistakes = mistakesOf(root, kSchema);
  if (!mistakes.empty()) refuseAll(file, mistakes);
  if (seed) root["seed"] = *seed;
  if (name) root["name"] = *name;
  if (!root.contains("name")) root["name"] = nameOf(file);
  return DriveReader(file, root).read(file);
}

}  // namespace gnosphere::drive
