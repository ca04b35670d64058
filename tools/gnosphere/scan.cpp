// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <memory>

#include "commands.hpp"
#include "console.hpp"
#include "file.hpp"
#include "output/fields.hpp"
#include "scan_report.hpp"

namespace gnosphere::cli {
namespace {

const std::map<std::string, Accuracy> kAccuracies = {{"paper", Accuracy::paper},
                                                     {"draft", Accuracy::draft},
                                                     {"standard", Accuracy::standard},
                                                     {"exact", Accuracy::exact}};
const std::map<std::string, Faces> kFaces = {
    {"material", Faces::material}, {"front", Faces::front}, {"both", Faces::both}};
const std::map<std::string, Binning> kBinnings = {{"auto", Binning::automatic},
                                                  {"nearest", Binning::nearest},
                                                  {"nearest32", Binning::nearest32},
                                                  {"lists", Binning::lists}};
const std::map<std::string, UpAxis> kUpAxes = {{"", UpAxis::formatDefault}, {"y", UpAxis::y}, {"z", UpAxis::z}};

struct ScanOptions {
  std::string scene, sensor = "HDL-64E", pose, up, fields, image, stats, device = "auto";
  std::string accuracy = "standard", faces = "material", binning = "auto";
  std::vector<std::string> outputs;
  double scale = 1;
  uint64_t repeat = 0;  ///< 0: one scan, and no warm-up before it
  bool compact = false, ascii = false, validation = false;
};

Pose parsePose(const std::string& text) {
  std::vector<double> numbers;
  const char* at = text.data();
  const char* end = at + text.size();
  while (at <= end) {
    while (at < end && (*at == ' ' || *at == '+')) ++at;
    double value = 0;
    const auto result = std::from_chars(at, end, value);
    const bool sound = result.ec == std::errc() && std::isfinite(value) && (result.ptr == end || *result.ptr == ',');
    if (!sound) {
      numbers.clear();
      break;
    }
    numbers.push_back(value);
    at = result.ptr + 1;
  }
  if (numbers.size() != 3 && numbers.size() != 7) {
    throw Error(ErrorCode::invalidArgument,
                "--pose: '" + text + "' is not X,Y,Z or X,Y,Z,QX,QY,QZ,QW with finite numbers");
  }
  Pose pose;
  pose.position = {numbers[0], numbers[1], numbers[2]};
  if (numbers.size() == 3) return pose;
  const double norm = std::hypot(std::hypot(numbers[3], numbers[4]), std::hypot(numbers[5], numbers[6]));
  if (!(norm > 1e-6) || !std::isfinite(norm)) {
    throw Error(ErrorCode::invalidArgument, "--pose: the quaternion '" + text + "' has no length");
  }
  pose.orientation = {numbers[3] / norm, numbers[4] / norm, numbers[5] / norm, numbers[6] / norm};
  return pose;
}

/// Standing at the world's origin if the scene is there, else in the middle of the scene; 1.8 m up, as on a car's roof.
Pose defaultPose(const Scene& scene) {
  Pose pose;
  pose.position = {0, 0, 1.8};
  const Bounds bounds = worldBounds(scene);
  const bool aroundOrigin = bounds.min.x <= 0 && bounds.max.x >= 0 && bounds.min.y <= 0 && bounds.max.y >= 0;
  if (bounds.empty() || aroundOrigin) return pose;
  pose.position = {(bounds.min.x + bounds.max.x) / 2, (bounds.min.y + bounds.max.y) / 2, bounds.min.z + 1.8};
  return pose;
}

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
  for (auto file = files.begin(); file != files.end(); ++file) {
    std::error_code absent;
    if (std::filesystem::equivalent(*file, options.scene, absent)) {
      throw Error(ErrorCode::invalidArgument, *file + " is the scene itself; write to another file");
    }
    if (std::find(files.begin(), file, *file) != file) {
      throw Error(ErrorCode::invalidArgument, *file + " is to be written twice");
    }
    checkWritable(*file);
  }
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

int runScan(const ScanOptions& options) {
  if (!std::isfinite(options.scale) || options.scale <= 0) {
    throw Error(ErrorCode::invalidArgument, "--scale must be finite and above 0");
  }
  const CloudOptions cloud = checkOutputs(options);
  const Sensor sensor = findSensor(options.sensor);
  Pose pose;
  if (!options.pose.empty()) pose = parsePose(options.pose);

  double start = nowMs();
  const Scene scene = loadScene(options.scene, {kUpAxes.at(options.up), options.scale});
  const double loadMs = nowMs() - start;
  if (options.pose.empty()) pose = defaultPose(scene);

  start = nowMs();
  SimulatorOptions settings;
  settings.device = options.device;
  settings.accuracy = kAccuracies.at(options.accuracy);
  settings.faces = kFaces.at(options.faces);
  settings.binning = kBinnings.at(options.binning);
  settings.validation = options.validation;
  Simulator simulator(scene, sensor, settings);
  const double setUpMs = nowMs() - start;

  std::vector<Timings> runs;
  const Scan scan = runScans(simulator, pose, options.repeat, runs);
  warnAbout(options, scene, scan.counters);
  writeOutputs(
      options, cloud,
      {options.scene, scene, sensor, simulator, scan, options.accuracy, options.binning, runs, loadMs, setUpMs});
  return 0;
}

void addScanningOptions(CLI::App& app, ScanOptions& options) {
  app.add_option("--sensor", options.sensor, "A built-in name (gnosphere sensors) or a JSON file")
      ->capture_default_str();
  app.add_option("--pose", options.pose,
                 "X,Y,Z[,QX,QY,QZ,QW]: where the sensor stands and how it is turned, in metres (default: 1.8 m above "
                 "the origin, or above the middle of a scene that is elsewhere)");
  app.add_option("--accuracy", options.accuracy,
                 "paper: the published method to the letter; draft: quick; standard: watertight; exact: the same "
                 "bytes everywhere")
      ->check(CLI::IsMember(kAccuracies))
      ->capture_default_str();
  app.add_option("--faces", options.faces, "Which faces reflect")->check(CLI::IsMember(kFaces))->capture_default_str();
  app.add_option("--binning", options.binning, "How triangles meet beams; every way gives the same cloud")
      ->check(CLI::IsMember(kBinnings))
      ->capture_default_str();
  app.add_option("--up", options.up, "The scene's upward axis (default: what its format says)")
      ->check(CLI::IsMember({"y", "z"}));
  app.add_option("--scale", options.scale, "Scene units in metres")->capture_default_str();
  app.add_option("--device", options.device, "auto, a number or part of a name of gnosphere devices, or reference")
      ->capture_default_str();
  app.add_option("--repeat", options.repeat, "Scan this often after a warm-up, and report the median time")
      ->check(CLI::Range(uint64_t{1}, uint64_t{1'000'000}));
  app.add_flag("--validation", options.validation, "Vulkan validation layer on; its messages are errors");
}

}  // namespace

Action addScan(CLI::App& app) {
  const auto options = std::make_shared<ScanOptions>();
  app.add_option("SCENE", options->scene, "A .gltf, .glb, .obj, .ply or .stl file")->required();
  app.add_option("-o,--output", options->outputs,
                 "A cloud to write: .pcd, .ply, .bin (KITTI), .npy or .csv; may be given more than once")
      ->allow_extra_args(false);
  app.add_option("--fields", options->fields,
                 "What to write, in this order: x,y,z,range,ring,beam,triangle,instance (default), tie,tolerance");
  app.add_flag("--compact", options->compact, "Write the hits only, not every beam");
  app.add_flag("--ascii", options->ascii, "Write PCD and PLY as text");
  app.add_option("--image", options->image, "A .png of the scan: as the sensor sees it, and from above");
  app.add_option("--stats", options->stats, "A JSON file of times and counters, or - for stdout");
  addScanningOptions(app, *options);
  return [options] { return runScan(*options); };
}

}  // namespace gnosphere::cli
