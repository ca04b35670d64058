// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include "base/file.hpp"
#include "base/input_file.hpp"
#include "base/json_text.hpp"
#include "base/path.hpp"
#include "base/text.hpp"
#include "commands.hpp"
#include "common/effects/bits.h"
#include "console.hpp"
#include "drive/trajectory.hpp"
#include "effect_options.hpp"
#include "effects/effect_table.hpp"
#include "geometry/dropped_triangles.hpp"
#include "max_error.hpp"
#include "no_hits.hpp"
#include "output/cloud_format.hpp"
#include "output/picture_file.hpp"
#include "scan/coarse_points.hpp"
#include "scan_report.hpp"
#include "scan_trajectory.hpp"
#include "scanning.hpp"

namespace gnosphere::cli {
namespace {

struct ScanOptions : ScanningOptions, EffectOptions {
  std::string trajectory, frame = "sensor", image, stats;
  std::optional<std::string> fields;
  std::vector<std::string> outputs;
  std::optional<double> maxError;
  bool trace = false;
  uint64_t repeat = 0;  ///< 0: one scan without a warm-up
  std::optional<bool> compact;
  bool ascii = false;
  Json arguments;  ///< the options that the command line states, by name
};

/// Returns the output file of the scan, or of scan `number` of a trajectory.
std::string fileOf(const ScanOptions& options, const std::string& file, size_t number) {
  return options.trajectory.empty() ? file : numbered(file, number);
}

/// Refuses options of cloud files where the call writes no file that they change.
void checkWithoutEffect(const ScanOptions& options) {
  const auto refuse = [](const std::string& text) { throw Error(ErrorCode::invalidArgument, text); };
  const auto hasColumns = [](const std::string& file) { return cloudFormat(pathOf(file)).layout == nullptr; };
  const std::pair<const char*, bool> given[] = {{"--frame world", options.frame == "world"},
                                                {"--compact", options.compact.value_or(false)},
                                                {"--no-compact", !options.compact.value_or(true)},
                                                {"--fields", options.fields.has_value()}};
  for (const auto& [name, isGiven] : given)
    if (isGiven && options.outputs.empty())
      refuse(std::string(name) + " changes cloud files, and there is no --output");
  if (options.fields && std::ranges::none_of(options.outputs, hasColumns))
    refuse("--fields: files of KITTI (.bin) always have x, y, z and the intensity, and no other --output is given");
}

/// Checks before the scene is loaded all that can be known to fail later.
CloudOptions checkOutputs(const ScanOptions& options, size_t scans) {
  CloudOptions cloud;
  cloud.compact = options.compact;
  cloud.ascii = options.ascii;
  if (options.fields) cloud.fields = parseFields(*options.fields);
  for (Field field : cloud.fields) {
    const bool fromReference = field == Field::tie || field == Field::tolerance;
    if (fromReference && options.device != "reference") {
      throw Error(ErrorCode::invalidArgument,
                  "--fields: only --device reference gives '" + std::string(fieldInfo(field).name) + "'");
    }
  }
  if (!options.image.empty()) checkPictureFile(pathOf(options.image));
  const auto asciiChanges = [](const std::string& file) {
    return cloudFormat(pathOf(file)).text == CloudFormat::Text::ifAsked;
  };
  for (const std::string& output : options.outputs) cloudFormat(pathOf(output));
  checkWithoutEffect(options);
  if (options.ascii && std::ranges::none_of(options.outputs, asciiChanges))
    throw Error(ErrorCode::invalidArgument, "--ascii changes .pcd and .ply files, and no --output is one");
  std::vector<std::string> files;
  for (size_t i = 0; i < scans; ++i) {
    for (const std::string& output : options.outputs) files.push_back(fileOf(options, output, i));
    if (!options.image.empty()) files.push_back(fileOf(options, options.image, i));
  }
  if (options.stats != "-") files.push_back(options.stats);
  checkOutputFiles(files, inputsOf(options, options, options.trajectory));
  return cloud;
}

/// Returns the fields of the scan: those to write, and the intensity that a file of fixed columns (KITTI) holds.
std::vector<Field> scannedFields(const ScanOptions& options, const CloudOptions& cloud, const Effects& effects) {
  std::vector<Field> fields = cloud.fields;
  const auto isFixed = [](const std::string& file) { return cloudFormat(pathOf(file)).layout != nullptr; };
  if (effects.intensity.use != EffectUse::off && std::ranges::any_of(options.outputs, isFixed) &&
      std::ranges::count(fields, Field::intensity) == 0)
    fields.push_back(Field::intensity);
  return fields;
}

/// Warns of poses that follow each other in less than half a turn of the head, because every pose has a scan of its
/// own, and of a recording whose times are in another unit than seconds.
void warnOfSpacing(const ScanOptions& options, const Sensor& sensor,
                   const std::vector<SensorMotion::Stamp>& trajectory) {
  constexpr size_t kFew = 10;    // poses, which a person may have placed
  constexpr double kSlow = 1e4;  // s; more than between the stations of a survey
  if (trajectory.size() < 2) return;
  const double span = trajectory.back().time - trajectory.front().time;
  const double apart = span / static_cast<double>(trajectory.size() - 1);
  if (apart > 0 && apart < 0.5 * sensor.rotationPeriod)
    complain("warning: " + options.trajectory + formatted(" has a pose every %.3g s, and a turn of ", apart) +
             sensor.name +
             formatted(" takes %.3g s, so the scans overlap; gnosphere drive makes one scan per turn",
                       sensor.rotationPeriod));
  if (apart > kSlow && trajectory.size() >= kFew)
    complain("warning: " + options.trajectory + " " + drive::doubtOfSeconds(apart));
}

/// Warns if the field class is asked for and has nothing to tell.
void warnOfNoClasses(const ScanOptions& options, const CloudOptions& cloud, const Scene& scene) {
  const auto hasClass = [](const auto& item) { return item.classId != 0; };
  if (std::ranges::count(cloud.fields, Field::classId) == 0 || std::ranges::any_of(scene.materials, hasClass) ||
      std::ranges::any_of(scene.instances, hasClass))
    return;
  complain("warning: --fields: nothing in " + options.scene +
           " has the number of a class, so `class` is 0 everywhere; the extras of a glTF file give one, as {\"class\": "
           "10}, and so do the classes of a drive file (gnosphere drive)");
}

/// Warns if the field cause is asked for, and the clouds leave out all beams whose cause is not `returned`.
void warnOfNoCauses(const CloudOptions& cloud, uint32_t returns) {
  if (std::ranges::count(cloud.fields, Field::cause) == 0 || !cloud.compact.value_or(returns > 1)) return;
  complain(
      "warning: --fields: the clouds leave out beams without a return, so `cause` is 0 everywhere; --no-compact writes "
      "every beam");
}

/// Returns what the result depends on besides the device: the version, the command line, the effects with all their
/// values, and the files that the command line names.
Json madeBy(const ScanOptions& options, const Effects& effects) {
  Json inputs = Json::array();
  for (const std::string& input : inputsOf(options, options, options.trajectory)) {
    std::error_code absent;
    if (!std::filesystem::is_regular_file(pathOf(input), absent)) continue;  // such as the name of a built-in sensor
    inputs.push_back(inputJson(input, pathOf(input)));
  }
  return {{"version", GNOSPHERE_VERSION},
          {"arguments", options.arguments},
          {"effects", parseJson<Json>(toJson(effects))},
          {"inputs", inputs}};
}

/// With --repeat, scans once to warm up and then `repeat` times; the last scan is the result. Adds to `setUpMs` how
/// long the first scan had kernels compiled.
Scan runScans(Simulator& simulator, const Pose& pose, uint64_t repeat, std::vector<Timings>& runs, double& setUpMs) {
  Progress progress("scan", repeat);
  Shot shot;
  shot.pose = pose;
  Scan scan;
  const double start = nowMs();
  simulator.scanInto(shot, scan);
  setUpMs += nowMs() - start - scan.timings.wallMs;
  if (repeat == 0) {
    runs.push_back(scan.timings);
    return scan;
  }
  for (uint64_t run = 0; run < repeat; ++run) {
    progress.step(run + 1);
    simulator.scanInto(shot, scan);
    runs.push_back(scan.timings);
  }
  return scan;
}

/// Warns if the points of a cloud in the world frame lie so far away that single precision has steps of more than a
/// millimetre, and returns whether they do.
bool warnOfSteps(const Scan& world) {
  const std::string steps = coarsePoints(world);
  if (steps.empty()) return false;
  complain("warning: " + steps + "; --frame sensor keeps millimetres, and so do the LAS files of a drive");
  return true;
}

void writeScan(const ScanOptions& options, const CloudOptions& cloud, const Scan& scan, size_t number, bool& warned) {
  std::optional<Scan> mapped;
  if (options.frame == "world" && !options.outputs.empty()) {
    mapped = inWorld(scan);
    warned = warned || warnOfSteps(*mapped);
  }
  for (const std::string& output : options.outputs) {
    CloudOptions chosen = cloud;
    if (cloudFormat(pathOf(output)).layout) chosen.fields.clear();  // --fields is for the other outputs
    writeCloud(mapped ? *mapped : scan, pathOf(fileOf(options, output, number)), chosen);
  }
  if (!options.image.empty()) writePicture(scan, pathOf(fileOf(options, options.image, number)));
}

/// Names the planned effects whose particles can give a return, such as "fog or rain"; empty if there is none.
std::string mediaOf(const Plan& plan) {
  std::string names;
  for (const EffectInfo& effect : effectTable())
    if ((effect.bit & gpu::kMediumEffects) != 0 && plan.has(effect.name))
      names += (names.empty() ? "" : " or ") + std::string(effect.name);
  return names;
}

/// How many beams return something, but nothing of a surface.
uint64_t beamsOfMedium(const Scan& scan) {
  uint64_t beams = 0;
  for (size_t first = 0; first < scan.ranges.size(); first += scan.returns) {
    bool medium = false, surface = false;
    for (size_t entry = first; entry < first + scan.returns; ++entry) {
      surface = surface || scan.hit(entry);
      medium = medium || scan.returned(entry);
    }
    beams += medium && !surface;
  }
  return beams;
}

/// The name of a file and its size, which pipes and devices do not have.
std::string withSize(const std::string& file) {
  const std::string size = fileSize(file);
  return size.empty() ? file : file + ", " + size;
}

void tell(const ScanOptions& options, const ScanReport& report) {
  if (options.stats == "-") {
    std::printf("%s", statsJson(report).c_str());
    return;
  }
  std::vector<std::string> written = options.outputs;
  if (!options.image.empty()) written.push_back(options.image);
  if (!options.stats.empty()) {
    AtomicFile stats(pathOf(options.stats));
    stats.write(statsJson(report));
    stats.commit();
  }
  printSummary(report);
  for (const std::string& file : written) {
    const std::string first = fileOf(options, file, 0);
    const bool many = report.trajectory.size() > 1;
    say("wrote", withSize(first) + (many ? ", to " + fileOf(options, file, report.trajectory.size() - 1) : ""));
  }
  if (!options.stats.empty()) say("wrote", withSize(options.stats));
  if (written.empty() && options.stats.empty()) say("wrote", "nothing; -o FILE writes the cloud");
}

/// Returns which built-in head a sensor is, because the ideal heads of the paper have names of real ones.
std::string textOf(const BuiltInHead& head) {
  if (head.ideal) return ", an ideal head of the paper,";
  return head.real ? " (" + head.real->product + ")" : "";
}

/// With --max-error, chooses the setting; empty if none is within the limit.
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
                "--max-error compares the device with the reference; choose another --device");
  }
}

int runScan(const ScanOptions& options) {
  check(options);
  std::vector<SensorMotion::Stamp> trajectory;
  if (!options.trajectory.empty()) trajectory = drive::readTum(pathOf(options.trajectory));
  Effects effects = effectsOf(options);
  // Without deskewing, each column of a moving sensor has a frame of its own, and no single pose leads to the world.
  if (options.frame == "world") effects.sensorMotion.deskew = true;
  const MaterialTable materials = materialsOf(options);
  const CloudOptions cloud = checkOutputs(options, std::max<size_t>(1, trajectory.size()));
  const Sensor sensor = sensorOf(options.sensor);
  warnOfSpacing(options, sensor, trajectory);
  double start = nowMs();
  const Scene scene = loadScene(options);
  const double loadMs = nowMs() - start;
  warnOfNoClasses(options, cloud, scene);
  const Pose pose = poseOf(options, scene);

  const std::optional<AccuracyChoice> choice = choose(options, scene, sensor, pose);
  if (choice && !choice->chosen) {
    complain(choice->why);
    return 1;
  }

  start = nowMs();
  SimulatorOptions usual;
  usual.tuning.keepStill = options.repeat == 0;  // --repeat times whole scans, without reuse of still instances
  SimulatorOptions settings = simulatorOptions(options, usual);
  if (choice) assign(settings, "accuracy=" + choice->chosen->name);
  settings.materials = materials;
  if (options.trace) settings.trace = [](const std::string& line) { complain(line); };
  SensorRequest request(sensor, effects, scannedFields(options, cloud, effects));
  applyToRequest(options, request);
  Simulator simulator(scene, request, settings);
  const double setUpMs = nowMs() - start;
  warnOfNoCauses(cloud, simulator.plan().returns);

  ScanReport result = {options.scene,
                       scene,
                       sensor,
                       textOf(builtInHead(options.sensor)),
                       simulator,
                       {},
                       accuracyText(settings),
                       {},
                       {},
                       loadMs,
                       setUpMs,
                       choice ? &*choice : nullptr,
                       mediaOf(simulator.plan())};
  if (!options.stats.empty()) result.madeBy = madeBy(options, request.effects);
  start = nowMs();
  bool warned = false;  // of the steps of single precision
  const auto keep = [&](size_t number, const Scan& scan) {
    if (!result.media.empty()) result.ofMedium += beamsOfMedium(scan);
    writeScan(options, cloud, scan, number, warned);
  };
  if (trajectory.empty()) {
    result.scan = runScans(simulator, pose, options.repeat, result.runs, result.setUpMs);
    keep(0, result.scan);
  } else {
    result.trajectory = scanTrajectory(simulator, sensor, trajectory, keep);
    for (const TrajectoryScan& scan : result.trajectory) result.runs.push_back(scan.timings);
    result.scan = summaryOf(result.trajectory, sensor);
  }
  result.totalMs = nowMs() - start;
  if (const uint64_t dropped = result.scan.counters.nonFinite; dropped > 0)
    complain("warning: " + droppedText(dropped, options.scene));
  const Counters& counters = result.scan.counters;  // the summary tells how many beams have echoes that are not chosen
  if ((counters.hits == 0 && counters.causes[static_cast<size_t>(Cause::notChosen)] == 0) ||
      scene.placedTriangleCount() == 0)
    warnOfNoHits(trajectory.empty() ? "no beam" : "no beam of any scan", options, options.trajectory, scene, request,
                 settings, result.scan.pose, trajectory.empty() ? result.scan.counters : result.trajectory[0].counters);
  tell(options, result);
  return 0;
}

/// Returns the options that the command line states, with their values: true for a flag, or false if it is negated,
/// text, or a list of texts.
Json argumentsOf(const CLI::App& app) {
  Json arguments = Json::object();
  for (const CLI::Option* option : app.get_options()) {
    if (option->count() == 0) continue;
    const std::vector<std::string>& values = option->results();
    Json& value = arguments[lower(option->get_single_name())];
    if (option->get_items_expected_max() == 0)
      value = values.back() != "false";
    else if (option->get_items_expected_max() == 1)
      value = values[0];
    else
      value = values;
  }
  return arguments;
}

void addAccuracyOptions(CLI::App& app, ScanOptions& options) {
  CLI::Option* accuracy = addAccuracyOption(app, options.settings);
  app.add_option("--max-error", options.maxError,
                 "Choose the fastest accuracy on this device that loses no beam and has no larger error (metres), "
                 "measured from this pose on a sample of the beams; standard, unless another is clearly faster")
      ->excludes(accuracy);
}

}  // namespace

Action addScan(CLI::App& app) {
  const auto options = std::make_shared<ScanOptions>();
  addScanningOptions(app, *options);
  addEffectOptions(app, *options);
  addAccuracyOptions(app, *options);
  CLI::Option* trajectory =
      app.add_option("--trajectory", options->trajectory,
                     "Scan from every pose of a TUM file, lines of t x y z qx qy qz qw; output files are numbered: "
                     "a.pcd becomes a-000000.pcd and so on");
  trajectory->excludes(app.get_option("--pose"))->excludes(app.get_option("--max-error"));
  app.add_option("-o,--output", options->outputs,
                 "Cloud file to write: " + cloudEndings("or") + "; may be given more than once")
      ->allow_extra_args(false);
  app.add_option_function<std::string>(
      "--fields", [options](const std::string& names) { options->fields = names; },
      "Fields to write, in this order: x,y,z,range,ring,beam,triangle,instance (default, plus "
      "return,returns if beams have several), tie, tolerance (both of --device reference only), intensity, "
      "true_range, cause, label, width, normal, "
      "incidence, material, barycentrics (u, v), class, velocity, radial_speed, time, azimuth, elevation");
  app.add_option(
         "--frame", options->frame,
         "The frame of points, normals and velocities in the cloud files: the sensor's, or the scene's, in which "
         "the clouds of a trajectory, deskewed, make up a map")
      ->check(CLI::IsMember({"sensor", "world"}))
      ->capture_default_str();
  app.add_flag_function(
      "--compact,!--no-compact", [options](int64_t count) { options->compact = count > 0; },
      "Write only returns, a row each, or every beam with a row for each of the returns that it may have; by default "
      "only returns if beams have several, otherwise every beam");
  app.add_flag("--ascii", options->ascii, "Write PCD and PLY as text");
  app.add_option("--image", options->image, "Write a .png picture of the scan, as the sensor sees it and from above");
  app.add_option("--stats", options->stats,
                 "Write what has made the scan, times and counters to a JSON file, or - for stdout");
  app.add_flag("--trace", options->trace,
               "Print every step that the device executes, with its size and time, to standard error");
  app.add_option("--repeat", options->repeat, "Number of timed scans after a warm-up; reports their median time")
      ->check(CLI::Range(uint64_t{1}, uint64_t{1'000'000}))
      ->excludes(trajectory);
  app.footer("Example: gnosphere scan town.glb --sensor Puck -o cloud.pcd --image cloud.png");
  return [options, &app] {
    options->arguments = argumentsOf(app);
    return runScan(*options);
  };
}

}  // namespace gnosphere::cli
