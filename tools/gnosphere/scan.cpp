// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <optional>

#include "commands.hpp"
#include "console.hpp"
#include "file.hpp"
#include "max_error.hpp"
#include "output/fields.hpp"
#include "scan_report.hpp"
#include "scanning.hpp"

namespace gnosphere::cli {
namespace {

struct ScanOptions : ScanningOptions {
  std::string fields, image, stats, accuracy = "standard";
  std::vector<std::string> outputs;
  std::optional<double> maxError;
  uint64_t repeat = 0;  ///< 0: one scan, and no warm-up before it
  bool compact = false, ascii = false;
};

/// Whatever can be known to fail is told before the scene is loaded, not after the scan.
CloudOptions checkOutputs(const ScanOptions& options) {
  CloudOptions cloud;
  cloud.compact = options.compact;
  cloud.ascii = options.ascii;
  if (!options.fields.empty()) cloud.fields = parseFields(options.fields);
  for (Field field : cloud.fields) {
    const bool fromReference = field == Field::tie || field == Field::tolerance;
    if (fromReference && options.device != "reference") {
      throw Error(ErrorCode::invalidArgument,
                  "--fields: only --device reference gives '" + std::string(fieldInfo(field).name) + "'");
    }
  }
  if (!options.image.empty() && std::filesystem::path(options.image).extension() != ".png") {
    throw Error(ErrorCode::invalidArgument, "--image: " + options.image + " must end in .png");
  }
  for (const std::string& output : options.outputs) cloudFormat(output);
  std::vector<std::string> files = options.outputs;
  if (!options.image.empty()) files.push_back(options.image);
  if (!options.stats.empty() && options.stats != "-") files.push_back(options.stats);
  checkOutputFiles(files, options.scene);
  return cloud;
}

void warnAbout(const ScanOptions& options, const Scene& scene, const Counters& counters) {
  if (scene.placedTriangleCount() == 0) complain("warning: " + options.scene + " has no triangle, every beam misses");
  if (counters.nonFinite > 0) {
    complain("warning: " + grouped(counters.nonFinite) + " triangles of " + options.scene +
             " dropped, a corner is NaN, infinite or beyond 1e9 m");
  }
}

/// With --repeat, one scan to warm up and then the timed ones; the last is the result.
Scan runScans(Simulator& simulator, const Pose& pose, uint64_t repeat, std::vector<Timings>& runs) {
  Progress progress("scan", repeat);
  Scan scan = simulator.scan(pose);
  if (repeat == 0) {
    runs.push_back(scan.timings);
    return scan;
  }
  for (uint64_t run = 0; run < repeat; ++run) {
    progress.step(run + 1);
    scan = simulator.scan(pose);
    runs.push_back(scan.timings);
  }
  return scan;
}

void writeOutputs(const ScanOptions& options, const CloudOptions& cloud, const ScanReport& report) {
  std::vector<std::string> written;
  for (const std::string& output : options.outputs) {
    writeCloud(report.scan, output, cloud);
    written.push_back(output);
  }
  if (!options.image.empty()) {
    writePicture(report.scan, options.image);
    written.push_back(options.image);
  }
  if (options.stats == "-") {
    std::printf("%s", statsJson(report).c_str());
    return;
  }
  if (!options.stats.empty()) {
    AtomicFile stats(options.stats);
    stats.write(statsJson(report));
    stats.commit();
    written.push_back(options.stats);
  }
  printSummary(report);
  for (const std::string& file : written) say("wrote", file + ", " + fileSize(file));
}

/// With --max-error, the setting that it takes; none if no setting does.
std::optional<AccuracyChoice> choose(const ScanOptions& options, const Scene& scene, const Sensor& sensor,
                                     const Pose& pose) {
  if (!options.maxError) return {};
  AccuracyChoice choice = chooseAccuracy(scene, sensor, pose, simulatorOptions(options), *options.maxError);
  if (choice.chosen && options.stats != "-") say("accuracy", choice.why);
  return choice;
}

void check(const ScanOptions& options) {
  checkScanning(options);
  if (!options.maxError) return;
  checkMaxError(*options.maxError);
  if (options.device == "reference") {
    throw Error(ErrorCode::invalidArgument,
                "--max-error is measured against the reference; choose another --device than that");
  }
}

int runScan(const ScanOptions& options) {
  check(options);
  const CloudOptions cloud = checkOutputs(options);
  const Sensor sensor = findSensor(options.sensor);
  double start = nowMs();
  const Scene scene = loadScene(options);
  const double loadMs = nowMs() - start;
  const Pose pose = poseOf(options, scene);

  const std::optional<AccuracyChoice> choice = choose(options, scene, sensor, pose);
  if (choice && !choice->chosen) {
    complain(choice->why);
    return 1;
  }
  const std::string accuracy = choice ? choice->chosen->name : options.accuracy;

  start = nowMs();
  SimulatorOptions settings = simulatorOptions(options);
  settings.accuracy = kAccuracies.at(accuracy);
  Simulator simulator(scene, sensor, settings);
  const double setUpMs = nowMs() - start;

  std::vector<Timings> runs;
  const Scan scan = runScans(simulator, pose, options.repeat, runs);
  warnAbout(options, scene, scan.counters);
  writeOutputs(options, cloud,
               {options.scene, scene, sensor, simulator, scan, accuracy, options.binning, runs, loadMs, setUpMs,
                choice ? &*choice : nullptr});
  return 0;
}

void addAccuracyOptions(CLI::App& app, ScanOptions& options) {
  CLI::Option* accuracy =
      app.add_option("--accuracy", options.accuracy,
                     "paper: the published method to the letter; draft: without its gaps between boxes; standard: "
                     "watertight; exact: the same bytes everywhere")
          ->check(CLI::IsMember(kAccuracies))
          ->capture_default_str();
  app.add_option("--max-error", options.maxError,
                 "Metres: the cheapest accuracy on this device that loses no beam and is nowhere further off, measured "
                 "from this pose on a sample of the beams")
      ->excludes(accuracy);
}

}  // namespace

Action addScan(CLI::App& app) {
  const auto options = std::make_shared<ScanOptions>();
  addScanningOptions(app, *options);
  addAccuracyOptions(app, *options);
  app.add_option("-o,--output", options->outputs,
                 "A cloud to write: .pcd, .ply, .bin (KITTI), .npy or .csv; may be given more than once")
      ->allow_extra_args(false);
  app.add_option("--fields", options->fields,
                 "What to write, in this order: x,y,z,range,ring,beam,triangle,instance (default), tie,tolerance");
  app.add_flag("--compact", options->compact, "Write the hits only, not every beam");
  app.add_flag("--ascii", options->ascii, "Write PCD and PLY as text");
  app.add_option("--image", options->image, "A .png of the scan: as the sensor sees it, and from above");
  app.add_option("--stats", options->stats, "A JSON file of times and counters, or - for stdout");
  app.add_option("--repeat", options->repeat, "Scan this often after a warm-up, and report the median time")
      ->check(CLI::Range(uint64_t{1}, uint64_t{1'000'000}));
  return [options] { return runScan(*options); };
}

}  // namespace gnosphere::cli
