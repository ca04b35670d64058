// SPDX-License-Identifier: Apache-2.0
#include "session.hpp"

#include <algorithm>

#include "rivals/rivals.hpp"
#include "scanning.hpp"
#include "seen.hpp"
#include "sensor/beams.hpp"
#include "town/town.hpp"

namespace gnosphere::bench {

void addOptions(CLI::App& app, Options& options) {
  const auto count = CLI::Range(uint32_t{1}, uint32_t{1'000'000});
  app.add_option("--device", options.device, "A device, as in gnosphere scan --device")->capture_default_str();
  cli::addAccuracyOption(app, options.settings);
  cli::addSetOption(app, options.settings);
  app.add_option("--sensor", options.sensor, "A built-in sensor or a JSON file (default: those of the case)");
  app.add_option("--scene", options.scenes, "A scene file instead of the built-in town; several for figure6-towns");
  app.add_option("--triangles", options.triangles,
                 "Triangles of the built-in town; of the largest one in scaling-triangles")
      ->check(CLI::Range(uint64_t{1}, uint64_t{1'000'000'000}));
  app.add_option("--trajectory", options.trajectory,
                 "Poses from a TUM file: lines of t x y z qx qy qz qw (default: along the town's street)");
  app.add_option("--frames", options.frames, "Number of poses")->check(count);
  app.add_option("--runs", options.runs, "Number of timed runs over all poses")->check(count);
  app.add_option(
         "--rivals", options.rivals,
         "Rivals to compare with: all, none, or some of embree, rayquery, raytracing and cuda, separated by commas")
      ->capture_default_str();
  app.add_option("--json", options.json, "Write the results to a JSON file, or - for stdout");
  app.add_option("--plot", options.plot, "Write a plot of the times to an .svg file");
}

void adaptToReal(CLI::App& app, Options& options) {
  for (const char* other : {"--triangles", "--trajectory"}) app.remove_option(app.get_option(other));
  app.get_option("--scene")->required()->description("Scene files, or folders that are searched for scene files");
  app.add_option("--least-triangles", options.leastTriangles, "Scenes with fewer placed triangles are left out")
      ->check(CLI::Range(uint64_t{1}, uint64_t{1'000'000'000}))
      ->capture_default_str();
  app.add_option("--seed", options.seed, "Seed of the poses")->capture_default_str();
}

void adaptToHeads(CLI::App& app, Options& options) {
  for (const char* other : {"--sensor", "--trajectory"}) app.remove_option(app.get_option(other));
  app.get_option("--scene")->description("Scene files instead of the built-in town");
  app.get_option("--rivals")->description("all, or none to leave Embree out");
  app.add_option("--heads", options.heads,
                 "Heads separated by commas, with :MODE if wanted (default: all of the catalogue)");
}

void adaptToGolden(CLI::App& app, Options& options) {
  for (const char* other :
       {"--accuracy", "--sensor", "--scene", "--triangles", "--trajectory", "--frames", "--runs", "--rivals", "--plot"})
    app.remove_option(app.get_option(other));
  app.add_option("--renew", options.renew, "Write the table of hashes to this file instead of comparing with it");
}

Session::Session(const Options& options, const Defaults& defaults)
    : options_(options), rivals_(parseRivals(options.rivals)) {
  if (options_.triangles == 0) options_.triangles = defaults.triangles;
  if (options_.runs == 0) options_.runs = defaults.runs;
  if (options_.frames == 0) options_.frames = defaults.frames;
  if (!options_.trajectory.empty()) trajectory_ = cli::loadTrajectory(options_.trajectory);
}

Scene Session::scene(uint64_t triangles) const {
  return options_.scenes.empty() ? makeTown({triangles, 1}) : loadScene(options_.scenes[0]);
}

std::vector<Sensor> Session::sensors(const std::vector<std::string>& names) const {
  if (!options_.sensor.empty()) return {cli::sensorOf(options_.sensor)};
  std::vector<Sensor> sensors;
  for (const std::string& name : names) sensors.push_back(builtinSensor(name));
  return sensors;
}

std::vector<Pose> Session::poses(const Scene& scene) const {
  const size_t count = options_.frames;
  std::vector<Pose> poses;
  if (!trajectory_.empty()) {
    const size_t all = trajectory_.size();
    for (size_t i = 0; i < std::min(count, all); ++i) poses.push_back(trajectory_[i * all / std::min(count, all)]);
    return poses;
  }
  if (!options_.scenes.empty()) return cli::posesAround(cli::poseOf({}, scene), count);
  for (size_t i = 0; i < count; ++i) {
    const double along = count > 1 ? static_cast<double>(i) / static_cast<double>(count - 1) : 0.5;
    poses.push_back({{-60 + 120 * along, 0, 1.8}, {}});
  }
  return poses;
}

std::vector<Pose> Session::poses(const Round& round) const {
  return round.poses.empty() ? poses(round.scene) : round.poses;
}

SimulatorOptions Session::simulatorOptions() const {
  SimulatorOptions settings;
  settings.device = deviceByName(options_.device);
  settings.faces = ReflectingFaces::material;  // rivals see both faces; the check of their results proves it
  settings.tuning.keepStill = false;           // whole scans are timed, even if a run has only one pose
  settings.tuning.stageTimes = timesStages_;
  cli::apply(options_.settings, settings);
  return settings;
}

std::vector<std::unique_ptr<Contender>> Session::contenders(const Round& round) {
  std::vector<std::unique_ptr<Contender>> contenders;
  const SensorRequest request = {round.sensor, Effects::none()};
  SimulatorOptions settings = simulatorOptions();
  contenders.push_back(makeOurs(round.scene, request, settings));
  setDevice(simulatorOf(*contenders[0]).device());
  if (round.motion == Motion::none && round.beside == Beside::seen) {
    contenders.push_back(makeSeen(round.scene, request, settings, poses(round)));
  } else if (round.motion == Motion::none && settings.accuracy != Accuracy::paper &&
             settings.device.kind != DeviceChoice::Kind::reference && causeAgainstPaper(round.sensor).empty()) {
    settings.accuracy = Accuracy::paper;
    contenders.push_back(makeOurs(round.scene, request, settings));
  }
  for (auto& rival : rivals(rivals_, round, request)) contenders.push_back(std::move(rival));
  return contenders;
}

std::vector<std::unique_ptr<Contender>> Session::rivals(const std::vector<std::string>& names, const Round& round,
                                                        const SensorRequest& request) {
  const std::vector<Pose> drive = poses(round);
  const Vec3 middle = drive[drive.size() / 2].position;
  if (hasOrigins(round.sensor)) {
    addNote(round.label + ": the rivals trace from one origin only and are left out");
    return {};
  }
  std::vector<std::string> notes;
  auto rivals = makeRivals(names, {round.scene, request, middle, round.motion, simulatorOptions(), device_}, notes);
  for (const std::string& note : notes) addNote(note);
  return rivals;
}

void Session::setDevice(const DeviceInfo& device) {
  if (device_.name != device.name) rates_ = ratesOf(device, options_.device);
  device_ = device;
}

void Session::addNote(const std::string& note) {
  if (std::find(notes_.begin(), notes_.end(), note) == notes_.end()) notes_.push_back(note);
}

void Session::hold(const Round& round, std::vector<Outcome>& outcomes) {
  Setting setting = {round.label, round.x, round.scene, round.sensor, shotsFrom(poses(round)), {}, options_.runs};
  setting.step = round.step;
  const size_t all = round.scene.instances.size(), moving = std::min(round.moving, all);
  for (size_t i = 0; i < moving; ++i) setting.moving.push_back(i * all / moving);
  try {
    std::vector<std::unique_ptr<Contender>> everyone = contenders(round);
    outcomes.push_back(bench::hold(setting, everyone, rates_));
    for (const std::string& note : outcomes.back().notes) addNote(note);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::outOfMemory) throw;
    addNote(round.label + ": " + error.what());
  }
}

void Session::hold(const Round& round, const Request& asked, std::vector<Outcome>& outcomes) {
  if (std::find(rivals_.begin(), rivals_.end(), "cuda") == rivals_.end()) return;
  const SensorRequest request = {round.sensor, asked.effects, asked.fields};
  std::vector<std::unique_ptr<Contender>> everyone = rivals({"cuda"}, round, request);
  if (everyone.empty()) return;
  everyone.insert(everyone.begin(), makeOurs(round.scene, request, simulatorOptions()));
  Setting setting = {round.label, round.x, round.scene, round.sensor, asked.shots, {}, options_.runs};
  setting.refereed = false;
  outcomes.push_back(bench::hold(setting, everyone, rates_));
}

}  // namespace gnosphere::bench
