// SPDX-License-Identifier: Apache-2.0
#include "drive/drive.hpp"

#include <algorithm>
#include <memory>
#include <optional>
#include <system_error>

#include "base/path.hpp"
#include "base/vector.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "drive/live.hpp"
#include "drive/run.hpp"
#include "drive/schedule.hpp"
#include "effect_options.hpp"
#include "no_hits.hpp"
#include "option_table.hpp"
#include "scanning.hpp"
#include "sensor/beams.hpp"

namespace gnosphere::cli {
namespace {

struct DriveCall {
  std::string file, out, frames, shard, seed, name, device = "auto";
  Settings settings;
  bool verify = false, live = false;
  double speed = 1;
};

drive::RunOptions optionsOf(const DriveCall& call) {
  drive::RunOptions options;
  options.out = pathOf(call.out);
  options.verify = call.verify;
  chooseFrames(call.frames, options.firstFrame, options.endFrame);
  if (!call.shard.empty() &&
      (!parsePair(call.shard, '/', false, options.shard, options.shardCount) || options.shard >= options.shardCount))
    throw Error(ErrorCode::invalidArgument,
                "--shard: '" + call.shard + "' is not I/N with I from 0 to N - 1, as 0/4 to 3/4");
  options.simulator.device = deviceByName(call.device);
  for (const std::string& assignment : call.settings)
    if (simulatorOption(assignment.substr(0, assignment.find('='))).changes == Changes::cloud)
      throw Error(ErrorCode::invalidArgument,
                  "--set: '" + assignment + "' changes the clouds, so it belongs into \"simulator\" of the drive file");
  apply(call.settings, options.simulator);
  options.simulator.warn = [](const std::string& message) { complain("warning: " + message); };
  return options;
}

/// Returns the seed of the command line, which is read as other commands read theirs; none if there is none.
std::optional<uint64_t> seedOf(const DriveCall& call) {
  if (call.seed.empty()) return {};
  EffectOptions options;
  options.seed = call.seed;
  return effectsOf(options).seed;
}

/// Returns the name of the command line; none if there is none.
std::optional<std::string> nameOf(const DriveCall& call) {
  if (call.name.empty()) return {};
  if (const std::string why = drive::mistakeOfName(call.name); !why.empty())
    throw Error(ErrorCode::invalidArgument, "--name: " + why);
  return call.name;
}

/// Returns text such as "kitti in kitti/, sensor top".
std::string outputText(const drive::Drive& drive, const drive::Output& output) {
  std::string names;
  for (const size_t sensor : output.sensors) names += (names.empty() ? "" : ", ") + drive.sensors[sensor].name;
  return output.format + " in " + output.folder + "/, " + (output.sensors.size() == 1 ? "sensor " : "sensors ") + names;
}

/// Returns text such as "2 actors start within x 0..1, y 0..0, z 0..0 m"; empty for a drive without actors.
std::string actorsText(const drive::Drive& drive) {
  if (drive.actors.empty()) return "";
  Bounds around;
  around.min = around.max = drive.actors[0].trajectory.at(drive.start).position;
  for (const drive::Actor& actor : drive.actors) {
    const Vec3 place = actor.trajectory.at(drive.start).position;
    around.min = lowest(around.min, place);
    around.max = highest(around.max, place);
  }
  return counted(drive.actors.size(), "actor starts", "actors start") + " within " + extentText(around);
}

/// Returns the largest of the least ranges, and of the largest ones, of a sensor's beams in its first scan.
RangeWindow largestRanges(const Sensor& sensor) {
  RangeWindow largest = {0, 0};
  for (size_t beam = 0; beam < sensor.beamCount(); ++beam) {
    const RangeWindow window = rangeWindowOf(sensor, beam, 0);
    largest = {std::max(largest.least, window.least), std::max(largest.most, window.most)};
  }
  return largest;
}

/// Returns where scenes, actors and the first sensor of a drive are, and how far it sees: the vehicle may be far from
/// the scenes, or a scene may have another unit.
std::string placesText(const drive::Drive& drive) {
  std::string extents;
  for (const Scene& scene : drive.scenes) {
    const Bounds bounds = worldBounds(scene);
    if (!bounds.empty()) extents += (extents.empty() ? "" : " and ") + extentText(bounds);
  }
  const std::string actors = actorsText(drive);
  return "the scenes " + (extents.empty() ? "have no triangle" : "span " + extents) +
         (actors.empty() ? "" : ", " + actors) + ", and sensor '" + drive.sensors[0].name + "' starts at " +
         placeText(drive.sensorPose(0, drive.start).position) + " and sees as far as " +
         coordinateText(largestRanges(drive.sensors[0].sensor).most) + " m";
}

/// Warns of a run in which no scan has a point.
void warnOfNoPoints(const drive::Drive& drive, const Counters& counters) {
  std::string places = placesText(drive);
  for (const drive::RigSensor& rigged : drive.sensors) {
    const double least = largestRanges(rigged.sensor).least;
    const bool hides = rigged.sensor.nearHits == NearHits::hide;
    if (least < (hides ? 1e-3 : 1)) continue;
    places += "; surfaces nearer than the least range of sensor '" + rigged.name + "', " + coordinateText(least) +
              " m, " + (hides ? "hide what is behind them, because its near_hits is hide" : "give no return");
    break;
  }
  const auto isMasked = [](const drive::RigSensor& rigged) {
    return maskedBeams(rigged.sensor) == rigged.sensor.beamCount();
  };
  const std::vector<Loss> losses = lossesByEffects(counters, std::ranges::all_of(drive.sensors, isMasked));
  const Loss unmet = {beamsWithoutSurface(counters), "met nothing in their ranges", places};
  complain("warning: no scan has a point; " + (losses.empty() ? places : lossText(losses, unmet, counters.beams)));
}

/// Returns text such as "7; that of sensor top is 1".
std::string seedText(const drive::Drive& drive) {
  std::string others;
  for (const drive::RigSensor& sensor : drive.sensors)
    if (sensor.effects.seed != drive.seed)
      others += "; that of sensor " + sensor.name + " is " + std::to_string(sensor.effects.seed);
  return std::to_string(drive.seed) + others;
}

/// Returns text such as "car 4.6 x 1.8 x 1.5 m, person 0.5 x 0.6 x 1.7 m": lengths, widths and heights of the models
/// that the drive file names, without the size that an actor may give them. Of many models these are the first.
std::string modelsText(const drive::Drive& drive) {
  constexpr size_t kShown = 6;
  std::string text;
  for (size_t m = 0; m < std::min(kShown, drive.modelNames.size()); ++m) {
    const Bounds bounds = worldBounds(drive.models[m]);
    const Vec3 size = bounds.max - bounds.min;
    text +=
        (text.empty() ? "" : ", ") + drive.modelNames[m] + formatted(" %.3g x %.3g x %.3g m", size.x, size.y, size.z);
  }
  if (drive.modelNames.size() > kShown) text += " and " + grouped(drive.modelNames.size() - kShown) + " more";
  return text;
}

void describe(const drive::Drive& drive) {
  size_t triangles = 0;
  for (const Scene& scene : drive.scenes) triangles += scene.placedTriangleCount();
  say("drive", drive.name + ", " + counted(drive.frameCount(), "frame", "frames") + " at " +
                   formatted("%g", drive.rate) + " Hz, " + formatted("%g", drive.duration) + " s");
  say("seed", seedText(drive));
  say("scene", counted(triangles, "triangle", "triangles") + ", " + counted(drive.actors.size(), "actor", "actors"));
  if (!drive.modelNames.empty()) say("models", modelsText(drive));
  for (const drive::RigSensor& sensor : drive.sensors)
    say("sensor", sensor.name + ", " + sensor.sensor.name + ", " + grouped(sensor.sensor.beamCount()) + " beams at " +
                      formatted("%g", sensor.rate) + " Hz");
}

void sayDevice(const DeviceInfo& device) {
  say("device", device.name);
}

/// Returns text such as "21 of 40 frames are missing, the first is 2".
std::string missingText(const drive::RunReport& report, uint64_t frames) {
  const bool isOne = report.missing == 1;
  return grouped(report.missing) + " of " + counted(frames, "frame", "frames") + (isOne ? " is" : " are") +
         " missing, " + (isOne ? "frame " : "the first is ") + std::to_string(report.firstMissing);
}

void summarise(const drive::RunReport& report, uint64_t frames, double seconds) {
  const uint64_t made = report.chosen - report.kept;
  for (const std::string& path : report.broken)
    say("broken", path + " was not as it had been written, and is made again");
  say("frames", grouped(report.chosen) + ": " + grouped(made) + " made, " + grouped(report.kept) + " complete before");
  if (made > 0) {
    say("made", counted(report.scans, "scan", "scans") + " with " + counted(report.points, "point", "points") + ", " +
                    counted(report.files, "file", "files") + " of " + grouped((report.bytes + 500'000) / 1'000'000) +
                    " MB");
    say("time", formatted("%.1f s, %.2f frames a second", seconds, static_cast<double>(made) / seconds));
  }
  say("drive", report.finished
                   ? "complete"
                   : "not complete; " + missingText(report, frames) + "; its tables are written with its last frame");
}

/// Publishes the frames that `options` has.
int runLive(const DriveCall& call, const drive::Drive& drive, const drive::RunOptions& options) {
  drive::LiveOptions live;
  live.firstFrame = options.firstFrame;
  live.endFrame = options.endFrame;
  live.speed = call.speed;
  live.simulator = options.simulator;
  drive::LiveReport report;
  {
    Progress progress("frame", 1, true);
    live.started = sayDevice;
    live.progress = [&](uint64_t done, uint64_t total) { progress.step(done, total); };
    report = drive::publishLive(drive, live);
  }
  say("published", counted(report.scans, "scan", "scans") + " with " + counted(report.points, "point", "points") +
                       ", " + counted(report.messages, "message", "messages") + " in " +
                       formatted("%.1f s", report.seconds));
  if (report.dropped > 0) say("dropped", grouped(report.dropped) + " messages that newer ones replaced");
  if (report.late >= 0.05) say("late", formatted("%.1f s; scanning takes longer than the drive", report.late));
  return 0;
}

int runDrive(const DriveCall& call) {
  drive::RunOptions options = optionsOf(call);
  const drive::Drive drive = drive::readDrive(pathOf(call.file), seedOf(call), nameOf(call));
  for (const std::string& warning : drive.warnings) complain("warning: " + warning);
  if (const std::string why = drive::mistakeOfFrames(drive, options.firstFrame, options.endFrame); !why.empty())
    throw Error(ErrorCode::invalidArgument, "--frames: " + why);
  describe(drive);
  if (call.live) return runLive(call, drive, options);
  for (const drive::Output& output : drive.outputs) say("output", outputText(drive, output));
  if (call.out.empty()) {
    say("made", "nothing; -o FOLDER makes the data set");
    return 0;
  }
  for (const char* made : {"objects.json", "classes.json"}) {
    std::error_code absent;
    if (std::filesystem::equivalent(pathOf(call.out) / made, pathOf(call.file), absent))
      throw Error(ErrorCode::invalidArgument, call.file + " would be written, too; choose another --output");
  }
  const double begin = nowMs();
  drive::RunReport report;
  {
    Progress progress("frame", 1, true);
    options.started = sayDevice;
    options.progress = [&](uint64_t done, uint64_t total) { progress.step(done, total); };
    report = drive::run(drive, options);
  }
  if (report.scans > 0 && report.points == 0) warnOfNoPoints(drive, report.counters);
  summarise(report, drive.frameCount(), (nowMs() - begin) / 1000);
  return 0;
}

}  // namespace

Action addDrive(CLI::App& app) {
  const auto call = std::make_shared<DriveCall>();
  app.add_option("DRIVE", call->file, "The drive file (JSON), see docs/drives.md")->required();
  CLI::Option* const out =
      app.add_option("-o,--output", call->out,
                     "Folder to write; frames that are complete there are not made again. Without it the drive file "
                     "is only checked");
  app.add_option("--frames", call->frames, "Make the frames from A on and before B only, A:B");
  CLI::Option* const shard =
      app.add_option("--shard", call->shard, "Make the frames whose number modulo N is I only, I/N");
  app.add_option("--seed", call->seed,
                 "The seed of all random numbers, in place of that of the drive file; it belongs to the data set");
  app.add_option("--name", call->name,
                 "The name of the drive, in place of that of the drive file; nuScenes' scenes and files have it");
  app.add_option("--device", call->device, kDeviceHelp)->capture_default_str();
  addSetOption(app, call->settings);
  app.add_flag("--verify", call->verify,
               "Read complete frames and finished files, and make those again that have changed")
      ->needs(out);
  CLI::Option* const live =
      app.add_flag("--live", call->live,
                   "Publish clouds, transforms and the clock for ROS 2 in the time of the drive, and write no files; "
                   "docs/ros2.md")
          ->excludes(out)
          ->excludes(shard);
  app.add_option("--speed", call->speed, "With --live: seconds of the drive per second")
      ->check(CLI::Range(0.001, 1000.0))
      ->needs(live);
  app.footer("Example: gnosphere drive town-drive.json -o dataset");
  return [call] { return runDrive(*call); };
}

}  // namespace gnosphere::cli
