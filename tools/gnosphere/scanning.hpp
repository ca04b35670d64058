// SPDX-License-Identifier: Apache-2.0
// Shared by all commands that scan: their options, the scene, the poses.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "base/path.hpp"
#include "effect_options.hpp"
#include "gnosphere/gnosphere.hpp"
#include "gnosphere/options.hpp"

namespace gnosphere::cli {

/// Options of a simulator as texts, NAME=VALUE, in the order in which they are set.
using Settings = std::vector<std::string>;

/// Every command describes its option --device by this text.
inline constexpr const char* kDeviceHelp =
    "auto, gpu for any that is no CPU, a number or part of a name of gnosphere devices, cuda:N, cuda-fast:N, or "
    "reference";

struct ScanningOptions {
  std::string scene, sensor = "HDL-64E", pose, up, device = "auto", animation;
  Settings settings;
  double scale = 1, time = 0;
};

/// Adds --set, which takes any option of the table.
void addSetOption(CLI::App& app, Settings& settings);
/// Adds a command-line option that sets one option of the table, with the words and the sentence of its row.
CLI::Option* addSetting(CLI::App& app, const std::string& flag, const std::string& option, Settings& settings);
/// Sets options in the order of the settings. Throws Error that names --set. Warns of those that the chosen device
/// ignores.
void apply(const Settings& settings, SimulatorOptions& options);

/// Adds SCENE and --sensor, --pose, --faces, --up, --scale, --animation, --time, --device, --validation,
/// --set.
void addScanningOptions(CLI::App& app, ScanningOptions& options);
/// Adds SCENE, --up and --scale.
void addSceneOptions(CLI::App& app, ScanningOptions& options);

/// Adds the option --accuracy to `app`.
CLI::Option* addAccuracyOption(CLI::App& app, Settings& settings);

/// Finds what a built-in name stands for, or else loads the file of that path. Throws Error with the nearest names.
template <typename T>
T namedOrLoaded(const std::string& nameOrFile, T (*named)(const std::string&),
                T (*load)(const std::filesystem::path&)) {
  try {
    return named(nameOrFile);
  } catch (const Error& unknown) {
    std::error_code ignored;
    const std::filesystem::path path = pathOf(nameOrFile);
    if (path.empty() || !std::filesystem::exists(path, ignored)) {
      if (path.has_extension() || path.has_parent_path())
        throw Error(unknown.code(), "there is no file '" + nameOrFile + "'");
      throw Error(unknown.code(), std::string(unknown.what()) + "; or give a file");
    }
  }
  return load(pathOf(nameOrFile));
}
/// Returns the sensor that --sensor names. Warns of values that are assumed because a file lacks them, and of values
/// that are ignored because a Sensor has no place for them.
Sensor sensorOf(const std::string& nameOrFile);

/// Returns how many beams of a sensor never fire.
uint64_t maskedBeams(const Sensor& sensor);
/// Returns text such as ", 500 masked"; empty if no beam is.
std::string maskedText(uint64_t masked);

/// A head that is built in: an ideal one of the paper, or a real one of the catalogue; or neither of them.
struct BuiltInHead {
  bool ideal = false;
  const CatalogueHead* real = nullptr;
};
/// Returns the head that --sensor names. A file of the same name does not count, because sensorOf() does not read it.
BuiltInHead builtInHead(const std::string& name);

/// Throws Error(invalidArgument) for mistakes that can be found before the scene is loaded.
void checkScanning(const ScanningOptions& options);
/// The options of the simulator; the settings change those that `settings` starts from.
SimulatorOptions simulatorOptions(const ScanningOptions& options, SimulatorOptions settings = {});
/// The name of the accuracy, or "parts" if --set has changed one of its parts.
std::string accuracyText(const SimulatorOptions& settings);
/// Sets the options of a sensor's request that --set names.
void applyToRequest(const ScanningOptions& options, SensorRequest& request);
/// Reads the scene, puts it into the state that --animation has at --time if an animation is given, and prints a
/// warning for everything that the scene leaves out of its file.
Scene loadScene(const ScanningOptions& options);
/// The scene as its file has it. Prints a warning if the file's positions have steps, see coarsePositions().
Scene loadSceneAtRest(const ScanningOptions& options);

/// Returns the pose that --pose states. The default is 1.8 m (as on a car's roof) above the ground at the world's
/// origin if the scene is there, else in the middle of the scene.
Pose poseOf(const ScanningOptions& options, const Scene& scene);

/// Takes the frames from `first` on and before `end` from the A:B of --frames, which may be empty.
void chooseFrames(const std::string& text, uint64_t& first, uint64_t& end);

/// Returns metres for people: centimetres or six digits, whichever says more, without an exponent up to 1e9 m.
std::string coordinateText(double metres);
/// Returns text such as "0, 0, 1.8", with ten digits of each coordinate.
std::string placeText(const Vec3& place);
/// Returns text such as "x -1..1, y 0..2, z 0..5 m".
std::string extentText(const Bounds& bounds);

/// Returns `count` poses: `around` itself, then random ones up to 10 m beside it, rotated about the vertical axis.
std::vector<Pose> posesAround(const Pose& around, size_t count);

/// The poses of a TUM file, see drive::readTum().
std::vector<Pose> loadTrajectory(const std::filesystem::path& file);

/// Checks output files before the work: throws if one cannot be written, is one of the inputs or occurs twice, under
/// whatever names. An empty name is an option that is not given.
void checkOutputFiles(const std::vector<std::string>& files, const std::vector<std::string>& inputs);

/// Returns the files that these options may name; a built-in name is none that exists.
std::vector<std::string> inputsOf(const ScanningOptions& options, const EffectOptions& effects,
                                  const std::string& trajectory);

}  // namespace gnosphere::cli
