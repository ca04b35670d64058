// SPDX-License-Identifier: Apache-2.0
#include "gnosphere/eval/accuracy.hpp"

#include <memory>
#include <optional>

#include "accuracy_report.hpp"
#include "base/file.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "scanning.hpp"

namespace gnosphere::cli {
namespace {

struct Options : ScanningOptions {
  std::optional<uint64_t> poses;
  std::string trajectory, json, plot;
  uint32_t runs = 20;
  uint64_t sample = 0;
};

constexpr uint64_t kPoses = 4;

/// Takes `count` poses evenly along a trajectory, including its first.
std::vector<Pose> thinned(const std::vector<Pose>& all, uint64_t count) {
  if (count >= all.size()) return all;
  std::vector<Pose> some;
  for (uint64_t i = 0; i < count; ++i) some.push_back(all[i * all.size() / count]);
  return some;
}

void check(const Options& options) {
  checkScanning(options);
  if (options.device == "reference") {
    throw Error(ErrorCode::invalidArgument,
                "--device: the reference cannot be measured against itself; choose another device");
  }
  std::vector<std::string> files;
  for (const std::string& file : {options.json, options.plot})
    if (!file.empty() && file != "-") files.push_back(file);
  if (!options.plot.empty() && std::filesystem::path(options.plot).extension() != ".svg") {
    throw Error(ErrorCode::invalidArgument, "--plot: " + options.plot + " must end in .svg");
  }
  checkOutputFiles(files, options.scene);
}

void write(const std::string& file, const std::string& bytes) {
  AtomicFile output(file);
  output.write(bytes);
  output.commit();
}

int runAccuracy(const Options& options) {
  check(options);
  const Sensor sensor = sensorOf(options.sensor);
  std::vector<Pose> poses;
  if (!options.trajectory.empty()) poses = loadTrajectory(options.trajectory);
  if (options.poses) poses = thinned(poses, *options.poses);
  const Scene scene = loadScene(options);
  if (poses.empty()) poses = posesAround(poseOf(options, scene), options.poses.value_or(kPoses));

  AccuracyOptions measure;
  measure.simulator = simulatorOptions(options);
  measure.runs = options.runs;
  measure.sample = options.sample;
  measure.progress = stepProgress();
  const AccuracyReport report = measureAccuracy(scene, sensor, poses, measure);
  measure.progress = nullptr;  // erases the progress line

  const AccuracyStory story = {options.scene, scene, sensor, poses, report};
  if (options.json == "-")
    std::printf("%s", accuracyJson(story).c_str());
  else
    printTables(story);
  if (!options.json.empty() && options.json != "-") write(options.json, accuracyJson(story));
  if (!options.plot.empty()) write(options.plot, accuracySvg(story));
  if (options.json == "-") return 0;
  for (const std::string& file : {options.json, options.plot})
    if (!file.empty()) say("wrote", file + ", " + fileSize(file));
  return 0;
}

}  // namespace

Action addAccuracy(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  addScanningOptions(app, *options);
  app.add_option("--poses", options->poses,
                 "Number of poses: random around the default pose or --pose (default: 4), or evenly along the "
                 "trajectory (default: all of it)")
      ->check(CLI::Range(uint64_t{1}, uint64_t{1'000'000}));
  CLI::Option* trajectory =
      app.add_option("--trajectory", options->trajectory, "Poses from a TUM file: lines of t x y z qx qy qz qw");
  trajectory->excludes(app.get_option("--pose"));
  app.add_option("--runs", options->runs, "Timed scans of every setting")
      ->check(CLI::Range(uint32_t{1}, uint32_t{1'000'000}))
      ->capture_default_str();
  app.add_option("--sample", options->sample, "Compare only about this many beams of each pose with the reference")
      ->check(CLI::Range(uint64_t{1}, uint64_t{0xffffffff}));
  app.add_option("--json", options->json, "Write all measurements to a JSON file, or - for stdout");
  app.add_option("--plot", options->plot, "Write a plot of error over time to an .svg file");
  app.footer("Example: gnosphere accuracy town.glb --sensor HDL-64E --poses 8 --plot accuracy.svg");
  return [options] { return runAccuracy(*options); };
}

}  // namespace gnosphere::cli
