// SPDX-License-Identifier: Apache-2.0
#include "gnosphere/eval/accuracy.hpp"

#include <algorithm>
#include <memory>
#include <optional>

#include "accuracy_report.hpp"
#include "base/file.hpp"
#include "base/path.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "effect_options.hpp"
#include "gnosphere/eval/sub_rays.hpp"
#include "no_hits.hpp"
#include "scanning.hpp"
#include "sub_rays_report.hpp"

namespace gnosphere::cli {
namespace {

struct Options : ScanningOptions, EffectOptions {
  std::optional<uint64_t> poses, sample;
  std::optional<uint32_t> runs;
  std::string trajectory, json, plot;
  bool footprints = false;  ///< whether --effects is given, which measures footprints instead of accuracies
  std::vector<uint32_t> subRays = SubRayOptions().counts;
};

constexpr uint64_t kPoses = 4;
constexpr const char* kNobody = "no beam that is compared";  ///< if none hits

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
  if (!options.plot.empty() && pathOf(options.plot).extension() != ".svg") {
    throw Error(ErrorCode::invalidArgument, "--plot: " + options.plot + " must end in .svg");
  }
  checkOutputFiles({options.json == "-" ? "" : options.json, options.plot},
                   inputsOf(options, options, options.trajectory));
}

void write(const std::string& file, const std::string& bytes) {
  AtomicFile output(pathOf(file));
  output.write(bytes);
  output.commit();
}

/// Prints or writes the report. `Story` has a table, JSON and a plot.
template <typename Story>
int tell(const Options& options, const Story& story) {
  if (options.json == "-")
    std::printf("%s", jsonOf(story).c_str());
  else
    printTables(story);
  if (!options.json.empty() && options.json != "-") write(options.json, jsonOf(story));
  if (!options.plot.empty()) write(options.plot, svgOf(story));
  if (options.json == "-") return 0;
  for (const std::string& file : {options.json, options.plot})
    if (!file.empty()) say("wrote", file + ", " + fileSize(file));
  return 0;
}

int runAccuracy(const Options& options) {
  check(options);
  SensorRequest request = {sensorOf(options.sensor)};
  MaterialTable materials;
  if (options.footprints) {
    request.effects = effectsOf(options);
    materials = materialsOf(options);
  }
  std::vector<Pose> poses;
  if (!options.trajectory.empty()) poses = loadTrajectory(pathOf(options.trajectory));
  if (options.poses) poses = thinned(poses, *options.poses);
  const Scene scene = loadScene(options);
  if (poses.empty()) poses = posesAround(poseOf(options, scene), options.poses.value_or(kPoses));
  const Sensor& sensor = request.sensor;

  if (options.footprints) {
    SubRayOptions measure;
    measure.simulator = simulatorOptions(options);
    measure.simulator.materials = materials;
    measure.counts = options.subRays;
    measure.runs = options.runs.value_or(measure.runs);
    measure.sample = options.sample.value_or(measure.sample);
    measure.progress = stepProgress();
    const SubRayReport report = measureSubRays(scene, request, poses, measure);
    measure.progress = nullptr;  // erases the progress line
    if (std::ranges::all_of(report.rows, [](const SubRayRow& row) { return row.beams == 0; }))
      warnOfNoHits(kNobody, options, options.trajectory, scene, request, measure.simulator, poses[0],
                   Simulator(scene, request, measure.simulator).scan(poses[0]).counters);
    return tell(options, SubRaysStory{options.scene, scene, sensor, poses, report});
  }
  AccuracyOptions measure;
  measure.simulator = simulatorOptions(options);
  const bool chosen = measure.simulator.accuracy != Accuracy::standard || measure.simulator.accuracyParts;
  if (chosen) throw Error(ErrorCode::invalidArgument, "--set: gnosphere accuracy measures every accuracy; choose none");
  measure.runs = options.runs.value_or(measure.runs);
  measure.sample = options.sample.value_or(measure.sample);
  measure.progress = stepProgress();
  const AccuracyReport report = measureAccuracy(scene, sensor, poses, measure);
  measure.progress = nullptr;  // erases the progress line
  if (report.settings[0].error.hits == 0) {
    Counters counters;
    counters.beams = counters.misses = sensor.beamCount();
    warnOfNoHits(kNobody, options, options.trajectory, scene, {sensor, Effects::none()}, measure.simulator, poses[0],
                 counters);
  }
  return tell(options, AccuracyStory{options.scene, scene, sensor, poses, report});
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
  app.add_option("--runs", options->runs,
                 "Timed scans of every setting (default: 20) or number of sub-rays (default: 10)")
      ->check(CLI::Range(uint32_t{1}, uint32_t{1'000'000}));
  app.add_option("--sample", options->sample,
                 "Compare only about this many beams of each pose with the reference (default: all; with --effects "
                 "5,000)")
      ->check(CLI::Range(uint64_t{1}, uint64_t{0xffffffff}));
  addEffectOptions(app, *options);
  CLI::Option* effects = app.get_option("--effects");
  effects->description(
      "Measure what footprints of fewer sub-rays cost, instead of the accuracies, with these effects: auto if none is "
      "named, " +
      effects->get_description().substr(effects->get_description().find(": ") + 2));
  effects->expected(0, 1);
  app.add_option("--sub-rays", options->subRays, "Numbers of sub-rays that --effects measures, separated by commas")
      ->delimiter(',')
      ->check(CLI::Range(1, 61))
      ->capture_default_str();
  for (const char* other : {"--effect", "--seed", "--materials", "--sub-rays"}) app.get_option(other)->needs(effects);
  app.add_option("--json", options->json, "Write all measurements to a JSON file, or - for stdout");
  app.add_option("--plot", options->plot, "Write a plot of error over time to an .svg file");
  app.footer("Example: gnosphere accuracy town.glb --sensor HDL-64E --plot accuracy.svg");
  return [options, effects] {
    options->footprints = effects->count() > 0;
    return runAccuracy(*options);
  };
}

}  // namespace gnosphere::cli
