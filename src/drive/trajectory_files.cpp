// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <pugixml.hpp>
#include <system_error>

#include "base/file.hpp"
#include "base/json_text.hpp"
#include "base/text.hpp"
#include "base/utf8.hpp"
#include "drive/number_list.hpp"
#include "drive/pose_math.hpp"
#include "drive/trajectory.hpp"

namespace gnosphere::drive {
namespace {

using Stamps = std::vector<Trajectory::Stamp>;

constexpr uint64_t kLargestFile = uint64_t{1} << 30;

/// A line of a file of numbers. `refuse` throws an error that names it.
struct Line {
  const std::filesystem::path& file;
  size_t number;
  std::string_view text;

  [[noreturn]] void refuse(const std::string& why) const {
    throw Error(ErrorCode::format, file.string() + ": line " + std::to_string(number) + " " + why);
  }
  [[noreturn]] void refuseColumns(const std::string& wanted) const {
    refuse("is not " + wanted + (number == 1 ? "; # begins a comment, such as the names of columns" : ""));
  }
  Quaternion unit(const Quaternion& q) const {
    if (!isUnit(q)) refuse("has a quaternion whose length is not 1");
    return normalized(q);
  }
};

/// Calls use(line) for every line that has more than blanks and a comment; the line is without its comment. Lines end
/// as those of any system.
template <typename Use>
void eachLine(const std::filesystem::path& file, const Use& use) {
  const std::string bytes = readWholeFile(file, kLargestFile);
  const std::string_view text = textOfFile(bytes, file.string());
  size_t number = 0;
  for (size_t at = 0; at < text.size();) {
    const size_t end = std::min(text.find_first_of("\r\n", at), text.size());
    std::string_view line(text.data() + at, end - at);
    line = line.substr(0, line.find('#'));
    at = end + (text.compare(end, 2, "\r\n") == 0 ? 2 : 1);
    ++number;
    if (line.find_first_not_of(" \t") != std::string_view::npos) use(Line{file, number, line});
  }
}

/// Whether these are the columns of a rotation, with the few digits that files have.
bool isRotation(const Vec3& x, const Vec3& y, const Vec3& z) {
  const auto near = [](double value, double wanted) { return std::abs(value - wanted) < kUnitTolerance; };
  return near(dot(x, x), 1) && near(dot(y, y), 1) && near(dot(z, z), 1) && near(dot(x, y), 0) && near(dot(y, z), 0) &&
         near(dot(cross(x, y), z), 1);
}

/// A camera looks along z, with x to the right and y down; a vehicle along x, with y to the left and z up.
Vec3 fromCamera(const Vec3& v) {
  return {v.z, -v.x, -v.y};
}

Stamps readKitti(const std::filesystem::path& file, const std::filesystem::path& timesFile) {
  if (timesFile.empty()) throw Error(ErrorCode::format, file.string() + ": needs the file of its times, \"times\"");
  std::vector<double> times;
  eachLine(timesFile, [&](const Line& line) {
    const std::vector<double> v = parseNumbers(line.text, ' ');
    if (v.size() != 1) line.refuse("is not one time in seconds");
    times.push_back(v[0]);
  });
  Stamps stamps;
  eachLine(file, [&](const Line& line) {
    const std::vector<double> v = parseNumbers(line.text, ' ');
    if (v.size() != 12) line.refuse("is not a matrix of 3 rows and 4 columns, twelve numbers");
    if (stamps.size() == times.size()) line.refuse("has no time in " + timesFile.string());
    // The matrix maps camera to world, both with the axes of a camera. Column j of ours is where it sends our axis j.
    const auto column = [&](size_t j) { return fromCamera({v[j], v[4 + j], v[8 + j]}); };
    const Vec3 x = column(2), y = -1.0 * column(0), z = -1.0 * column(1);
    const Quaternion turn = quaternionOf({Vec3{x.x, y.x, z.x}, Vec3{x.y, y.y, z.y}, Vec3{x.z, y.z, z.z}});
    if (!isRotation(x, y, z)) line.refuse("is no rotation and translation");
    stamps.push_back({times[stamps.size()], {column(3), turn}});
  });
  if (stamps.size() != times.size())
    throw Error(ErrorCode::format, timesFile.string() + ": has " + std::to_string(times.size()) + " times for the " +
                                       std::to_string(stamps.size()) + " poses of " + file.string());
  return stamps;
}

/// Reads lines t,x,y,z,qw,qx,qy,qz with t in nanoseconds; further columns are ignored.
Stamps readEuroc(const std::filesystem::path& file) {
  Stamps stamps;
  eachLine(file, [&](const Line& line) {
    const std::vector<double> v = parseNumbers(line.text, ',');
    if (v.size() < 8) line.refuseColumns("t,x,y,z,qw,qx,qy,qz, eight finite numbers with commas between");
    int64_t nanoseconds = 0;
    const std::string_view time = trimmed(line.text.substr(0, line.text.find(',')), " \t");
    const auto end = time.data() + time.size();
    if (const auto read = std::from_chars(time.data(), end, nanoseconds); read.ec != std::errc() || read.ptr != end)
      line.refuse("has a time that is not nanoseconds");
    stamps.push_back(
        {static_cast<double>(nanoseconds) / 1e9, {{v[1], v[2], v[3]}, line.unit({v[5], v[6], v[7], v[4]})}});
  });
  return stamps;
}

/// ego_pose.json, a list of {"timestamp": microseconds, "translation": [x, y, z], "rotation": [w, x, y, z]}.
Stamps readNuScenes(const std::filesystem::path& file) {
  const nlohmann::json rows = parseStrict(readWholeFile(file, kLargestFile), file.string());
  std::map<int64_t, Pose> poses;  // several sensors may have poses of one time, of which the first one counts
  try {
    for (const nlohmann::json& row : rows) {
      const auto p = row.at("translation").get<std::array<double, 3>>();
      const auto turn = row.at("rotation").get<std::array<double, 4>>();
      const Quaternion q = {turn[1], turn[2], turn[3], turn[0]};
      if (!isUnit(q)) throw Error(ErrorCode::format, file.string() + ": has a rotation whose length is not 1");
      poses.try_emplace(row.at("timestamp").get<int64_t>(), Pose{{p[0], p[1], p[2]}, normalized(q)});
    }
  } catch (const nlohmann::json::exception&) {
    throw Error(ErrorCode::format, file.string() +
                                       ": is not a list of {\"timestamp\": microseconds, \"translation\": [x, y, z], "
                                       "\"rotation\": [w, x, y, z]}");
  }
  Stamps stamps;
  for (const auto& [time, pose] : poses) stamps.push_back({static_cast<double>(time) / 1e6, pose});
  return stamps;
}

/// CARLA's y axis points to the right.
Vec3 fromCarla(const Vec3& v) {
  return {v.x, -v.y, v.z};
}

/// Lines x,y,z,t as ScenarioRunner logs a vehicle.
Stamps readCarla(const std::filesystem::path& file) {
  Stamps stamps;
  eachLine(file, [&](const Line& line) {
    const std::vector<double> v = parseNumbers(line.text, ',');
    if (v.size() != 4) line.refuseColumns("x,y,z,t, four finite numbers with commas between");
    stamps.push_back({v[3], {fromCarla({v[0], v[1], v[2]}), {}}});
  });
  return stamps;
}

/// <routes><route id=""><waypoints><position x="" y="" z=""/>; older files have <waypoint> in the route itself.
Stamps readCarlaRoute(const std::filesystem::path& file, const TrajectoryFileOptions& options) {
  const auto refuse = [&](const std::string& why) { throw Error(ErrorCode::format, file.string() + ": " + why); };
  if (!(options.speed > 0)) refuse("a route has no times; give its \"speed\" in metres a second");
  const std::string text = readWholeFile(file, kLargestFile);
  pugi::xml_document document;
  const auto result = document.load_buffer(text.data(), text.size());
  if (!result) refuse(std::string("is not XML: ") + result.description());
  const auto routes = document.child("routes");
  const auto route = options.route.empty() ? routes.child("route")
                                           : routes.find_child_by_attribute("route", "id", options.route.c_str());
  if (!route) refuse(options.route.empty() ? "has no route" : "has no route '" + options.route + "'");
  Stamps stamps;
  const auto add = [&](const pugi::xml_node& place) {
    const auto number = [&](const char* name) {
      const std::vector<double> one = parseNumbers(place.attribute(name).value(), ' ');
      return one.size() == 1 ? one[0] : std::numeric_limits<double>::quiet_NaN();
    };
    const Vec3 p = fromCarla({number("x"), number("y"), number("z")});
    if (!std::isfinite(p.x + p.y + p.z)) refuse("has a waypoint without finite x, y and z");
    double time = 0;
    if (!stamps.empty()) {
      const double distance = lengthOf(p - stamps.back().pose.position);
      if (!(distance > 0)) return;
      time = stamps.back().time + distance / options.speed;
    }
    stamps.push_back({time, {p, {}}});
  };
  for (const auto& place : route.child("waypoints").children("position")) add(place);
  for (const auto& place : route.children("waypoint")) add(place);
  return stamps;
}

}  // namespace

Stamps readTum(const std::filesystem::path& file) {
  Stamps stamps;
  eachLine(file, [&](const Line& line) {
    const std::vector<double> v = parseNumbers(line.text, ' ');
    if (v.size() < 8) line.refuseColumns("t x y z qx qy qz qw, eight finite numbers with spaces between");
    if (v.size() == 12) line.refuse("has 12 numbers, as KITTI's matrices do; t x y z qx qy qz qw is wanted");
    stamps.push_back({v[0], {{v[1], v[2], v[3]}, line.unit({v[4], v[5], v[6], v[7]})}});
  });
  if (stamps.empty()) throw Error(ErrorCode::format, file.string() + ": has no pose");
  return stamps;
}

Stamps readTrajectory(const std::filesystem::path& file, const std::string& format,
                      const TrajectoryFileOptions& options) {
  if (file.extension() == ".feather")
    throw Error(ErrorCode::format,
                file.string() +
                    ": Argoverse 2's feather files are read by Python; pandas.read_feather gives the "
                    "columns, to be written as lines t x y z qx qy qz qw (docs/drives.md)");
  const std::string ending = lower(file.extension().string());
  if (ending == ".sbet" || (ending == ".out" && lower(file.filename().string()).starts_with("sbet")))
    throw Error(ErrorCode::format, file.string() +
                                       ": SBET is read by Python, which knows projections; docs/surveys.md has the "
                                       "few lines that write it as t x y z qx qy qz qw");
  if (format == "tum") return readTum(file);
  Stamps stamps = format == "kitti"      ? readKitti(file, options.times)
                  : format == "euroc"    ? readEuroc(file)
                  : format == "nuscenes" ? readNuScenes(file)
                  : format == "carla"    ? readCarla(file)
                                         : readCarlaRoute(file, options);
  if (stamps.empty()) throw Error(ErrorCode::format, file.string() + ": has no pose");
  return stamps;
}

std::string doubtOfSeconds(double spacing) {
  const char* unit = spacing < 1e3 ? "milliseconds" : spacing < 1e6 ? "microseconds" : "nanoseconds";
  return "has a pose every " + gnosphere::numberText(std::round(spacing)) +
         " s; times are in seconds, and these look like " + unit;
}

}  // namespace gnosphere::drive
