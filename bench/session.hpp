// SPDX-License-Identifier: Apache-2.0
// What every case has in common: its options, its scenes and poses, and a contest among all that were asked for.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "contest.hpp"
#include "rivals/rival.hpp"

namespace gnosphere::bench {

struct Options {
  std::string device = "auto", accuracy = "standard", sensor, trajectory, rivals = "all", json, plot;
  std::vector<std::string> scenes;
  uint64_t triangles = 0;  ///< 0: the case's own default, as below
  uint32_t runs = 0, frames = 0;
};

/// Of a case, where the options say nothing.
struct Defaults {
  uint64_t triangles = 1'000'000;
  uint32_t runs = 10, frames = 1;
};

void addOptions(CLI::App& app, Options& options);

/// What a case asks to be measured.
struct Round {
  std::string label;
  double x = 0;
  const Scene& scene;
  Sensor sensor;
  Motion motion = Motion::none;
  size_t moving = 0;  ///< so many instances, spread evenly over the scene
};

/// What only ours can do: scans with effects.
struct Request {
  Effects effects;
  std::vector<Field> fields;
  std::vector<Shot> shots;
};

class Session {
 public:
  /// Throws Error(invalidArgument) for options that make no sense.
  Session(const Options& options, const Defaults& defaults);

  const Options& options() const { return options_; }
  /// --scene, or a town of `triangles`.
  Scene scene(uint64_t triangles) const;
  Scene scene() const { return scene(options_.triangles); }
  /// --sensor alone, or these built-in ones.
  std::vector<Sensor> sensors(const std::vector<std::string>& names) const;
  /// --trajectory, or a drive along the town's street (x from -60 to 60 m, heading along x), or round the place where
  /// one would stand in a scene of one's own; --frames of them, spread evenly.
  std::vector<Pose> poses(const Scene& scene) const;

  SimulatorOptions simulatorOptions() const;
  std::vector<std::unique_ptr<Contender>> contenders(const Round& round);
  /// Adds what a contest comes to; a round that our own device cannot hold is left out, with a note.
  void hold(const Round& round, std::vector<Outcome>& outcomes);
  /// The same of a request, among ours by Vulkan and by CUDA. Nothing where CUDA takes no part.
  void hold(const Round& round, const Request& request, std::vector<Outcome>& outcomes);

  const DeviceInfo& device() const { return device_; }  ///< known after the first contest
  void setDevice(const DeviceInfo& device);             ///< where there is no contest
  const Rates& rates() const { return rates_; }
  const std::vector<std::string>& notes() const { return notes_; }  ///< what was left out, and why
  void addNote(const std::string& note);

 private:
  std::vector<std::unique_ptr<Contender>> rivals(const std::vector<std::string>& names, const Round& round,
                                                 const SensorRequest& request);

  Options options_;
  std::vector<std::string> rivals_;
  std::vector<Pose> trajectory_;
  DeviceInfo device_;
  Rates rates_;
  std::vector<std::string> notes_;
};

}  // namespace gnosphere::bench
