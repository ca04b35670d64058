// SPDX-License-Identifier: Apache-2.0
// Reads the outputs of a drive from its file.
#include <algorithm>
#include <cctype>
#include <initializer_list>
#include <set>
#include <utility>

#include "base/text.hpp"
#include "drive/drive_reader.hpp"
#include "drive/formats/format.hpp"
#include "drive/ros.hpp"
#include "drive/schedule.hpp"
#include "ros2/driver_cloud.hpp"

namespace gnosphere::drive {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr double kFirstGpsTime = 315964800;  // s: 6 January 1980
constexpr double kFirstSurvey = 946684800;   // s: 1 January 2000; nobody flies a LiDAR over land before
constexpr size_t kMostCrsBytes = 65534;      // of a record of LAS, with a zero behind them

/// Returns the folder that a name means on systems that take capital and small letters for the same. "a/" is "a".
fs::path foldedFolder(const std::string& name) {
  const fs::path folder = pathOf(lower(name)).lexically_normal();
  return folder.filename().empty() ? folder.parent_path() : folder;
}

/// Whether Windows can hold a file or folder of this name.
bool isOnWindows(const fs::path& part) {
  const std::string name = part.string();
  const auto isHeld = [](unsigned char c) {
    return c >= ' ' && std::string_view("<>:\"\\|?*").find(static_cast<char>(c)) == std::string_view::npos;
  };
  return std::ranges::all_of(name, isHeld) && (name == "." || (!name.ends_with('.') && !name.ends_with(' ')));
}

/// Whether a text can be the version of tables of nuScenes, which is the name of their folder.
bool isVersion(const std::string& text) {
  const auto fits = [](unsigned char c) { return isPlain(c) || c == '.'; };
  return text.size() >= 2 && text.size() <= 100 && text[0] == 'v' &&
         std::isdigit(static_cast<unsigned char>(text[1])) && std::ranges::all_of(text, fits) && text.back() != '.';
}

}  // namespace

/// Checks that the folder of an output lies in the output folder of the drive, beside those of other outputs. Data sets
/// are exchanged, so it must do so on every system.
void DriveReader::checkFolder(const std::string& name, const std::string& path) {
  const fs::path folder = foldedFolder(name), stated = pathOf(name);
  const std::string top = folder.begin()->string();
  // Manifests have the folder as it is stated, and refuse paths that go up on their way.
  if (stated.has_root_path() || std::ranges::find(stated, "..") != stated.end() || top == "." || top == "manifest" ||
      top == "objects.json" || top == "classes.json")
    refuse(path, "must be a folder in the output folder, other than manifest and the files beside it, without '..'");
  else if (!std::ranges::all_of(folder, isOnWindows))
    refuse(path, shown(json(name)) +
                     " cannot be a folder on Windows, where names have none of <>:\"\\|?* and no dot or blank at their "
                     "end; choose another name");
  const auto holds = [](const fs::path& outer, const fs::path& inner) {
    return std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first == outer.end();
  };
  for (const std::string& other : folders_)
    if (holds(foldedFolder(other), folder) || holds(folder, foldedFolder(other)))
      refuse(path, "another output writes there, too, to " + inQuotes(other) +
                       "; folders whose names differ by capital letters alone are one on Windows and macOS");
  if (std::ranges::any_of(folder, [](const fs::path& part) { return namesDevice(part.string()); }))
    refuse(path, inQuotes(name) + " has the name of a device on Windows, where no folder can have it");
  folders_.push_back(name);
}

/// Returns the sensors that an output writes: those that it lists, or else all, or the first where its format has one.
std::vector<size_t> DriveReader::sensorsOf(const json& output, bool oneSensor, const std::string& path) {
  std::vector<std::string> names;
  for (const RigSensor& sensor : drive_.sensors) names.push_back(sensor.name);
  const json& listed = memberOf(output, "sensors");
  std::vector<size_t> sensors;
  std::set<std::string> stated;
  for (size_t s = 0; s < listed.size(); ++s) {
    const std::string name = listed[s].get<std::string>(), at = entryPath(path, s);
    sensors.push_back(find(names, listed[s], at));
    if (!stated.insert(name).second) refuse(at, inQuotes(name) + " is there twice");
  }
  if (listed.is_null())
    for (size_t s = 0; s < (oneSensor ? 1 : names.size()); ++s) sensors.push_back(s);
  if (oneSensor && sensors.size() > 1) refuse(path, "the format has one lidar; name one sensor");
  return sensors;
}

/// Checks that an output with rings, whose numbers have 16 bits, can have those of its sensors.
void DriveReader::checkRings(const Output& output, const std::string& path) {
  const bool chosen = std::ranges::find(output.fields, Field::ring) != output.fields.end();
  if (!chosen && output.format != "nuscenes") return;
  for (const size_t index : output.sensors)
    if (const RigSensor& sensor = drive_.sensors[index]; ros2::lastRingOf(sensor.sensor) > 65535)
      refuse(path + (chosen ? ".fields" : ".sensors"), "the field 'ring' is 16 bits wide, and " +
                                                           inQuotes(sensor.name) + " has " +
                                                           std::to_string(sensor.sensor.height()) + " channels");
}

/// Checks that ROS 2 can play the bag of an output, and that its clouds can have the fields that it `chooses`.
void DriveReader::checkBag(const Output& output, bool chooses, const std::string& path) {
  const auto lacks = [&](Field field) { return std::ranges::find(output.fields, field) == output.fields.end(); };
  if (lacks(Field::x) || lacks(Field::y) || lacks(Field::z))
    refuse(path + ".fields",
           std::string("must have x, y and z, without which nothing shows a cloud; by default they are ") +
               formatNamed(output.format).fields);
  for (const size_t index : output.sensors) {
    const RigSensor& sensor = drive_.sensors[index];
    if (chooses && (sensor.driver || sensor.livoxCustom))
      refuse(path + ".fields", "are not for " + inQuotes(sensor.name) +
                                   ", whose clouds have the fields of its driver; leave out its 'driver', or name the "
                                   "other sensors in 'sensors'");
  }
  if (const std::string why = mistakeOfNames(drive_, output.sensors); !why.empty()) refuse(path + ".sensors", why);
  if (const std::string why = mistakeOfTimes(drive_); !why.empty()) refuse(path + ".format", why);
  if (drive_.epoch + drive_.start < 0)
    refuse(path + ".format", "MCAP has no times before 1970; the drive begins at " +
                                 shown(drive_.epoch + drive_.start) + " s: give an epoch");
}

/// Checks that traces can have the times of the drive, and the fields of an output.
void DriveReader::checkTrace(const Output& output, const std::string& path) {
  for (const Field field : output.fields)
    if (field != Field::radialSpeed)
      refuse(path + ".fields", std::string("OSI's detections have no place for ") + fieldInfo(field).name +
                                   "; beside what they always have they take radial_speed");
  if (drive_.epoch + drive_.start < 0)
    refuse(path + ".format",
           "OSI has no times below 0; the drive begins at " + shown(drive_.epoch + drive_.start) + " s: give an epoch");
}

/// Warns of sensors that start no scan in some of the frames that are samples.
void DriveReader::warnOfSamples(const Output& output, const std::string& path) {
  constexpr uint64_t kMost = 1000;  // samples that are looked at
  uint64_t samples = 0;
  const auto missedScans = [&] {
    std::vector<uint64_t> missed(drive_.sensors.size());
    for (samples = 0; samples < kMost && samples * output.keyframes < drive_.frameCount(); ++samples) {
      std::vector<bool> seen(drive_.sensors.size());
      for (const PlannedScan& scan : scansOf(drive_, samples * output.keyframes)) seen[scan.sensor] = true;
      for (size_t sensor : output.sensors) missed[sensor] += seen[sensor] ? 0 : 1;
    }
    return missed;
  };
  const std::vector<uint64_t> missed = missedScans();
  if (std::ranges::count(missed, 0u) == std::ssize(missed)) return;
  std::vector<double> offsets;
  for (RigSensor& sensor : drive_.sensors) offsets.push_back(std::exchange(sensor.offset, 0));
  const std::vector<uint64_t> missedByRate = missedScans();
  for (size_t sensor = 0; sensor < offsets.size(); ++sensor) drive_.sensors[sensor].offset = offsets[sensor];
  for (size_t sensor : output.sensors) {
    if (missed[sensor] == 0) continue;
    const std::string why = missedByRate[sensor] > 0
                                ? "it makes " + gnosphere::numberText(drive_.sensors[sensor].rate) +
                                      " scans a second; choose another rate or other keyframes"
                                : "its first scan starts " + gnosphere::numberText(offsets[sensor]) +
                                      " s after the start of the drive; choose another offset or other keyframes";
    warn(path, inQuotes(drive_.sensors[sensor].name) + " starts no scan in " + std::to_string(missed[sensor]) + " of " +
                   std::to_string(samples) + " samples, which lack its data, because " + why);
  }
}

/// Warns of causes that tell nothing, because the clouds leave out all beams whose cause is not `returned`.
void DriveReader::warnOfCauses(const Output& output, const std::string& path) {
  if (!output.compact || std::ranges::find(output.fields, Field::cause) == output.fields.end()) return;
  const char* way = formatNamed(output.format).compact ? "with \"compact\": false they have all beams"
                                                       : "an output pcd or npy with \"compact\": false has all beams";
  warn(path + ".fields",
       "have cause, which is 0 (returned) everywhere, because these clouds leave out beams without a return; " +
           std::string(way));
}

/// Reads and checks the members of an output that only surveys have.
void DriveReader::survey(const json& object, Output& output, const std::string& path) {
  for (const Field field : output.fields)
    if (const std::string why = mistakeOfLasField(field); !why.empty()) refuse(path + ".fields", why);
  for (const Class& category : drive_.classes)
    if (category.id > 255)
      refuse(path + ".format",
             "LAS has classes 0 to 255; " + inQuotes(category.name) + " has the id " + std::to_string(category.id));
  const bool hasEpoch = root_.contains("epoch");
  if (drive_.epoch + drive_.start < (hasEpoch ? kFirstGpsTime : kFirstSurvey))
    warn(path + ".format", std::string("LAS has GPS times, and the drive begins before ") +
                               (hasEpoch ? "1980; give another epoch"
                                         : "2000; give an epoch, of adjusted standard GPS times 1315964782"));
  for (size_t sensor : output.sensors)
    if (drive_.sensors[sensor].effects.intensity.scale == Effects::Intensity::Scale::raw)
      warn(path + ".format", "LAS has whole numbers as intensities, and of those of " +
                                 inQuotes(drive_.sensors[sensor].name) +
                                 ", whose intensity.scale is raw, nearly nothing is left; take unit, and divide by the "
                                 "square of the range");
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
  output.scale = object.value("scale", output.scale);
  output.sourcePerScan = object.value("source_per_scan", false);
  if (output.sourcePerScan && object.contains("flight_line"))
    refuse(path + ".source_per_scan",
           "makes the point source the number of the scan, and 'flight_line' states another; "
           "keep one");
  for (size_t sensor : output.sensors)
    if (output.sourcePerScan && drive_.duration * drive_.sensors[sensor].rate > 65535)
      refuse(path + ".source_per_scan",
             inQuotes(drive_.sensors[sensor].name) + " makes more scans than LAS has point sources (65535)");
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
    const auto only = [&](bool (*takes)(const FormatInfo&), std::initializer_list<const char*> words) {
      for (const char* word : words)
        if (object.contains(word) && !takes(format))
          refuse(memberPath(path, word), "is only for " + formatNames(takes));
    };
    only([](const FormatInfo& f) { return f.fields != nullptr; }, {"fields"});
    only([](const FormatInfo& f) { return f.compact; }, {"compact"});
    only([](const FormatInfo& f) { return f.keyframes; }, {"keyframes", "version", "lidarseg"});
    only([](const FormatInfo& f) { return f.sequence; }, {"sequence"});
    only([](const FormatInfo& f) { return f.allActors; }, {"all_actors"});
    only([](const FormatInfo& f) { return f.survey; }, {"crs", "flight_line", "one_file", "scale", "source_per_scan"});
    if (const std::string fields = object.value("fields", format.fields ? format.fields : ""); !fields.empty())
      attempt(path + ".fields", [&] { output.fields = parseFields(fields); });
    if (output.format == "mcap" && !object.contains("fields") && mistakes_.empty())
      output.fields = usualCloudFields(drive_, output.sensors);
    output.compact = object.value("compact", true);
    output.keyframes = object.value("keyframes", uint64_t{5});
    output.version = object.value("version", "v1.0-drive");
    if (!isVersion(output.version))
      refuse(path + ".version",
             "must be v and a number, such as v1.0-mini, with letters, digits, '.', _ and - only, is " +
                 shown(object["version"]));
    output.lidarseg = object.value("lidarseg", false);
    if (output.lidarseg && (drive_.classes.empty() || drive_.classes.size() > 255))
      refuse(path + ".lidarseg",
             "labels have one byte, so the drive needs 1 to 255 classes, has " + std::to_string(drive_.classes.size()));
    if (object.contains("sequence")) output.sequence = object["sequence"].get<uint64_t>();
    output.allActors = object.value("all_actors", false);
    warnOfCauses(output, path);
    if (format.keyframes && mistakes_.empty()) warnOfSamples(output, path);
    if (mistakes_.empty()) checkRings(output, path);
    if (format.survey) survey(object, output, path);
    if (output.format == "mcap" && mistakes_.empty()) checkBag(output, object.contains("fields"), path);
    if (output.format == "osi") checkTrace(output, path);
    drive_.outputs.push_back(std::move(output));
  }
}

/// Checks the numbers of actors, and the classes that files state, against the bits that outputs have for them.
void DriveReader::checkNumbers() {
  const auto checkClasses = [&](const char* what, const auto& all, const std::string& path) {
    const auto found = std::ranges::find_if(all, [](const auto& item) { return item.classId > 255; });
    if (found != all.end())
      refuse(path, std::string("LAS has classes 0 to 255; the file of ") + what + " " + inQuotes(found->name) +
                       " states the id " + std::to_string(found->classId));
  };
  for (size_t i = 0; i < drive_.outputs.size(); ++i) {
    const std::string path = entryPath("outputs", i) + ".format";
    if (drive_.outputs[i].format == "semantickitti" && drive_.actors.size() > 65535)
      refuse(path, "SemanticKITTI labels have 16 bits for the number of an actor; there are " +
                       std::to_string(drive_.actors.size()) + " actors");
    if (!formatNamed(drive_.outputs[i].format).survey) continue;
    for (const Scene& scene : drive_.scenes) checkClasses("instance", scene.instances, path);  // actors have their own
    for (const std::vector<Scene>* scenes : {&drive_.scenes, &drive_.models})
      for (const Scene& scene : *scenes) checkClasses("material", scene.materials, path);
  }
}

}  // namespace gnosphere::drive
