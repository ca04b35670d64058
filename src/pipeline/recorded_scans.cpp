// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recorded_scans.hpp"

#include <algorithm>
#include <set>
#include <string>
#include <utility>

#include "base/room.hpp"
#include "effects/shot_motion.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere {
namespace {

constexpr uint64_t kAlignment = 16;  // of the addresses of arrays, which the kernels rely on

void check(const Recording::Range& range, uint64_t least, size_t sensor, const char* what) {
  const std::string which = "sensor " + std::to_string(sensor) + ": the buffer for the " + what;
  if (range.address == 0 || range.address % kAlignment != 0)
    throw Error(ErrorCode::invalidArgument, which + " needs an address that is a multiple of 16 and not 0");
  if (range.bytes < least)
    throw Error(ErrorCode::invalidArgument, which + " has " + std::to_string(range.bytes) + " bytes; it needs " +
                                                std::to_string(least) + " or more");
}

}  // namespace

void RecordedScans::replace(size_t sensor, std::shared_ptr<SensorArrays> before) {
  for (Frame& frame : frames_) {
    const auto own = frame.sensors.find(sensor);
    if (own == frame.sensors.end()) continue;
    if (own->second.scans.empty())
      frame.sensors.erase(own);
    else if (!own->second.replaced)
      own->second.replaced = before;
  }
  runs_.erase(sensor);
}

uint64_t RecordedScans::bytes() const {
  uint64_t sum = vertices_.bytes();
  std::set<const SensorArrays*> replaced;
  for (const Frame& frame : frames_) {
    sum += frame.classes.bytes();
    for (const auto& [sensor, own] : frame.sensors) {
      for (const Run& run : own.runs) sum += run.placed.bytes() + run.transforms.bytes();
      if (!own.replaced || !replaced.insert(own.replaced.get()).second) continue;
      MemoryUse use;
      own.replaced->addTo(use);
      sum += use.sensor + use.work;
    }
  }
  return sum;
}

// Reads the counters of the frame's scans. A scan counts as read only when its result is kept, so an exception loses no
// result. Lists that were too small grow, unless the sensor has other arrays since.
void RecordedScans::readResults(Frame& frame, const std::vector<SensorArrays*>& sensors) {
  const auto [nonFinite, degenerate] = scene_.geometry().vertexSources().dropped();
  for (auto& [number, own] : frame.sensors) {
    if (own.scans.empty()) continue;
    SensorArrays& sensor = own.replaced ? *own.replaced : *sensors[number];
    const size_t lastRun = own.scans.back().lastRun;
    if (sensor.choosesShells()) sensor.setShellHint(sensor.recordedHint(own.runs[lastRun].index));
    gnosphere::makeRoom(frame.results, frame.results.size() + own.scans.size());
    for (const Recorded& scan : own.scans) {
      bool complete = true;
      for (size_t run = scan.firstRun; run <= scan.lastRun; ++run)
        complete = complete && !sensor.cutShort(own.runs[run].index);
      frame.results.push_back(
          {number, scan.frame, complete, nonFinite, degenerate, own.runs[scan.firstRun].transforms.unplaced()});
    }
    own.scans.clear();
    if (own.replaced) continue;
    for (const Run& run : std::span(own.runs).first(lastRun + 1)) {
      sensor.learn(run.index);
      if (!sensor.cutShort(run.index)) sensor.noteEnough(run.index, run.views, run.moves);
    }
    for (const Run& run : std::span(own.runs).first(lastRun + 1))
      if (sensor.cutShort(run.index)) sensor.growLists(run.index);
  }
  std::erase_if(frame.sensors, [](const auto& entry) { return entry.second.replaced != nullptr; });
}

// Nothing that this frame has recorded will run. Results that were read before stay.
void RecordedScans::undo(size_t frame) noexcept {
  for (auto& [sensor, own] : frames_[frame].sensors) own.scans.clear();
  vertices_.abandon(frame);
  machine_.abandonRecording(frame);
}

void RecordedScans::abandon(size_t frame) {
  if (order_.empty() || order_.back() != frame) {
    const bool recorded = std::find(order_.begin(), order_.end(), frame) != order_.end();
    throw Error(ErrorCode::invalidArgument,
                "frame " + std::to_string(frame) +
                    (recorded ? " cannot be abandoned before those recorded after it, which build on its commands"
                              : " has no recording that could be abandoned"));
  }
  order_.pop_back();
  undo(frame);
}

// Collects the shots of each sensor, and divides them into parts of at most `mostViews` views. Throws
// Error(invalidArgument) if a sensor or a buffer does not suit.
std::vector<RecordedScans::ShotsOfSensor> RecordedScans::divide(const Recording& recording,
                                                                const std::vector<SensorArrays*>& sensors,
                                                                size_t mostViews) const {
  std::vector<ShotsOfSensor> all;
  for (const Recording::Item& item : recording.scans) {
    const size_t number = item.shot->sensor;
    SensorArrays* const sensor = sensors[number];
    if (!sensor->keepsRecords())
      throw Error(ErrorCode::invalidArgument,
                  "sensor " + std::to_string(number) + " has no layout for records; set SensorRequest::layout");
    check(item.records, 4, number, "records");
    check(item.header, sizeof(RecordHeader), number, "header");
    auto of = std::ranges::find(all, number, &ShotsOfSensor::number);
    if (of == all.end()) of = all.insert(of, {number, sensor, {}, {}, {}});
    of->shots.push_back(*item.shot);
    of->spaces.push_back({{item.records.address, item.header.address}, item.records.bytes});
  }
  for (ShotsOfSensor& of : all) of.parts = partsOf(of.shots, sensors, {scene_, listBytes_, mostViews});
  return all;
}

// Makes room for the views of each part, and for its run in a frame in flight.
void RecordedScans::makeRoom(const std::vector<ShotsOfSensor>& all, Frame& frame) {
  for (const ShotsOfSensor& of : all) {
    SensorScans& own = frame.sensors[of.number];
    gnosphere::makeRoom(own.scans, of.shots.size());
    while (own.runs.size() < of.parts.size()) {
      own.runs.push_back({runs_[of.number]});
      ++runs_[of.number];
    }
    for (const Part& part : of.parts)
      if (const auto views = static_cast<uint32_t>(part.views.size()); !of.sensor->hasRoomForViews(views))
        of.sensor->makeRoomForViews(views);
  }
}

void RecordedScans::record(Recording& recording, const std::vector<SensorArrays*>& sensors) {
  // The caller's transforms are placed for the pose of one view.
  const size_t mostViews = scene_.instances().transformSources().any() ? 1 : kAnyViews;
  std::vector<ShotsOfSensor> all = divide(recording, sensors, mostViews);
  const size_t number = recording.frame;
  if (frames_.size() <= number) frames_.resize(number + 1);
  Frame& frame = frames_[number];
  gnosphere::makeRoom(order_, frames_.size());
  vertices_.readDropped(number);
  readResults(frame, sensors);
  if (recording.makeRoom) recording.makeRoom(frame.results.size());
  try {
    makeRoom(all, frame);
  } catch (const Error& error) {  // without memory for several views, shots are recorded view by view
    if (error.code() != ErrorCode::outOfMemory || mostViews == 1) throw;
    all = divide(recording, sensors, 1);
    makeRoom(all, frame);
  }
  if (std::ranges::any_of(all, [](const ShotsOfSensor& of) { return of.sensor->recordsClasses(); })) {
    const ClassTable::Packed& table = recording.classes->packed();
    frame.classes.load(machine_, gpu::Array::instanceClasses, table.instances);
    frame.classes.load(machine_, gpu::Array::classRuns, table.runs);
    frame.classedInstances = static_cast<uint32_t>(table.instances.size());
  }
  std::erase(order_, number);
  try {
    machine_.beginRecording(recording.commands, recording.ring, number);
    vertices_.record(number);
    for (const ShotsOfSensor& of : all) {
      SensorScans& own = frame.sensors[of.number];
      for (size_t i = 0; i < of.parts.size(); ++i) {
        const Part& part = of.parts[i];
        record(frame, of, part, own.runs[i]);
        recording.mayOverflow |= !of.sensor->hadEnough(own.runs[i].views, own.runs[i].moves);
        for (const Shot& shot : part.shots) {
          if (part.first)
            own.scans.push_back({shot.frame, i, i});
          else
            own.scans.back().lastRun = i;
        }
      }
    }
    machine_.endRecording();
  } catch (...) {
    undo(number);
    throw;
  }
  order_.push_back(number);
  recording.results = std::exchange(frame.results, {});
}

// Records the stages for the views of a part. The last part of a shot ends with the shot's records.
void RecordedScans::record(const Frame& frame, const ShotsOfSensor& of, const Part& part, Run& run) {
  SensorArrays& sensor = *of.sensor;
  if (!run.addresses) run.addresses = machine_.allocate("addresses", sizeof(gpu::Addresses), MemoryKind::upload);
  std::vector<Shot> copies;
  const std::span<const Shot> shots = shotsOfViews(part, copies);
  const std::vector<ShotMotion> motions = motionsOf(sensor.sensorPlan(), part.views, shots, scene_);
  run.views = part.views.size();
  run.moves = std::ranges::any_of(motions, &ShotMotion::moves);
  const InstanceEntries instances = placeViews(scene_, sensor, shots, motions, {}, run.placed);
  if (!scene_.listsHold(run.placed)) scene_.growLists(run.placed);
  BoundArrays arrays = {};
  scene_.bind(arrays);
  run.placed.bind(arrays);
  sensor.loadRecords(run.index, part.shots, std::span(of.spaces).subspan(part.index, part.shots.size()),
                     frame.classedInstances, !part.first);
  std::vector<Step> steps = run.transforms.steps(machine_, scene_.instances(), seenFrom(shots, 0, motions), arrays);
  for (const Step& step : sensor.prepare(run.index, shots, part.views, part.last, motions, instances,
                                         run.placed.groups(), StillImage::Use::none, arrays))
    steps.push_back(step);
  if (sensor.recordsClasses()) frame.classes.bind(arrays);
  machine_.record(*run.addresses, steps, arrays);
}

}  // namespace gnosphere
