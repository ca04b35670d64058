// SPDX-License-Identifier: Apache-2.0
#include "scanning.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <random>
#include <set>
#include <system_error>

#include "base/file.hpp"
#include "base/path.hpp"
#include "base/quaternion.hpp"
#include "base/text.hpp"
#include "base/vector.hpp"
#include "console.hpp"
#include "drive/trajectory.hpp"
#include "effects/parameter_text.hpp"
#include "option_table.hpp"
#include "pose_text.hpp"
#include "scene/bounds.hpp"
#include "scene/coarse_positions.hpp"
#include "sensor/beams.hpp"

namespace gnosphere::cli {

namespace {

const std::map<std::string, UpAxis> kUpAxes = {{"", UpAxis::formatDefault}, {"y", UpAxis::y}, {"z", UpAxis::z}};

/// Whether the table of requests, and not that of simulators, has the option that this assignment names.
bool isOfRequest(const std::string& assignment) {
  const auto names = [&](const auto& option) {
    return assignment.starts_with(option.parameter.name + std::string("="));
  };
  return std::ranges::any_of(requestOptionTable(), names);
}

template <class Owner>
void set(Owner& owner, const std::string& assignment) {
  try {
    assign(owner, assignment);
  } catch (const Error& error) {
    throw Error(error.code(), std::string("--set: ") + error.what());
  }
}

/// Warns of options that the reference ignores: it is always exact, and has neither kernels nor lists.
void warnOfIgnored(const Settings& settings) {
  std::string names;
  for (const std::string& assignment : settings) {
    const std::string name = assignment.substr(0, assignment.find('='));
    const bool ignored =
        name == "accuracy" || name.starts_with("accuracy_parts") || name.starts_with("tuning.") || name == "validation";
    if (ignored) names += (names.empty() ? "" : ", ") + name;
  }
  if (!names.empty()) complain("warning: --device reference ignores " + names + "; another --device heeds them");
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
  app.add_option(
      "--pose", options.pose,
      "Position of the sensor in metres, X,Y,Z, and its orientation if wanted, as QX,QY,QZ,QW or in degrees, "
      "as 0,0,1.8,yaw=90: yaw turns to the left, then pitch down, then roll to the right (default: 1.8 m "
      "above the origin, or above the lowest surface in the middle of a scene that is elsewhere)");
  addSetting(app, "--faces", "faces", options.settings);
  CLI::Option* animation =
      app.add_option("--animation", options.animation, "Show the scene in this animation of its file (gnosphere info)");
  app.add_option(
         "--time", options.time,
         "Seconds after the start of the animation, which repeats; default 0. All scans of a trajectory show this time")
      ->needs(animation);
  app.add_option("--device", options.device, kDeviceHelp)->capture_default_str();
  app.add_flag_callback(
      "--validation", [&options] { options.settings.push_back("validation=true"); },
      "Enable the Vulkan validation layer; its messages are errors");
  addSetOption(app, options.settings);
}

CLI::Option* addSetting(CLI::App& app, const std::string& flag, const std::string& option, Settings& settings) {
  const Parameter<SimulatorOptions>& parameter = simulatorOption(option).parameter;
  std::vector<std::string> words;
  std::string about = parameter.doc;
  for (const ChoiceWord& word : wordsOf(option)) {
    words.push_back(word.name);
    if (*word.doc) about += " " + words.back() + ": " + word.doc;
  }
  // The setting goes before the settings of --set, so --set wins wherever it is on the command line.
  const auto set = [&settings, option](const std::string& word) {
    settings.insert(settings.begin(), option + "=" + word);
  };
  return app.add_option_function<std::string>(flag, set, about)
      ->check(CLI::IsMember(words))
      ->default_str(defaultText(parameter));
}

CLI::Option* addAccuracyOption(CLI::App& app, Settings& settings) {
  return addSetting(app, "--accuracy", "accuracy", settings);
}

void addSetOption(CLI::App& app, Settings& settings) {
  app.add_option_function<Settings>(
         "--set", [&settings](const Settings& more) { settings.insert(settings.end(), more.begin(), more.end()); },
         "Set an option by NAME=VALUE, as tuning.binning=lists; gnosphere options lists them; may be given more than "
         "once, and wins over other options that set the same")
      ->allow_extra_args(false);
}

void apply(const Settings& settings, SimulatorOptions& options) {
  for (const std::string& assignment : settings)
    if (!isOfRequest(assignment)) set(options, assignment);
  if (options.device.kind == DeviceChoice::Kind::reference) warnOfIgnored(settings);
}

std::string accuracyText(const SimulatorOptions& settings) {
  return settings.accuracyParts ? "parts" : nameOf(settings.accuracy);
}

void applyToRequest(const ScanningOptions& options, SensorRequest& request) {
  for (const std::string& assignment : options.settings)
    if (isOfRequest(assignment)) set(request, assignment);
}

void checkScanning(const ScanningOptions& options) {
  if (!std::isfinite(options.scale) || options.scale <= 0) {
    throw Error(ErrorCode::invalidArgument, "--scale must be finite and above 0");
  }
  if (!std::isfinite(options.time)) throw Error(ErrorCode::invalidArgument, "--time must be finite");
  if (!options.pose.empty()) parsePose(options.pose);
}

namespace {

/// Reads a sensor file, and warns of values that are assumed because it lacks them, and of values that are ignored.
Sensor loadTold(const std::filesystem::path& path) {
  SensorFile file = readSensorFile(path);
  for (const std::string& text : file.assumed) complain("warning: " + path.string() + ": assumed: " + text);
  for (const std::string& text : file.ignored) complain("warning: " + path.string() + ": ignored: " + text);
  return std::move(file.sensor);
}

}  // namespace

Sensor sensorOf(const std::string& nameOrFile) {
  return namedOrLoaded(nameOrFile, builtinSensor, loadTold);
}

uint64_t maskedBeams(const Sensor& sensor) {
  return static_cast<uint64_t>(std::ranges::count(silentBeams(sensor), true));
}

std::string maskedText(uint64_t masked) {
  return masked == 0 ? "" : ", " + grouped(masked) + " masked";
}

BuiltInHead builtInHead(const std::string& name) {
  BuiltInHead head;
  for (const Sensor& sensor : builtinSensors()) head.ideal = head.ideal || sameWord(sensor.name, name);
  for (const CatalogueHead& candidate : sensorCatalogue())
    if (sameWord(candidate.name, name.substr(0, name.find(':')))) head.real = &candidate;
  return head;
}

SimulatorOptions simulatorOptions(const ScanningOptions& options, SimulatorOptions settings) {
  settings.device = deviceByName(options.device);
  settings.warn = [](const std::string& message) { complain("warning: " + message); };
  apply(options.settings, settings);
  return settings;
}

Scene loadSceneAtRest(const ScanningOptions& options) {
  Scene scene = gnosphere::loadScene(pathOf(options.scene), {kUpAxes.at(options.up), options.scale});
  if (const std::string steps = coarsePositions(pathOf(options.scene), scene); !steps.empty())
    complain("warning: " + options.scene + ": " + steps);
  return scene;
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

namespace {

constexpr double kHeight = 1.8;  // metres, of a sensor on the roof of a car

/// Whether a scene is around the world's origin, or at most the height of a sensor above or below it.
bool isAtOrigin(const Bounds& bounds) {
  const Vec3 &low = bounds.min, &high = bounds.max;
  return low.x <= 0 && high.x >= 0 && low.y <= 0 && high.y >= 0 && low.z <= kHeight && high.z >= -kHeight;
}

/// The height at which a vertical line meets the plane of a triangle, if it does within the triangle.
std::optional<double> heightAt(const Vec3& a, const Vec3& b, const Vec3& c, double x, double y) {
  const double area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
  const double v = ((x - a.x) * (c.y - a.y) - (c.x - a.x) * (y - a.y)) / area;
  const double w = ((b.x - a.x) * (y - a.y) - (x - a.x) * (b.y - a.y)) / area;
  if (!(v >= 0 && w >= 0 && v + w <= 1)) return {};
  return a.z + v * (b.z - a.z) + w * (c.z - a.z);
}

/// Whether a vertical line meets a box.
bool isWithin(const Bounds& bounds, double x, double y) {
  return x >= bounds.min.x && x <= bounds.max.x && y >= bounds.min.y && y <= bounds.max.y;
}

/// The height of the lowest surface of a scene above a place; that of the scene's lowest point if there is none.
double groundAt(const Scene& scene, double x, double y, const Bounds& bounds) {
  double ground = std::numeric_limits<double>::infinity();
  std::vector<std::optional<Bounds>> boxes(scene.meshes.size());
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    std::optional<Bounds>& box = boxes[instance.mesh];
    if (!box) box = meshBounds(mesh);
    if (box->empty() || !isWithin(instance.transform * *box, x, y)) continue;
    const std::vector<float> deformed = deformedPositions(mesh, mesh.deformation);
    const auto corner = [&](size_t i) {
      const float* p = &deformed[3 * size_t{mesh.indices[i]}];
      return instance.transform * (mesh.origin + Vec3{p[0], p[1], p[2]});
    };
    for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3)
      if (const auto height = heightAt(corner(i), corner(i + 1), corner(i + 2), x, y))
        ground = std::min(ground, *height);
  }
  return std::isfinite(ground) ? ground : bounds.min.z;
}

}  // namespace

Pose poseOf(const ScanningOptions& options, const Scene& scene) {
  if (!options.pose.empty()) return parsePose(options.pose);
  Pose pose;
  pose.position = {0, 0, kHeight};
  const Bounds bounds = worldBounds(scene);
  if (bounds.empty() || isAtOrigin(bounds)) return pose;
  const double x = (bounds.min.x + bounds.max.x) / 2, y = (bounds.min.y + bounds.max.y) / 2;
  pose.position = {x, y, groundAt(scene, x, y, bounds) + kHeight};
  return pose;
}

void chooseFrames(const std::string& text, uint64_t& first, uint64_t& end) {
  if (!text.empty() && (!parsePair(text, ':', true, first, end) || first >= end))
    throw Error(ErrorCode::invalidArgument,
                "--frames: '" + text + "' is not A:B, the frames from A on and before B, as 0:100 or 100:");
}

std::string coordinateText(double metres) {
  if (std::abs(metres) < 1e-6) return "0";
  // Six digits have centimetres up to here.
  if (!(std::abs(metres) >= 1e4 && std::abs(metres) < 1e9)) return formatted("%g", metres);
  std::string text = formatted("%.2f", metres);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

std::string placeText(const Vec3& place) {
  return formatted("%.10g, %.10g, %.10g", place.x, place.y, place.z);
}

std::string extentText(const Bounds& bounds) {
  const auto from = [](const char* axis, double low, double high) {
    return axis + coordinateText(low) + ".." + coordinateText(high);
  };
  return from("x ", bounds.min.x, bounds.max.x) + from(", y ", bounds.min.y, bounds.max.y) +
         from(", z ", bounds.min.z, bounds.max.z) + " m";
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
    poses.back().orientation = Quaternion{0, 0, std::sin(half), std::cos(half)} * around.orientation;
  }
  return poses;
}

std::vector<Pose> loadTrajectory(const std::filesystem::path& file) {
  std::vector<Pose> poses;
  for (const SensorMotion::Stamp& stamp : drive::readTum(file)) poses.push_back(stamp.pose);
  return poses;
}

void checkOutputFiles(const std::vector<std::string>& files, const std::vector<std::string>& inputs) {
  std::set<std::filesystem::path> seen;
  for (const std::string& file : files) {
    if (file.empty()) continue;
    std::error_code absent;
    for (const std::string& input : inputs)
      if (std::filesystem::equivalent(pathOf(file), pathOf(input), absent))
        throw Error(ErrorCode::invalidArgument, file + " is read, too, as " + input + "; choose another output file");
    const std::filesystem::path own = std::filesystem::absolute(writePlaceOf(pathOf(file)).file, absent);
    if (absent) throw Error(ErrorCode::file, file + ": the working directory is gone: " + absent.message());
    const std::filesystem::path place = std::filesystem::weakly_canonical(own, absent);
    if (!seen.insert(absent ? own : place).second)
      throw Error(ErrorCode::invalidArgument, file + " would be written twice; use different names");
    checkWritable(pathOf(file));
  }
}

std::vector<std::string> inputsOf(const ScanningOptions& options, const EffectOptions& effects,
                                  const std::string& trajectory) {
  return {options.scene, options.sensor, effects.effects, effects.materials, trajectory};
}

}  // namespace gnosphere::cli
