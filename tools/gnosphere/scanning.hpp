// SPDX-License-Identifier: Apache-2.0
// What every command that scans a scene has in common: its options, the scene, the poses.
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
  std::string scene, sensor = "HDL-64E", pose, up, device = "auto", faces = "material", binning = "auto";
  double scale = 1;
  bool validation = false;
};

/// SCENE and --sensor, --pose, --faces, --binning, --up, --scale, --device, --validation.
void addScanningOptions(CLI::App& app, ScanningOptions& options);

/// --accuracy, one of kAccuracies.
CLI::Option* addAccuracyOption(CLI::App& app, std::string& accuracy);

/// Throws Error(invalidArgument) for what can be told before the scene is loaded.
void checkScanning(const ScanningOptions& options);
SimulatorOptions simulatorOptions(const ScanningOptions& options);
Scene loadScene(const ScanningOptions& options);

/// --pose, or the default: standing at the world's origin if the scene is there, else in the middle of the scene;
/// 1.8 m up, as on a car's roof.
Pose poseOf(const ScanningOptions& options, const Scene& scene);

/// `count` poses: `around` itself, then others up to 10 m to its sides, turned about the upward axis, from a seed.
std::vector<Pose> posesAround(const Pose& around, size_t count);

/// Lines `t x y z qx qy qz qw` (TUM); # begins a comment, more numbers on a line are not looked at. Throws
/// Error(format) that names the first line that is not sound, Error(file) if the file cannot be read.
std::vector<SensorMotion::Stamp> loadStampedTrajectory(const std::filesystem::path& file);
std::vector<Pose> loadTrajectory(const std::filesystem::path& file);

/// Told before the work that writes them: throws if one cannot be written, is the scene itself or is there twice.
void checkOutputFiles(const std::vector<std::string>& files, const std::string& scene);

}  // namespace gnosphere::cli
