// SPDX-License-Identifier: Apache-2.0
// Shared by all commands that scan: their options, the scene, the poses.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "gnosphere/gnosphere.hpp"

namespace gnosphere::cli {

extern const std::map<std::string, Accuracy> kAccuracies;

struct ScanningOptions {
  std::string scene, sensor = "HDL-64E", pose, up, device = "auto", faces = "material", binning = "auto", animation;
  double scale = 1, time = 0;
  bool validation = false;
};

/// Adds SCENE and --sensor, --pose, --faces, --binning, --up, --scale, --animation, --time, --device, --validation.
void addScanningOptions(CLI::App& app, ScanningOptions& options);
/// Adds SCENE, --up and --scale.
void addSceneOptions(CLI::App& app, ScanningOptions& options);

/// Adds --accuracy, one of kAccuracies.
CLI::Option* addAccuracyOption(CLI::App& app, std::string& accuracy);

/// What a built-in name stands for, or else what a file of that path holds. Throws Error that lists the names.
template <typename T>
T namedOrLoaded(const std::string& nameOrFile, T (*named)(const std::string&),
                T (*load)(const std::filesystem::path&)) {
  try {
    return named(nameOrFile);
  } catch (const Error& unknown) {
    std::error_code ignored;
    const std::filesystem::path path = nameOrFile;
    if (path.empty() || !std::filesystem::exists(path, ignored)) {
      if (path.has_extension() || path.has_parent_path())
        throw Error(unknown.code(), "there is no file '" + nameOrFile + "'");
      throw Error(unknown.code(), std::string(unknown.what()) + "; or give a file");
    }
  }
  return load(nameOrFile);
}
/// The sensor that --sensor names.
Sensor sensorOf(const std::string& nameOrFile);

/// Throws Error(invalidArgument) for mistakes that can be found before the scene is loaded.
void checkScanning(const ScanningOptions& options);
SimulatorOptions simulatorOptions(const ScanningOptions& options);
/// Reads the scene, puts it into the state that --animation has at --time if an animation is given, and prints a
/// warning for everything that the scene leaves out of its file.
Scene loadScene(const ScanningOptions& options);
/// The scene as its file has it.
Scene loadSceneAtRest(const ScanningOptions& options);

/// Returns --pose. The default is 1.8 m (as on a car's roof) above the ground at the world's origin if the scene is
/// there, else in the middle of the scene.
Pose poseOf(const ScanningOptions& options, const Scene& scene);

/// Returns `count` poses: `around` itself, then random ones up to 10 m beside it, rotated about the vertical axis.
std::vector<Pose> posesAround(const Pose& around, size_t count);

/// The poses of a TUM file, see drive::readTum().
std::vector<Pose> loadTrajectory(const std::filesystem::path& file);

/// Checks output files before the work: throws if one cannot be written, is the scene itself or occurs twice.
void checkOutputFiles(const std::vector<std::string>& files, const std::string& scene);

}  // namespace gnosphere::cli
