// SPDX-License-Identifier: Apache-2.0
#include "scanning.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include "base/file.hpp"
#include "console.hpp"
#include "drive/number_list.hpp"
#include "drive/trajectory.hpp"

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

void addSceneOptions(CLI::App& app, ScanningOptions& options) {
  app.add_option("SCENE", options.scene, "A .gltf, .glb, .obj, .ply or .stl file")->required();
  app.add_option("--up", options.up, "The scene's upward axis (default: that of its format)")
      ->check(CLI::IsMember({"y", "z"}));
  app.add_option("--scale", options.scale, "Scene units in metres")->capture_default_str();
}

void addScanningOptions(CLI::App& app, ScanningOptions& options) {
  addSceneOptions(app, options);
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
  CLI::Option* animation =
      app.add_option("--animation", options.animation, "Show the scene in this animation of its file (gnosphere info)");
  app.add_option("--time", options.time, "Seconds after the start of the animation, which repeats; default 0")
      ->needs(animation);
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
  if (!std::isfinite(options.time)) throw Error(ErrorCode::invalidArgument, "--time must be finite");
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

Scene loadSceneAtRest(const ScanningOptions& options) {
  return gnosphere::loadScene(options.scene, {kUpAxes.at(options.up), options.scale});
}

Scene loadScene(const ScanningOptions& options) {
  Scene scene = loadSceneAtRest(options);
  for (const std::string& line : scene.leftOut) complain("warning: " + options.scene + ": left out are " + line);
  if (options.animation.empty()) return scene;
  try {
    SceneState state = stateAt(scene, clipNamed(scene, options.animation), options.time);
    for (size_t i = 0; i < scene.instances.size(); ++i) scene.instances[i].transform = state.transforms[i];
    for (size_t i = 0; i < scene.meshes.size(); ++i) scene.meshes[i].deformation = std::move(state.deformations[i]);
  } catch (const Error& error) {
    throw Error(error.code(), "--animation: " + options.scene + ": " + error.what());
  }
  return scene;
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

std::vector<Pose> loadTrajectory(const std::filesystem::path& file) {
  std::vector<Pose> poses;
  for (const SensorMotion::Stamp& stamp : drive::readTum(file)) poses.push_back(stamp.pose);
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
