// SPDX-License-Identifier: Apache-2.0
#include "drive/run.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "drive/formats/format.hpp"
#include "drive/frame_queue.hpp"
#include "drive/manifest.hpp"

namespace gnosphere::drive {
namespace {

using Formats = std::vector<std::unique_ptr<Format>>;

/// Scans the frames of a drive. Nothing of a frame depends on those before it.
class Scanner {
 public:
  Scanner(const Drive& drive, const World& world, const Formats& formats, SimulatorOptions options)
      : drive_(drive), world_(world), placed_(world.scene().instances.size()) {
    options.accuracy = drive.accuracy;
    std::vector<SensorRequest> requests;
    for (size_t s = 0; s < drive.sensors.size(); ++s) requests.push_back(requestOf(s, formats));
    simulator_.emplace(world.scene(), requests, options);
    for (size_t i = 0; i < placed_.size(); ++i) placed_[i] = world.scene().instances[i].transform;
  }

  void scan(FrameRecord& record) {
    const std::vector<PlannedScan> planned = scansOf(drive_, record.frame);
    record.scans.resize(planned.size());
    for (size_t i = 0; i < planned.size(); ++i) {
      record.scans[i].planned = planned[i];
      scan(record.scans[i]);
    }
  }

  const DeviceInfo& device() const { return simulator_->device(); }

 private:
  SensorRequest requestOf(size_t sensor, const Formats& formats) const {
    const RigSensor& rigged = drive_.sensors[sensor];
    std::set<Field> fields = {Field::time};
    for (const auto& format : formats)
      if (format->writes(sensor))
        for (Field field : format->fields()) fields.insert(field);
    if (rigged.effects.intensity.use == EffectUse::off) fields.erase(Field::intensity);
    SensorRequest request(rigged.sensor, rigged.effects, {fields.begin(), fields.end()});
    request.variableWeather = weatherFor(sensor, drive_.start).has_value();
    return request;
  }

  /// The drive's weather without what the effects of a sensor turn off; none if they turn all of it off.
  std::optional<Weather> weatherFor(size_t sensor, double time) const {
    const Effects& effects = drive_.sensors[sensor].effects;
    const bool fog = effects.fog.use != EffectUse::off, rain = effects.rain.use != EffectUse::off,
               snow = effects.snow.use != EffectUse::off;
    std::optional<Weather> weather = drive_.weatherAt(time);
    if (!weather || !(fog || rain || snow)) return {};
    if (!fog) weather->visibility = 0;
    if (!rain) weather->rainRate = 0;
    if (!snow) weather->snowRate = 0;
    return weather;
  }

  void scan(RecordedScan& recorded) {
    const auto& [sensor, number, time] = recorded.planned;
    const RigSensor& rigged = drive_.sensors[sensor];
    recorded.duration = durationOf(rigged.sensor, number);
    recorded.pose = drive_.sensorPose(sensor, time);
    recorded.sensorMoves = recorded.duration > 0 && rigged.effects.sensorMotion.use != EffectUse::off;
    recorded.actorsMove = recorded.duration > 0 && rigged.effects.objectMotion.use != EffectUse::off;
    recorded.deskewed = rigged.effects.sensorMotion.deskew;
    Shot shot;
    shot.pose = recorded.pose;
    shot.sensor = sensor;
    shot.frame = number;
    shot.weather = weatherFor(sensor, time);
    if (recorded.sensorMoves && drive_.ego.movesWithin(time, time + recorded.duration))
      shot.motion = motionOf(recorded);
    placeWorld(recorded, shot);
    simulator_->scanInto(shot, recorded.scan);
    recorded.points = 0;
    for (size_t entry = 0; entry < recorded.scan.ranges.size(); ++entry) {
      recorded.points += recorded.scan.returned(entry);
      uint32_t& owner = recorded.scan.instances[entry];
      if (owner != kNoTriangle) owner = world_.objectOf(owner);
    }
  }

  /// The sensor's poses during a scan: at the stamps of the ego's trajectory, and 17 times at equal intervals, between
  /// which a sensor beside the middle of the vehicle goes straight although the vehicle may turn.
  SensorMotion motionOf(const RecordedScan& recorded) const {
    constexpr int kIntervals = 16;
    const double begin = recorded.planned.time, end = begin + recorded.duration;
    std::vector<double> times = drive_.ego.timesWithin(begin, end);
    for (int i = 0; i <= kIntervals; ++i) times.push_back(begin + recorded.duration * i / kIntervals);
    std::sort(times.begin(), times.end());
    SensorMotion motion;
    for (double time : times)
      if (motion.stamps.empty() || time - begin > motion.stamps.back().time)
        motion.stamps.push_back({time - begin, drive_.sensorPose(recorded.planned.sensor, time)});
    return motion;
  }

  /// Sets the world of the scan's start, and its motion until the scan's end.
  void placeWorld(const RecordedScan& recorded, Shot& shot) {
    const double begin = recorded.planned.time, end = begin + recorded.duration;
    const World::Setter start = {
        [&](size_t instance, const Transform& transform) {
          if (placed_[instance].rows == transform.rows) return;
          simulator_->setTransform(instance, transform);
          placed_[instance] = transform;
        },
        [&](size_t mesh, const Deformation& deformation) { simulator_->setDeformation(mesh, deformation); }};
    const World::Setter motion = {[&](size_t instance, const Transform& transform) {
                                    if (placed_[instance].rows != transform.rows)
                                      shot.instanceMotions.push_back({instance, transform});
                                  },
                                  [&](size_t mesh, const Deformation& deformation) {
                                    shot.meshMotions.push_back({mesh, deformation});
                                  }};
    world_.placeScenes(begin, start);
    if (recorded.actorsMove) world_.placeScenes(end, motion);
    for (size_t actor = 0; actor < drive_.actors.size(); ++actor) {
      world_.place(actor, world_.poseOf(actor, begin), begin, start);
      if (recorded.actorsMove && world_.movesWithin(actor, begin, end))
        world_.place(actor, drive_.actors[actor].trajectory.at(end), end, motion);
    }
  }

  const Drive& drive_;
  const World& world_;
  std::vector<Transform> placed_;  // by instance, as the simulator has them
  std::optional<Simulator> simulator_;
};

void check(const RunOptions& options) {
  const auto refuse = [](const std::string& text) { throw Error(ErrorCode::invalidArgument, "RunOptions: " + text); };
  if (options.shard >= options.shardCount)
    refuse("there is no shard " + std::to_string(options.shard) + " of " + std::to_string(options.shardCount) +
           "; N shards are numbered from 0 to N - 1");
  if (options.firstFrame >= options.endFrame)
    refuse("the first frame is " + std::to_string(options.firstFrame) + "; it must be less than the end, " +
           std::to_string(options.endFrame));
}

std::vector<uint64_t> framesToMake(const Drive& drive, const RunOptions& options, const Manifest& manifest,
                                   RunReport& report) {
  std::vector<uint64_t> frames;
  for (uint64_t f = options.firstFrame; f < std::min(options.endFrame, drive.frameCount()); ++f) {
    if (f % options.shardCount != options.shard) continue;
    ++report.chosen;
    if (manifest.isComplete(f, options.verify))
      ++report.kept;
    else
      frames.push_back(f);
  }
  return frames;
}

/// Numbers of objects, for whoever reads labels.
void writeObjects(const Drive& drive, const World& world, const std::filesystem::path& out) {
  nlohmann::ordered_json objects = nlohmann::ordered_json::array();
  const std::vector<Instance>& instances = world.scene().instances;
  for (size_t i = 0; i < instances.size(); ++i)
    if (world.objectOf(i) == i)
      objects.push_back({{"object", i},
                         {"name", instances[i].name},
                         {"class_id", instances[i].classId},
                         {"actor", world.actorOf(static_cast<uint32_t>(i)).has_value()}});
  std::string text = "[\n";
  for (size_t i = 0; i < objects.size(); ++i) text += objects[i].dump() + (i + 1 < objects.size() ? ",\n" : "\n");
  writeWhole(out / "objects.json", text + "]\n");
  nlohmann::ordered_json classes = nlohmann::ordered_json::object();
  for (const Class& category : drive.classes) classes[category.name] = category.id;
  writeWhole(out / "classes.json", classes.dump(1) + "\n");
}

/// Makes frames: this thread scans, another one finds boxes and writes.
void makeFrames(const Drive& drive, const World& world, const Formats& formats, const std::vector<uint64_t>& frames,
                const RunOptions& options, const Manifest& manifest, RunReport& report) {
  const bool boxes = std::any_of(formats.begin(), formats.end(), [](const auto& f) { return f->needsBoxes(); });
  Scanner scanner(drive, world, formats, options.simulator);
  report.device = scanner.device().name;
  BoxFinder finder(drive, world);
  uint64_t done = 0;
  FrameQueue queue([&](FrameRecord& record) {
    for (RecordedScan& scan : record.scans) {
      if (boxes) scan.boxes = finder.find(scan);
      ++report.scans;
      report.points += scan.points;
    }
    std::vector<OutputFile> files;
    for (const auto& format : formats) format->encode(record, files);
    manifest.write(record, files);
    report.files += files.size();
    for (const OutputFile& file : files) report.bytes += file.bytes.size();
    if (options.progress) options.progress(++done, frames.size());
  });
  for (uint64_t frame : frames) {
    FrameRecord record = queue.empty();
    record.frame = frame;
    scanner.scan(record);
    queue.push(std::move(record));
  }
  queue.finish();
}

}  // namespace

RunReport run(const Drive& drive, const RunOptions& options) {
  check(options);
  const World world(drive);
  Formats formats;
  for (const Output& output : drive.outputs) formats.push_back(makeFormat(drive, world, output));
  const Manifest manifest(drive, options.out);
  RunReport report;
  const std::vector<uint64_t> frames = framesToMake(drive, options, manifest, report);
  if (!frames.empty()) {
    manifest.reopen();
    makeFrames(drive, world, formats, frames, options, manifest, report);
  }
  report.finished = manifest.finish([&](const std::vector<FrameSummary>& summaries) {
    for (const auto& format : formats) format->finish(summaries, options.out);
    writeObjects(drive, world, options.out);
  });
  return report;
}

}  // namespace gnosphere::drive
