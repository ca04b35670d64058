// SPDX-License-Identifier: Apache-2.0
#include "drive/run.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "base/json_text.hpp"
#include "drive/formats/format.hpp"
#include "drive/frame_queue.hpp"
#include "drive/made_by.hpp"
#include "drive/manifest.hpp"
#include "drive/scanner.hpp"

namespace gnosphere::drive {
namespace {

using Formats = std::vector<std::unique_ptr<Format>>;

/// By sensor, the fields that the formats write of it.
std::vector<std::set<Field>> fieldsOf(const Drive& drive, const Formats& formats) {
  std::vector<std::set<Field>> fields(drive.sensors.size());
  for (size_t s = 0; s < fields.size(); ++s)
    for (const auto& format : formats)
      if (format->writes(s))
        for (Field field : format->fields()) fields[s].insert(field);
  return fields;
}

void check(const Drive& drive, const RunOptions& options) {
  const auto refuse = [](const std::string& text) { throw Error(ErrorCode::invalidArgument, "RunOptions: " + text); };
  if (options.shard >= options.shardCount)
    refuse("there is no shard " + std::to_string(options.shard) + " of " + std::to_string(options.shardCount) +
           "; N shards are numbered from 0 to N - 1");
  if (options.firstFrame >= options.endFrame)
    refuse("the first frame is " + std::to_string(options.firstFrame) + "; it must be less than the end, " +
           std::to_string(options.endFrame));
  if (const std::string why = mistakeOfFrames(drive, options.firstFrame, options.endFrame); !why.empty()) refuse(why);
  // The same drive gives the same bytes, whoever runs it.
  const auto mustBeOfDrive = [&](bool given, const char* what) {
    if (given) refuse(std::string("simulator: ") + what + " changes the clouds, so it belongs into the drive file");
  };
  const SimulatorOptions usual;
  const SimulatorOptions& own = options.simulator;
  mustBeOfDrive(own.accuracy != usual.accuracy || own.accuracyParts, "accuracy");
  mustBeOfDrive(own.faces != usual.faces, "faces");
  mustBeOfDrive(!own.materials.rows.empty(), "a material table");
}

std::vector<uint64_t> framesToMake(const Drive& drive, const RunOptions& options, const Manifest& manifest,
                                   RunReport& report) {
  std::vector<uint64_t> frames;
  for (uint64_t f = options.firstFrame; f < std::min(options.endFrame, drive.frameCount()); ++f) {
    if (f % options.shardCount != options.shard) continue;
    ++report.chosen;
    if (manifest.summaryOf(f, options.verify))
      ++report.kept;
    else
      frames.push_back(f);
  }
  return frames;
}

/// Writes the numbers of objects and classes, for whoever reads labels.
void writeObjects(const Drive& drive, const World& world, FinalFiles& files) {
  nlohmann::ordered_json objects = nlohmann::ordered_json::array();
  const std::vector<Instance>& instances = world.scene().instances;
  for (size_t i = 0; i < instances.size(); ++i) {
    if (world.objectOf(i) != i) continue;
    const std::optional<size_t> actor = world.actorOf(static_cast<uint32_t>(i));
    objects.push_back(
        {{"object", i}, {"name", instances[i].name}, {"class_id", instances[i].classId}, {"actor", actor.has_value()}});
    if (actor) objects.back()["label"] = World::labelOfActor(*actor);
  }
  std::string text = "[\n";
  for (size_t i = 0; i < objects.size(); ++i) text += jsonText(objects[i]) + (i + 1 < objects.size() ? ",\n" : "\n");
  files.write("objects.json", text + "]\n");
  nlohmann::ordered_json classes = nlohmann::ordered_json::object();
  for (const Class& category : drive.classes) classes[category.name] = category.id;
  // A number that actors have only while they move gets SemanticKITTI's kind of name, unless a class has that name.
  for (const Class& category : drive.classes)
    if (std::ranges::find(drive.classes, category.movingId, &Class::id) == drive.classes.end())
      classes.emplace("moving-" + category.name, category.movingId);
  files.write("classes.json", jsonText(classes, 1) + "\n");
}

/// Makes frames: this thread scans, another one finds boxes and writes.
void makeFrames(const Drive& drive, const World& world, const Formats& formats, const std::vector<uint64_t>& frames,
                const RunOptions& options, const Manifest& manifest, RunReport& report) {
  const bool boxes = std::ranges::any_of(formats, [](const auto&f) { return f->needsBoxes(); }),
             missed = std::ranges::any_of(formats, [](const auto&f) { return f->needsMissed(); });
  Scanner scanner(drive, world, fieldsOf(drive, formats), options.simulator);
  report.device = scanner.device().name;
  if (options.started) options.started(scanner.device());
  manifest.begin(madeByText(drive, options.simulator, scanner));  // a device that cannot scan leaves the folder alone
  if (!manifest.hasLocks() && options.simulator.warn)
    options.simulator.warn(options.out.string() +
                           ": its file system has no locks (flock), so two processes that complete the drive at the "
                           "same time may spoil its last files, and what killed processes leave stays; let one "
                           "process at a time make the drive there");
  BoxFinder finder(drive, world);
  uint64_t done = 0;
  FrameQueue queue([&](FrameRecord& record) {
    for (RecordedScan& scan : record.scans) {
      if (boxes) scan.boxes = finder.find(scan);
      if (missed) scan.missed = finder.findMissed(scan);
      ++report.scans;
      report.points += scan.points;
      report.counters += scan.scan.counters;
    }
    std::vector<OutputFile> files;
    for (const auto& format : formats) format->encode(record, files);
    manifest.write(record, files);
    report.files += files.size();
    for (const OutputFile& file : files) report.bytes += file.bytes.size();
    if (options.progress) options.progress(++done, frames.size());
  });
  queue.run(frames, [&](FrameRecord& record) {
    if (options.beforeFrame) options.beforeFrame();
    scanner.scan(record);
  });
}

}  // namespace

std::string mistakeOfFrames(const Drive& drive, uint64_t first, uint64_t end) {
  if (first < drive.frameCount()) return "";
  const std::string last = end == UINT64_MAX ? "" : std::to_string(end);
  return "the drive has the frames 0 to " + std::to_string(drive.frameCount() - 1) + ", so " + std::to_string(first) +
         ":" + last + " is none";
}

RunReport run(const Drive& drive, const RunOptions& options) {
  check(drive, options);
  const World world(drive);
  Formats formats;
  for (const Output& output : drive.outputs) formats.push_back(formatNamed(output.format).make(drive, world, output));
  const Manifest manifest(drive, options.out);
  RunReport report;
  report.broken = manifest.removeBroken(options.verify);
  const std::vector<uint64_t> frames = framesToMake(drive, options, manifest, report);
  if (!frames.empty()) makeFrames(drive, world, formats, frames, options, manifest, report);
  const MissingFrames missing = manifest.finish([&](const std::vector<FrameSummary>& summaries, FinalFiles& files) {
    for (const auto& format : formats) format->finish(summaries, files);
    writeObjects(drive, world, files);
  });
  report.finished = missing.count == 0;
  report.missing = missing.count;
  report.firstMissing = missing.first;
  return report;
}

}  // namespace gnosphere::drive
