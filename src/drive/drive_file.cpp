// SPDX-License-Identifier: Apache-2.0
// Reads a Drive from JSON. The schema decides what the words are and which values they take; what it cannot say is
// checked here: names that refer to something, and the files.
#include <algorithm>
#include <cctype>
#include <set>

#include "base/file.hpp"
#include "base/json_text.hpp"
#include "base/os.hpp"
#include "base/path.hpp"
#include "base/text.hpp"
#include "drive/drive_reader.hpp"
#include "drive/fingerprint.hpp"
#include "drive/formats/format.hpp"
#include "drive/ros.hpp"
#include "drive/schedule.hpp"
#include "drive/schema_check.hpp"
#include "drive_schema.h"
#include "sensor/beams.hpp"

namespace gnosphere::drive {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr double kLastTime = 9.2e9;          // s: the year 2261
constexpr double kFirstGpsTime = 315964800;  // s: 6 January 1980
constexpr size_t kMostCrsBytes = 65534;      // of a record of LAS, with a zero behind them

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

}  // namespace

void DriveReader::classes() {
  for (const auto& [name, object] : memberOf(root_, "classes").items()) {
    const uint16_t id = object["id"].get<uint16_t>();
    drive_.classes.push_back({name, id, object.value("moving_id", id)});
    classNames_.push_back(name);
  }
}

/// Gives each instance or material the class of the longest pattern in `table` that its name matches. Others have the
/// class that their file states by number or name, and otherwise `usual`. Adds stated classes that the drive does not
/// name to `unknown`.
template <typename Named>
void DriveReader::classify(const json& object, const std::string& path, const std::string& table, uint16_t usual,
                           std::vector<Named>& all, std::set<std::string>& unknown) {
  std::vector<std::optional<std::pair<size_t, uint16_t>>> matches(all.size());  // length of the pattern, class
  for (const auto& [pattern, name] : memberOf(object, table.c_str()).items()) {
    const uint16_t id = classNamed(name, memberPath(path + "." + table, pattern));
    bool any = false;
    for (size_t i = 0; i < all.size(); ++i) {
      if (!os::fits(pattern, all[i].name)) continue;
      any = true;
      if (!matches[i] || pattern.size() >= matches[i]->first) matches[i] = {pattern.size(), id};
    }
    if (!any)
      drive_.warnings.push_back(path + "." + table + ": '" + pattern + "' matches no " +
                                table.substr(0, table.size() - 1));
  }
  for (size_t i = 0; i < all.size(); ++i) {
    Named& named = all[i];
    if (matches[i]) {
      named.classId = matches[i]->second;
      continue;
    }
    if (named.classId == 0 && !named.className.empty()) {
      const auto known = std::ranges::find(drive_.classes, named.className, &Class::name);
      if (known != drive_.classes.end())
        named.classId = known->id;
      else
        unknown.insert(inQuotes(named.className));
    } else if (named.classId != 0 &&
               std::ranges::find(drive_.classes, named.classId, &Class::id) == drive_.classes.end()) {
      unknown.insert(std::to_string(named.classId));
    }
    if (named.classId == 0) named.classId = usual;
  }
}

uint16_t DriveReader::classNamed(const json& name, const std::string& path) {
  const size_t found = find(classNames_, name, path);
  return found < drive_.classes.size() ? drive_.classes[found].id : uint16_t{0};
}

void DriveReader::warnOfClasses(const std::set<std::string>& unknown, const std::string& path) {
  for (const std::string& stated : unknown)
    drive_.warnings.push_back(path + ".file: states the class " + stated + ", which classes does not name");
}

void DriveReader::scenes() {
  for (size_t i = 0; i < root_["scenes"].size(); ++i) {
    const std::string path = entryPath("scenes", i);
    Scene scene = this->scene(root_["scenes"][i], path);
    const json& object = root_["scenes"][i];
    const uint16_t usual = object.contains("class") ? classNamed(object["class"], path + ".class") : uint16_t{0};
    std::set<std::string> unknown;
    classify(object, path, "instances", usual, scene.instances, unknown);
    classify(object, path, "materials", 0, scene.materials, unknown);
    warnOfClasses(unknown, path);
    if (object.contains("boxes")) takeBoxed(object, path, scene);
    drive_.sceneAnimations.push_back(animation(root_["scenes"][i], path, scene));
    drive_.scenes.push_back(std::move(scene));
  }
}

/// Makes actors of the instances of a scene that have boxes.
void DriveReader::takeBoxed(const json& object, const std::string& path, Scene& scene) {
  if (object.contains("animation"))
    refuse(path + ".boxes", "cannot be with an animation; make actors of what it moves");
  std::map<uint16_t, size_t> categories;  // by the number of the class
  for (size_t i = 0; i < object["boxes"].size(); ++i) {
    const size_t category = find(classNames_, object["boxes"][i], entryPath(path + ".boxes", i));
    if (category < drive_.classes.size()) categories.try_emplace(drive_.classes[category].id, category);
  }
  const size_t before = standing_.actors.size();
  takeStanding(
      scene,
      [&](const Instance& instance) -> std::optional<size_t> {
        const auto found = categories.find(instance.classId);
        return found == categories.end() ? std::optional<size_t>() : found->second;
      },
      standing_);
  if (standing_.actors.size() == before)
    drive_.warnings.push_back(path + ".boxes: no instance has any of these classes");
}

/// Appends the actors that scenes have had, with names of their own.
void DriveReader::addStanding() {
  std::set<std::string> names;
  for (const Actor& actor : drive_.actors) names.insert(actor.name);
  for (Actor& actor : standing_.actors) {
    const std::string stated = actor.name;
    for (int number = 2; !names.insert(actor.name).second; ++number)
      actor.name = stated + " (" + std::to_string(number) + ")";
    actor.model += drive_.models.size();
    drive_.actors.push_back(std::move(actor));
  }
  for (Scene& model : standing_.models) drive_.models.push_back(std::move(model));
}

void DriveReader::models() {
  for (const auto& [name, object] : memberOf(root_, "models").items()) {
    modelNames_.push_back(name);
    const std::string path = memberPath("models", name);
    Scene model = scene(object, path);
    std::set<std::string> unknown;
    classify(object, path, "materials", 0, model.materials, unknown);
    warnOfClasses(unknown, path);
    if (model.instances.empty() && mistakes_.empty()) refuse(path, "has no triangles");
    drive_.models.push_back(std::move(model));
  }
}

void DriveReader::materialTable() {
  const json& name = memberOf(root_, "material_table");
  if (name.is_null()) return;
  Scene all;
  for (const std::vector<Scene>* scenes : {&drive_.scenes, &drive_.models})
    for (const Scene& scene : *scenes)
      all.materials.insert(all.materials.end(), scene.materials.begin(), scene.materials.end());
  attempt("material_table", [&] {
    drive_.materials = loadMaterialTable(file(name));
    std::vector<std::string> unused;
    opticsOf(all, drive_.materials, 905, &unused);
    for (const std::string& row : unused)
      drive_.warnings.push_back("material_table: no scene or model has the material " + inQuotes(row));
  });
}

void DriveReader::actors() {
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
    if (actor.model < drive_.models.size()) actor.animation = animation(list[i], path, drive_.models[actor.model]);
    actor.goneOutside = list[i].value("outside", "hold") == "gone";
    drive_.actors.push_back(std::move(actor));
  }
}

/// Checks the name of a sensor or of the inertial unit.
void DriveReader::checkName(const std::string& name, const std::string& path) {
  const auto isPlain = [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-'; };
  if (!std::all_of(name.begin(), name.end(), isPlain))
    refuse(path + ".name", "must have letters, digits, _ and - only, is " + shown(json(name)));
  if (!names_.insert(name).second) refuse(path + ".name", inQuotes(name) + " is there twice");
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
}

void DriveReader::sensors() {
  for (size_t i = 0; i < root_["sensors"].size(); ++i) {
    const json& object = root_["sensors"][i];
    const std::string path = entryPath("sensors", i);
    RigSensor rigged;
    rigged.name = object["name"].get<std::string>();
    checkName(rigged.name, path);
    rigged.sensor = sensor(object["sensor"], path + ".sensor");
    rigged.effects = effects(memberOf(object, "effects"), path + ".effects");
    rigged.mount = pose(memberOf(object, "mount"), path + ".mount");
    const double period = scanPeriodOf(rigged.sensor);
    rigged.rate = object.value("rate", period * drive_.rate > 1 ? 1 / period : drive_.rate);
    rigged.offset = object.value("offset", 0.0);
    rigged.livoxCustom = object.value("driver", "") == "livox-custom";
    if (object.contains("driver")) rigged.driver = ros2::driverNamed(object["driver"].get<std::string>());
    if (rigged.rate * period > 1 + 1e-9)
      refuse(path + ".rate",
             "is " + shown(object["rate"]) + " scans a second, but the sensor takes " + shown(period) + " s for one");
    if (const double last = lastTimeOf(rigged.sensor); rigged.rate * last > 1 + 1e-9)
      refuse(path + ".rate", "is " + gnosphere::numberText(rigged.rate) +
                                 " scans a second, but the last beam of a scan fires " + gnosphere::numberText(last) +
                                 " s after its start");
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

/// Checks that the folder of an output lies in the output folder of the drive, beside those of other outputs.
void DriveReader::checkFolder(const std::string& name, const std::string& path) {
  fs::path folder = pathOf(name).lexically_normal();
  if (folder.filename().empty()) folder = folder.parent_path();  // "a/" is "a"
  const std::string top = folder.begin()->string();
  if (folder.is_absolute() || top == ".." || top == "." || top == "manifest" || top == "objects.json" ||
      top == "classes.json")
    refuse(path, "must be a folder in the output folder, other than manifest and the files beside it");
  const auto holds = [](const fs::path& outer, const fs::path& inner) {
    return std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first == outer.end();
  };
  for (const fs::path& other : folders_)
    if (holds(other, folder) || holds(folder, other)) refuse(path, "another output writes there, too");
  folders_.push_back(folder);
}

/// Returns the sensors that an output writes: those that it lists, or else all, or the first where its format has one.
std::vector<size_t> DriveReader::sensorsOf(const json& output, bool oneSensor, const std::string& path) {
  std::vector<std::string> names;
  for (const RigSensor& sensor : drive_.sensors) names.push_back(sensor.name);
  const json& listed = memberOf(output, "sensors");
  std::vector<size_t> sensors;
  for (size_t s = 0; s < listed.size(); ++s) sensors.push_back(find(names, listed[s], entryPath(path, s)));
  if (listed.is_null())
    for (size_t s = 0; s < (oneSensor ? 1 : names.size()); ++s) sensors.push_back(s);
  if (oneSensor && sensors.size() > 1) refuse(path, "the format has one lidar; name one sensor");
  return sensors;
}

/// Checks that ROS 2 can play the bag of an output.
void DriveReader::checkBag(const Output& output, const std::string& path) {
  if (const std::string why = mistakeOfNames(drive_, output.sensors); !why.empty()) refuse(path + ".sensors", why);
  if (const std::string why = mistakeOfTimes(drive_); !why.empty()) refuse(path + ".format", why);
  if (drive_.epoch + drive_.start < 0)
    refuse(path + ".format", "MCAP has no times before 1970; the drive begins at " +
                                 shown(drive_.epoch + drive_.start) + " s: give an epoch");
}

/// Warns of sensors that start no scan in some of the frames that are samples.
void DriveReader::warnOfSamples(const Output& output, const std::string& path) {
  constexpr uint64_t kMost = 1000;  // samples that are looked at
  std::vector<uint64_t> missed(drive_.sensors.size());
  uint64_t samples = 0;
  for (; samples < kMost && samples * output.keyframes < drive_.frameCount(); ++samples) {
    std::vector<bool> seen(drive_.sensors.size());
    for (const PlannedScan& scan : scansOf(drive_, samples * output.keyframes)) seen[scan.sensor] = true;
    for (size_t sensor : output.sensors) missed[sensor] += seen[sensor] ? 0 : 1;
  }
  for (size_t sensor : output.sensors)
    if (missed[sensor] > 0)
      drive_.warnings.push_back(path + ": " + inQuotes(drive_.sensors[sensor].name) + " starts no scan in " +
                                std::to_string(missed[sensor]) + " of " + std::to_string(samples) +
                                " samples, which lack its data, because it makes " +
                                gnosphere::numberText(drive_.sensors[sensor].rate) +
                                " scans a second; choose another rate or other keyframes");
}

/// Reads and checks what an output states of a survey.
void DriveReader::survey(const json& object, Output& output, const std::string& path) {
  for (const Field field : output.fields)
    if (const std::string why = mistakeOfLasField(field); !why.empty()) refuse(path + ".fields", why);
  for (const Class& category : drive_.classes)
    if (category.id > 255)
      refuse(path + ".format",
             "LAS has classes 0 to 255; " + inQuotes(category.name) + " has the id " + std::to_string(category.id));
  if (drive_.epoch + drive_.start < kFirstGpsTime)
    drive_.warnings.push_back(path + ".format: LAS has GPS times, and the drive begins before 1980; give an epoch");
  output.crs = object.value("crs", "");
  const std::string_view text = trimmed(output.crs, " \t\r\n");
  const size_t word = text.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ_");
  const bool isWkt = word != text.npos && word > 0 && (text[word] == '[' || text[word] == '(') &&
                     (text.back() == ']' || text.back() == ')');
  if (output.crs.size() > kMostCrsBytes || output.crs.find('\0') != std::string::npos)
    refuse(path + ".crs", "must be well-known text of at most " + std::to_string(kMostCrsBytes) + " bytes");
  else if (!isWkt && object.contains("crs"))
    refuse(path + ".crs", "must be well-known text (WKT), as pyproj.CRS(25832).to_wkt(\"WKT1_GDAL\") gives it, is " +
                              inQuotes(output.crs.substr(0, 80)));
  output.flightLine = object.value("flight_line", uint16_t{0});
  if (output.flightLine + drive_.sensors.size() > 65536)
    refuse(path + ".flight_line", "is " + std::to_string(output.flightLine) + ", and each of " +
                                      std::to_string(drive_.sensors.size()) +
                                      " sensors has a number of its own; LAS has numbers up to 65535");
  output.oneFile = object.value("one_file", false);
}

void DriveReader::outputs() {
  for (size_t i = 0; i < root_["outputs"].size(); ++i) {
    const json& object = root_["outputs"][i];
    const std::string path = entryPath("outputs", i);
    Output output;
    output.format = object["format"].get<std::string>();
    output.folder = object.value("folder", output.format);
    const FormatInfo& format = formatNamed(output.format);
    checkFolder(output.folder, path + ".folder");
    output.sensors = sensorsOf(object, format.oneSensor, path + ".sensors");
    if (object.contains("fields") && !format.fields)
      refuse(path + ".fields", "is only for " + formatNames([](const FormatInfo& f) { return f.fields != nullptr; }));
    if (const std::string fields = object.value("fields", format.fields ? format.fields : ""); !fields.empty())
      attempt(path + ".fields", [&] { output.fields = parseFields(fields); });
    if (object.contains("keyframes") && !format.keyframes)
      refuse(path + ".keyframes", "is only for " + formatNames([](const FormatInfo& f) { return f.keyframes; }));
    output.keyframes = object.value("keyframes", uint64_t{5});
    for (const char* name : {"crs", "flight_line", "one_file"})
      if (object.contains(name) && !format.survey)
        refuse(memberPath(path, name), "is only for " + formatNames([](const FormatInfo& f) { return f.survey; }));
    if (format.keyframes && mistakes_.empty()) warnOfSamples(output, path);
    if (format.survey) survey(object, output, path);
    if (output.format == "mcap" && mistakes_.empty()) checkBag(output, path);
    drive_.outputs.push_back(std::move(output));
  }
}

Drive DriveReader::read(const fs::path& file) {
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
  if (!mistakes_.empty()) refuseAll(file, mistakes_);
  drive_.fingerprint = fingerprintOf(drive_, jsonText(root_));
  return std::move(drive_);
}

Drive readDrive(const fs::path& file) {
  static const json kSchema = parseJson(kDriveSchema);
  const json root = parseStrict(readWholeFile(file, uint64_t{1} << 28), file.string());
  const std::vector<std::string> mistakes = mistakesOf(root, kSchema);
  if (!mistakes.empty()) refuseAll(file, mistakes);
  return DriveReader(file, root).read(file);
}

}  // namespace gnosphere::drive
