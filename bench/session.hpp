// SPDX-License-Identifier: Apache-2.0
// Shared by all cases: options, scenes and poses, and a contest among the selected contenders.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "contest.hpp"
#include "rivals/rival.hpp"
#include "scanning.hpp"

namespace gnosphere::bench {

struct Options {
  std::string device = "auto", sensor, trajectory, rivals = "all", json, plot;
  std::vector<std::string> scenes;
  cli::Settings settings;  ///< of GnoSphere's simulators
  uint64_t triangles = 0;  ///< 0: the default of the case
  uint32_t runs = 0, frames = 0;
  uint64_t leastTriangles = 50'000, seed = 1;  ///< of the case `real` alone
  std::string heads;                           ///< of the case `heads` alone; empty: all of the catalogue
  std::string renew;                           ///< of the case `golden` alone: the file to write
};

/// Defaults of a case for options that are not given.
struct Defaults {
  uint64_t triangles = 1'000'000;
  uint32_t runs = 10, frames = 1;
};

void addOptions(CLI::App& app, Options& options);
/// Changes these options to those of the case `real`.
void adaptToReal(CLI::App& app, Options& options);

/// Changes these options to those of the case `heads`.
void adaptToHeads(CLI::App& app, Options& options);

/// Changes these options to those of the case `golden`.
void adaptToGolden(CLI::App& app, Options& options);

/// Contenders of our own that take part beside GnoSphere where nothing moves.
enum class Beside {
  paper,  ///< the paper's method
  seen,   ///< GnoSphere in scenes that hold only what it sees: its floor
};

/// One measurement of a case.
struct Round {
  std::string label;
  double x = 0;
  const Scene& scene;
  Sensor sensor;
  Motion motion = Motion::none;
  size_t moving = 0;             ///< number of moving instances, spread evenly over the scene
  double step = 0.02;            ///< metres between two places of a moving instance
  std::vector<Pose> poses = {};  ///< if empty, those of the session
  Beside beside = Beside::paper;
};

/// Scans with effects, which only GnoSphere supports.
struct Request {
  Effects effects;
  std::vector<Field> fields;
  std::vector<Shot> shots;
};

class Session {
 public:
  /// Throws Error(invalidArgument) for invalid options.
  Session(const Options& options, const Defaults& defaults);

  const Options& options() const { return options_; }
  /// Returns --scene, or a town of `triangles`.
  Scene scene(uint64_t triangles) const;
  Scene scene() const { return scene(options_.triangles); }
  /// Returns --sensor alone, or these built-in ones.
  std::vector<Sensor> sensors(const std::vector<std::string>& names) const;
  /// Returns --frames poses, spread evenly along --trajectory; by default along the town's street (x from -60 to 60 m,
  /// heading along x), or around the default pose of --scene.
  std::vector<Pose> poses(const Scene& scene) const;

  SimulatorOptions simulatorOptions() const;
  /// Measures stages on CPU devices, too, for cases that report nothing else: see Tuning::stageTimes.
  void timeStages() { timesStages_ = true; }
  std::vector<std::unique_ptr<Contender>> contenders(const Round& round);
  /// Runs a contest and adds its outcome; a round that does not fit GnoSphere's device is left out, with a note.
  void hold(const Round& round, std::vector<Outcome>& outcomes);
  /// Runs a request on GnoSphere by Vulkan and by CUDA; does nothing without CUDA.
  void hold(const Round& round, const Request& request, std::vector<Outcome>& outcomes);

  const DeviceInfo& device() const { return device_; }  ///< valid after the first contest
  void setDevice(const DeviceInfo& device);             ///< for cases without a contest
  const Rates& rates() const { return rates_; }
  const std::vector<std::string>& notes() const { return notes_; }  ///< reasons for what was left out
  void addNote(const std::string& note);

 private:
  std::vector<Pose> poses(const Round& round) const;
  std::vector<std::unique_ptr<Contender>> rivals(const std::vector<std::string>& names, const Round& round,
                                                 const SensorRequest& request);

  Options options_;
  std::vector<std::string> rivals_;
  std::vector<Pose> trajectory_;
  bool timesStages_ = false;
  DeviceInfo device_;
  Rates rates_;
  std::vector<std::string> notes_;
};

}  // namespace gnosphere::bench
