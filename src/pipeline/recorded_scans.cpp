// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recorded_scans.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "base/room.hpp"
#include "effects/shot_motion.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere {
namespace {

constexpr uint64_t kAlignment = 16;  // of the addresses of arrays, which the kernels rely on

// Memory of the caller: kernels write it, and the host never looks at it.
class CallerMemory final : public DeviceMemory {
 public:
  explicit CallerMemory(const Recording::Range& range) : range_(range) {}
  uint64_t bytes() const override { return range_.bytes; }
  uint64_t address() const override { return range_.address; }
  void* host() override { return nullptr; }
  void flush() override {}
  void invalidate() override {}
  void write(uint64_t, std::span<const std::byte>) override {}
  void read(uint64_t, std::span<std::byte>) const override {}

 private:
  Recording::Range range_;
};

// The number under which the sensor's arrays know a group's run in a frame in flight.
size_t indexOf(const SensorArrays& sensor, size_t frame, size_t group) {
  return frame * sensor.mostGroups() + group;
}

void check(const Recording::Range& range, uint64_t least, size_t sensor, const char* what) {
  const std::string which = "sensor " + std::to_string(sensor) + ": the buffer for the " + what;
  if (range.address == 0 || range.address % kAlignment != 0)
    throw Error(ErrorCode::invalidArgument, which + " needs an address that is a multiple of 16 and not 0");
  if (range.bytes < least)
    throw Error(ErrorCode::invalidArgument, which + " has " + std::to_string(range.bytes) + " bytes; it needs " +
                                                std::to_string(least) + " or more");
}

}  // namespace

void RecordedScans::forget(size_t sensor) {
  for (Slots& slots : frames_) slots.erase(sensor);
}

uint64_t RecordedScans::bytes() const {
  uint64_t sum = vertices_.bytes();
  for (const Slots& slots : frames_)
    for (const auto& [sensor, slot] : slots)
      for (const Run& run : slot.runs) sum += run.placed.bytes() + run.transforms.bytes();
  return sum;
}

// Reads the counters of the frame's scans. A scan counts as read only when its result is kept, so an exception loses no
// result.
void RecordedScans::readResults(size_t frame, const std::vector<SensorArrays*>& sensors) {
  const auto [nonFinite, degenerate] = scene_.geometry().vertexSources().dropped();
  for (auto& [index, slot] : frames_[frame]) {
    if (!slot.recorded) continue;
    SensorArrays& sensor = *sensors[index];
    const size_t groups = sensor.groups(slot.frame).size();
    if (sensor.choosesShells()) sensor.setShellHint(sensor.recordedHint(indexOf(sensor, frame, groups - 1)));
    bool complete = true;
    for (size_t group = 0; group < groups; ++group)
      complete = complete && !sensor.cutShort(indexOf(sensor, frame, group));
    results_[frame].push_back({index, slot.frame, complete, nonFinite, degenerate, slot.runs[0].transforms.unplaced()});
    slot.recorded = false;
    for (size_t group = 0; group < groups; ++group)
      if (const size_t run = indexOf(sensor, frame, group); sensor.cutShort(run)) sensor.growLists(run);
  }
}

// Nothing that this frame has recorded will run. Results that were read before stay.
void RecordedScans::undo(size_t frame) noexcept {
  for (auto& [index, slot] : frames_[frame]) slot.recorded = false;
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

void RecordedScans::record(Recording& recording, const std::vector<SensorArrays*>& sensors) {
  std::vector<size_t> indices;
  for (const Recording::Item& item : recording.scans) {
    const size_t index = item.shot->sensor;
    if (!sensors[index]->keepsRecords())
      throw Error(ErrorCode::invalidArgument,
                  "sensor " + std::to_string(index) + " has no layout for records; set SensorRequest::layout");
    if (std::find(indices.begin(), indices.end(), index) != indices.end())
      throw Error(ErrorCode::invalidArgument,
                  "sensor " + std::to_string(index) + " occurs twice in one recording; add a second sensor like it");
    indices.push_back(index);
    check(item.records, 4, index, "records");
    check(item.header, sizeof(RecordHeader), index, "header");
  }
  const size_t frame = recording.frame;
  if (results_.size() <= frame) results_.resize(frame + 1);
  if (frames_.size() <= frame) frames_.resize(frame + 1);
  gnosphere::makeRoom(order_, frames_.size());
  vertices_.readDropped(frame);
  readResults(frame, sensors);
  std::erase(order_, frame);
  try {
    machine_.beginRecording(recording.commands, frame);
    vertices_.record(frame);
    for (const Recording::Item& item : recording.scans) record(recording, item, *sensors[item.shot->sensor]);
    machine_.endRecording();
  } catch (...) {
    undo(frame);
    throw;
  }
  order_.push_back(frame);
  recording.results = std::exchange(results_[frame], {});
}

void RecordedScans::record(const Recording& recording, const Recording::Item& item, SensorArrays& sensor) {
  const Shot& shot = *item.shot;
  Slot& slot = frames_[recording.frame][shot.sensor];
  const size_t groups = sensor.groups(shot.frame).size();
  if (slot.runs.size() < groups) slot.runs.resize(groups);
  for (size_t group = 0; group < groups; ++group) record(recording, item, sensor, group, slot.runs[group]);
  slot.frame = shot.frame;
  slot.recorded = true;
}

// Records the stages for one group of the beams. The last group's run ends with the records of all.
void RecordedScans::record(const Recording& recording, const Recording::Item& item, SensorArrays& sensor, size_t group,
                           Run& run) {
  const Shot& shot = *item.shot;
  const size_t index = indexOf(sensor, recording.frame, group);
  if (!run.addresses) run.addresses = machine_.allocate("addresses", sizeof(gpu::Addresses), MemoryKind::upload);
  const std::span<const BeamGroup> groups = sensor.groups(shot.frame);
  const View view = {0, &groups[group]};
  const std::optional<ShotMotion> motion =
      motionOf(sensor.sensorPlan(), view.group->lasers, shot, scene_.instances(), scene_.geometry().deformables());
  const ShotMotions motions = motion ? ShotMotions(&*motion, 1) : ShotMotions();
  const Pose pose = seenFrom({&shot, 1}, 0, motions);
  scene_.place(pose, sensor.reach() + reachOf(motions), {.ignored = sensor.sensorPlan().ignored, .world = shot.world},
               run.placed);
  if (!scene_.listsHold(run.placed)) scene_.growLists(run.placed);
  CallerMemory records(item.records), header(item.header);
  BoundArrays arrays = {};
  scene_.bind(arrays);
  run.placed.bind(arrays);
  sensor.loadRecords(index, group, item.records.bytes, *recording.classes, shot.frame);
  std::vector<Step> steps = run.transforms.steps(machine_, scene_.instances(), pose, arrays);
  for (const Step& step :
       sensor.prepare(index, {&shot, 1}, {&view, 1}, group + 1 == groups.size(), motions, {scene_.instances().count()},
                      run.placed.groups(), StillImage::Use::none, arrays))
    steps.push_back(step);
  arrays[static_cast<size_t>(gpu::Array::records)] = &records;
  arrays[static_cast<size_t>(gpu::Array::recordHeader)] = &header;
  machine_.record(*run.addresses, steps, arrays);
}

}  // namespace gnosphere
