// SPDX-License-Identifier: Apache-2.0
#include "scanning.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include "base/file.hpp"
#include "console.hpp"

namespace gnosphere::cli {

const std::map<std::string, Accuracy> kAccuracies = {{"paper", Accuracy::paper},
                                                     {"draft", Accuracy::draft},
                                                     {"standard", Accuracy::standard},
                                                     {"exact", Accuracy::exact}};

namespace {

const std::map<std::string, ReflectingFaces> kFaces = {
    {"material", ReflectingFaces::material}, {"front", ReflectingFaces::front}, {"both", ReflectingFaces::both}};
const std::map<std::string, Binning> kBinnings = {
    {"auto", Binning::automatic}, {"nearest", Binning::nearest}, {"lists", Binning::lists}, {"slabs", Binning::slabs}};
const std::map<std::string, UpAxis> kUpAxes = {{"", UpAxis::formatDefault}, {"y", UpAxis::y}, {"z", UpAxis::z}};

/// Parses finite numbers separated by `separator` (spaces around it are allowed); empty if the text is anything else.
std::vector<double> parseNumbers(std::string_view text, char separator) {
  std::vector<double> numbers;
  const char* at = text.data();
  const char* end = at + text.size();
  const auto isBlank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (at <= end) {
    while (at < end && (isBlank(*at) || *at == '+')) ++at;
    double value = 0;
    const auto result = std::from_chars(at, end, value);
    if (result.ec != std::errc() || !std::isfinite(value)) return {};
    numbers.push_back(value);
    at = result.ptr;
    while (at < end && isBlank(*at)) ++at;
    if (at == end) break;
    const bool separated = separator == ' ' ? at > result.ptr : *at == separator;
    if (!separated) return {};
    if (separator != ' ') ++at;
  }
  return numbers;
}

/// Tolerance on a quaternion's length, because files have few digits; a larger deviation means that it is no unit
/// quaternion.
constexpr double kUnitTolerance = 0.01;

Pose parsePose(const std::string& text) {
  const std::vector<double> numbers = parseNumbers(text, ',');
  if (numbers.size() != 3 && numbers.size() != 7) {
    throw Error(ErrorCode::invalidArgument,
                "--pose: '" + text + "' is not X,Y,Z or X,Y,Z,QX,QY,QZ,QW with finite numbers");
  }
  Pose pose;
  pose.position = {numbers[0], numbers[1], numbers[2]};
  if (numbers.size() == 3) return pose;
  const double norm = std::hypot(std::hypot(numbers[3], numbers[4]), std::hypot(numbers[5], numbers[6]));
  if (!(norm > 1e-6) || !std::isfinite(norm)) {
    throw Error(ErrorCode::invalidArgument, "--pose: the quaternion '" + text + "' has no length");
  }
  pose.orientation = {numbers[3] / norm, numbers[4] / norm, numbers[5] / norm, numbers[6] / norm};
  return pose;
}

/// The rotation b followed by the rotation a.
Quaternion product(const Quaternion& a, const Quaternion& b) {
  return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
          a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

}  // namespace

void addScanningOptions(CLI::App& app, ScanningOptions& options) {
  app.add_option("SCENE", options.scene, "A .gltf, .glb, .obj, .ply or .stl file")->required();
  app.add_option("--sensor", options.sensor,
                 "A built-in name (gnosphere sensors), with :MODE if wanted, or a sensor file")
      ->capture_default_str();
  app.add_option("--pose", options.pose,
                 "Position in metres and orientation of the sensor, X,Y,Z[,QX,QY,QZ,QW] (default: 1.8 m above "
                 "the origin, or above the middle of a scene that is elsewhere)");
  app.add_option("--faces", options.faces, "Faces that reflect light")
      ->check(CLI::IsMember(kFaces))
      ->capture_default_str();
  app.add_option("--binning", options.binning, "How triangles are assigned to beams; every choice gives the same cloud")
      ->check(CLI::IsMember(kBinnings))
      ->capture_default_str();
  app.add_option("--up", options.up, "The scene's upward axis (default: that of its format)")
      ->check(CLI::IsMember({"y", "z"}));
  app.add_option("--scale", options.scale, "Scene units in metres")->capture_default_str();
  app.add_option("--device", options.device,
                 "auto, a number or part of a name of gnosphere devices, cuda:N, cuda-fast:N, or reference")
      ->capture_default_str();
  app.add_flag("--validation", options.validation, "Enable the Vulkan validation layer; its messages are errors");
}

CLI::Option* addAccuracyOption(CLI::App& app, std::string& accuracy) {
  return app
      .add_option("--accuracy", accuracy,
                  "paper: exactly as published; draft: without gaps between boxes; standard: watertight; exact: the "
                  "same bytes on every device")
      ->check(CLI::IsMember(kAccuracies))
      ->capture_default_str();
}

void checkScanning(const ScanningOptions& options) {
  if (!std::isfinite(options.scale) || options.scale <= 0) {
    throw Error(ErrorCode::invalidArgument, "--scale must be finite and above 0");
  }
  if (!options.pose.empty()) parsePose(options.pose);
}

Sensor sensorOf(const std::string& nameOrFile) {
  return namedOrLoaded(nameOrFile, builtinSensor, loadSensor);
}

SimulatorOptions simulatorOptions(const ScanningOptions& options) {
  SimulatorOptions settings;
  settings.device = deviceByName(options.device);
  settings.faces = kFaces.at(options.faces);
  settings.tuning.binning = kBinnings.at(options.binning);
  settings.validation = options.validation;
  settings.warn = [](const std::string& message) { complain("warning: " + message); };
  return settings;
}

Scene loadScene(const ScanningOptions& options) {
  return gnosphere::loadScene(options.scene, {kUpAxes.at(options.up), options.scale});
}

Pose poseOf(const ScanningOptions& options, const Scene& scene) {
  if (!options.pose.empty()) return parsePose(options.pose);
  Pose pose;
  pose.position = {0, 0, 1.8};
  const Bounds bounds = worldBounds(scene);
  const bool aroundOrigin = bounds.min.x <= 0 && bounds.max.x >= 0 && bounds.min.y <= 0 && bounds.max.y >= 0;
  if (bounds.empty() || aroundOrigin) return pose;
  pose.position = {(bounds.min.x + bounds.max.x) / 2, (bounds.min.y + bounds.max.y) / 2, bounds.min.z + 1.8};
  return pose;
}

std::vector<Pose> posesAround(const Pose& around, size_t count) {
  constexpr double kReach = 10;
  std::vector<Pose> poses;
  std::mt19937 random(1);
  const auto uniform = [&] { return 2.0 * static_cast<double>(random()) / 4294967295.0 - 1; };
  for (size_t i = 0; i < count; ++i) {
    poses.push_back(around);
    if (i == 0) continue;
    poses.back().position.x += kReach * uniform();
    poses.back().position.y += kReach * uniform();
    const double half = std::numbers::pi / 2 * uniform();
    poses.back().orientation = product({0, 0, std::sin(half), std::cos(half)}, around.orientation);
  }
  return poses;
}

std::vector<SensorMotion::Stamp> loadStampedTrajectory(const std::filesystem::path& file) {
  const std::string text = readWholeFile(file, uint64_t{1} << 30);
  std::vector<SensorMotion::Stamp> stamps;
  size_t number = 0;
  for (size_t at = 0; at < text.size();) {
    const size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view line(text.data() + at, end - at);
    at = end + 1;
    ++number;
    const size_t first = line.find_first_not_of(" \t\r");
    if (first == std::string_view::npos || line[first] == '#') continue;
    const auto refuse = [&](const char* why) {
      throw Error(ErrorCode::format, file.string() + ": line " + std::to_string(number) + " " + why);
    };
    const std::vector<double> v = parseNumbers(line, ' ');
    if (v.size() < 8) refuse("is not t x y z qx qy qz qw, eight finite numbers with spaces between");
    if (v.size() == 12) refuse("has 12 numbers, as KITTI's matrices do; t x y z qx qy qz qw is wanted");
    const double norm = std::hypot(std::hypot(v[4], v[5]), std::hypot(v[6], v[7]));
    if (!(std::abs(norm - 1) < kUnitTolerance)) refuse("has a quaternion whose length is not 1");
    stamps.push_back({v[0], {{v[1], v[2], v[3]}, {v[4] / norm, v[5] / norm, v[6] / norm, v[7] / norm}}});
  }
  if (stamps.empty()) throw Error(ErrorCode::format, file.string() + ": has no pose");
  return stamps;
}

std::vector<Pose> loadTrajectory(const std::filesystem::path& file) {
  std::vector<Pose> poses;
  for (const SensorMotion::Stamp& stamp : loadStampedTrajectory(file)) poses.push_back(stamp.pose);
  return poses;
}

void checkOutputFiles(const std::vector<std::string>& files, const std::string& scene) {
  std::set<std::string> seen;
  for (const std::string& file : files) {
    std::error_code absent;
    if (std::filesystem::equivalent(file, scene, absent)) {
      throw Error(ErrorCode::invalidArgument, file + " is the scene itself; choose another output file");
    }
    if (!seen.insert(file).second) {
      throw Error(ErrorCode::invalidArgument, file + " is given twice; use different names");
    }
    checkWritable(file);
  }
}

}  // namespace gnosphere::cli
