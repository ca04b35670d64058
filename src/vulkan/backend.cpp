// SPDX-License-Identifier: Apache-2.0
// Scans on a Vulkan device: project, bin, resolve and effects, in one submission each.
#include "pipeline/backend.hpp"

#include <algorithm>
#include <chrono>
#include <deque>
#include <optional>

#include "pipeline/scan_options.hpp"
#include "vulkan/commands.hpp"
#include "vulkan/pipeline_cache.hpp"
#include "vulkan/sensor_parts.hpp"
#include "vulkan/stages.hpp"

namespace gnosphere {
namespace vulkan {
namespace {

using Clock = std::chrono::steady_clock;

class VulkanBackend final : public Backend {
 public:
  VulkanBackend(const Scene& scene, const std::vector<Sensor>& sensors, const SimulatorOptions& options)
      : plans_(planSensors(scene, sensors, options)),
        device_(options.device, options.validation, options.maxBufferBytes),
        cache_(device_, options.cache),
        geometry_(device_, scene, anyOf(plans_, &SensorPlan::looksAtSurfaces), anyOf(plans_, &SensorPlan::holes)),
        cut_(cutToFit(plans_, device_)),
        layout_(device_, cache_.handle(),
                static_cast<uint32_t>(kFramesInFlight * cut_.parts.size() + geometry_.chunks().size()),
                !std::all_of(plans_.begin(), plans_.end(), [](const SensorPlan& plan) { return plan.bare(); })),
        stages_(device_, geometry_, layout_) {
    parts_.reserve(cut_.parts.size());
    for (size_t sensor = 0; sensor < plans_.size(); ++sensor) {
      const SensorPlan& plan = plans_[sensor];
      const uint32_t binning =
          chooseBinning(options, device_.capabilities().int64Atomics, device_.capabilities().cpu, plan);
      stills_.emplace_back(keepsStill(options, binning, plan));
      for (size_t part = cut_.firsts[sensor]; part < cut_.firsts[sensor + 1]; ++part)
        parts_.emplace_back(device_, layout_, geometry_, cut_.parts[part], options, binning, plan,
                            cut_.firstBeams[part], parts_);
    }
    cache_.save();
    slotOf(0);
    device_.throwOnMessages();
  }

  // The next scan is handed to the device before the host waits for this one.
  void scanAll(std::span<const Shot> shots, Scan& result, const std::function<void(size_t)>& receive) override {
    waitForAll();
    if (!shots.empty()) submit(shots, 0);
    for (size_t i = 0; i < shots.size(); ++i) {
      if (i + 1 < shots.size()) submit(shots, i + 1);
      finish(shots, i, result);
      device_.throwOnMessages();
      receive(i);
    }
  }

  void setInstance(size_t index, uint32_t mesh, const Transform& transform) override {
    geometry_.instances().set(index, mesh, transform);
  }

  void setPositions(size_t mesh, std::span<const float> positions) override {
    waitForAll();
    geometry_.setPositions(mesh, positions);
    device_.throwOnMessages();
  }

  Plan plan(size_t sensor) const override {
    Plan plan;
    plan.effects = plans_[sensor].decisions;
    plan.returns = plans_[sensor].returns;
    const SensorState& part = parts_[cut_.firsts[sensor]];
    plan.binning = nameOfBinning(part.binning());
    part.describe(plan);
    stages_.count(plan, part);
    return plan;
  }

  const DeviceInfo& device() const override { return device_.capabilities().info; }
  size_t clusterCount() const override { return geometry_.clusterCount(); }
  MemoryUse memory() const override {
    MemoryUse use;
    use.scene = geometry_.bytes() + visible_.bytes();
    for (const Slot& slot : slots_) use.scene += slot.placed.bytes();
    for (const SensorState& part : parts_) part.addTo(use);
    return use;
  }

 private:
  // What the frames in flight have of their own whatever the sensor.
  struct Slot {
    Slot(const Device& device, const Layout& layout, size_t parts)
        : commands(device, layout, static_cast<uint32_t>(parts) * Stages::kStamps) {}
    Commands commands;
    PlacedInstances placed;
    uint64_t reused = 0;  // triangles that the sensor's still image stands for
    Clock::time_point start;
  };

  // Of scan i of a run; those beyond the first are made when first used.
  Slot& slotOf(size_t i) {
    while (slots_.size() <= i % kFramesInFlight) slots_.emplace_back(device_, layout_, cut_.maxCount());
    return slots_[i % kFramesInFlight];
  }

  std::span<SensorState> partsOf(size_t sensor) {
    return std::span(parts_).subspan(cut_.firsts[sensor], cut_.count(sensor));
  }

  // A run that its receiver ended may have left a scan on its way.
  void waitForAll() {
    for (Slot& slot : slots_) slot.commands.wait();
  }

  void submit(std::span<const Shot> shots, size_t i) {
    Slot& slot = slotOf(i);
    slot.start = Clock::now();
    run(slot, shots[i], i % kFramesInFlight);
  }

  static bool cutShort(std::span<const SensorState> parts, size_t index) {
    return std::any_of(parts.begin(), parts.end(),
                       [&](const SensorState& part) { return part.cutShort(part.inFlight(index)); });
  }

  // A still image that another frame makes must be known to have succeeded before it is used.
  StillImage::Use useStill(StillImage& still, std::span<SensorState> parts, const Pose& pose) {
    if (still.inMaking()) {
      slots_[still.frame()].commands.wait();
      still.end(!cutShort(parts, still.frame()));
    }
    const StillImage::Use use = still.next(pose, geometry_.instances());
    if (use == StillImage::Use::make)
      for (SensorState& part : parts) part.makeStillWords();
    return use;
  }

  // Records the stages in order, part by part, and submits them once.
  void run(Slot& slot, const Shot& shot, size_t index) {
    const std::span<SensorState> parts = partsOf(shot.sensor);
    if (parts[0].frame().beams == 0) return;
    Commands& commands = slot.commands;
    StillImage& still = stills_[shot.sensor];
    const StillImage::Use use = useStill(still, parts, shot.pose);
    slot.reused = use == StillImage::Use::use ? parts.size() * still.triangles() : 0;
    const std::optional<ShotMotion> motion = motionOf(plans_[shot.sensor], shot, geometry_.instances());
    const Pose& pose = motion ? motion->tables.middle : shot.pose;
    geometry_.instances().place(pose, parts[0].reach() + reachOf(motion), still.selection(use), slot.placed);
    if (!visible_.hold(slot.placed)) {
      waitForAll();
      visible_.makeRoomFor(slot.placed, device_);
    }
    commands.begin();
    for (SensorState& part : parts) {
      const FrameInFlight& frame =
          part.prepare(index, shot, motion ? &*motion : nullptr, geometry_.instances().count(), slot.placed, visible_);
      commands.bindSet(0, frame.set);
      stages_.record(commands, part, slot.placed, use);
      readBack(commands, part, frame);
    }
    commands.submit();
    if (use == StillImage::Use::make) still.begin(index);
  }

  // Waits for scan i, runs it again for as long as its lists were too small, and reads it. The scan after it may have
  // been cut short as well: that is seen when its turn comes, by the room it had when it was submitted.
  void finish(std::span<const Shot> shots, size_t i, Scan& result) {
    Slot& slot = slotOf(i);
    const std::span<SensorState> parts = partsOf(shots[i].sensor);
    const SensorPlan& plan = plans_[shots[i].sensor];
    clearResult(plan, parts.size(), geometry_.instances(), result);
    if (const size_t index = i % kFramesInFlight; parts[0].frame().beams > 0) {
      slot.commands.wait();
      while (cutShort(parts, index)) {
        waitForAll();
        for (SensorState& part : parts) part.growLists(part.inFlight(index));
        run(slot, shots[i], index);
        slot.commands.wait();
        ++result.counters.retries;
      }
      slot.commands.readTimings(result.timings);
      uint64_t firstBeam = 0;
      for (const SensorState& part : parts) {
        readResults(plan, part.results(index), geometry_.instances(), shots[i], firstBeam, result);
        firstBeam += part.frame().beams;
      }
      result.counters.reused = slot.reused;
      result.counters.culledByCluster -= slot.reused;
    }
    result.timings.wallMs = std::chrono::duration<double, std::milli>(Clock::now() - slot.start).count();
  }

  void readBack(Commands& commands, const SensorState& state, const FrameInFlight& frame) const {
    if (!state.readsInPlace())
      for (size_t i = 0; i < state.outputs().size(); ++i)
        commands.copy(state.buffer(state.outputs()[i].binding), frame.results[i]);
    commands.copy(state.buffer(gpu::kBindCounters), frame.results.back());
    commands.barrier();
  }

  const std::vector<SensorPlan> plans_;  // of every sensor
  Device device_;
  PipelineCache cache_;
  Geometry geometry_;
  SensorParts cut_;
  Layout layout_;
  Stages stages_;
  std::vector<SensorState> parts_;  // of every sensor, as cut_ has them
  std::vector<StillImage> stills_;  // of every sensor
  VisibleLists visible_;
  std::deque<Slot> slots_;  // last: they wait for the device before what it uses goes
};

}  // namespace
}  // namespace vulkan

std::unique_ptr<Backend> makeVulkanBackend(const Scene& scene, const std::vector<Sensor>& sensors,
                                           const SimulatorOptions& options) {
  return std::make_unique<vulkan::VulkanBackend>(scene, sensors, options);
}

}  // namespace gnosphere
