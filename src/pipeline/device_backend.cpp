// SPDX-License-Identifier: Apache-2.0
#include "pipeline/device_backend.hpp"

#include <chrono>
#include <deque>

#include "gnosphere/error.hpp"
#include "pipeline/scene_arrays.hpp"
#include "pipeline/sensor_arrays.hpp"

namespace gnosphere {
namespace {

using Clock = std::chrono::steady_clock;

class DeviceBackend final : public Backend {
 public:
  DeviceBackend(std::unique_ptr<Machine> machine, const Scene& scene, const std::vector<Sensor>& sensors,
                const SimulatorOptions& options)
      : plans_(planSensors(scene, sensors, options)),
        machine_(std::move(machine)),
        scene_(*machine_, scene, anyOf(plans_, &SensorPlan::looksAtSurfaces), anyOf(plans_, &SensorPlan::holes)),
        slots_(machine_->framesInFlight()) {
    for (const SensorPlan& plan : plans_) {
      sensors_.emplace_back(*machine_, plan, options, scene_.instances().counters().triangles);
      stills_.emplace_back(sensors_.back().keepsStill());
    }
    machine_->prepared();
    machine_->throwOnMessages();
  }

  // A run that its receiver ended may have left a scan under way.
  ~DeviceBackend() override {
    try {
      waitForAll();
    } catch (const Error&) {  // a device that is lost has nothing under way
    }
  }

  // The next scan is handed to the device before the host waits for this one.
  void scanAll(std::span<const Shot> shots, Scan& result, const std::function<void(size_t)>& receive) override {
    waitForAll();
    if (!shots.empty()) submit(shots, 0);
    for (size_t i = 0; i < shots.size(); ++i) {
      if (slots_.size() > 1 && i + 1 < shots.size()) submit(shots, i + 1);
      finish(shots, i, result);
      machine_->throwOnMessages();
      receive(i);
      if (slots_.size() == 1 && i + 1 < shots.size()) submit(shots, i + 1);
    }
  }

  void setInstance(size_t index, uint32_t mesh, const Transform& transform) override {
    scene_.instances().set(index, mesh, transform);
  }

  void setPositions(size_t mesh, std::span<const float> positions) override {
    waitForAll();
    scene_.setPositions(mesh, positions);
  }

  Plan plan(size_t sensor) const override { return sensors_[sensor].plan(); }
  const DeviceInfo& device() const override { return machine_->traits().info; }
  size_t clusterCount() const override { return scene_.clusterCount(); }
  MemoryUse memory() const override {
    MemoryUse use;
    use.scene = scene_.bytes();
    for (const Slot& slot : slots_) use.scene += slot.placed.bytes();
    for (const SensorArrays& sensor : sensors_) sensor.addTo(use);
    return use;
  }

 private:
  // What a frame in flight has of its own whatever the sensor.
  struct Slot {
    PlacedArrays placed;
    uint64_t reused = 0;  // triangles that the sensor's still image stands for
    Clock::time_point start;
  };

  void waitForAll() {
    for (size_t frame = 0; frame < slots_.size(); ++frame) machine_->wait(frame);
  }

  void submit(std::span<const Shot> shots, size_t i) {
    const size_t frame = i % slots_.size();
    slots_[frame].start = Clock::now();
    run(frame, shots[i]);
  }

  // A still image that another frame makes must be known to have succeeded before it is used.
  StillImage::Use useStill(StillImage& still, SensorArrays& sensor, const Pose& pose) {
    if (still.inMaking()) {
      machine_->wait(still.frame());
      still.end(!sensor.cutShort(still.frame()));
    }
    return still.next(pose, scene_.instances());
  }

  void run(size_t frame, const Shot& shot) {
    Slot& slot = slots_[frame];
    SensorArrays& sensor = sensors_[shot.sensor];
    if (sensor.beams() == 0) return;
    StillImage& still = stills_[shot.sensor];
    const StillImage::Use use = useStill(still, sensor, shot.pose);
    slot.reused = use == StillImage::Use::use ? still.triangles() : 0;
    const std::optional<ShotMotion> motion = motionOf(sensor.sensorPlan(), shot, scene_.instances());
    const Pose& pose = motion ? motion->tables.middle : shot.pose;
    scene_.place(pose, sensor.reach() + reachOf(motion), still.selection(use), slot.placed);
    if (!scene_.listsHold(slot.placed)) {
      waitForAll();
      scene_.growLists(slot.placed);
    }
    BoundArrays arrays = {};
    scene_.bind(arrays);
    slot.placed.bind(arrays);
    const std::vector<Step> steps = sensor.prepare(frame, shot, motion ? &*motion : nullptr, scene_.instances().count(),
                                                   slot.placed.groups(), use, arrays);
    machine_->submit(frame, steps, arrays);
    if (use == StillImage::Use::make) still.begin(frame);
  }

  // Waits for scan i, runs it again for as long as its lists were too small, and reads it. The scan after it may have
  // been cut short as well: that is seen when its turn comes, by the room it had when it was submitted.
  void finish(std::span<const Shot> shots, size_t i, Scan& result) {
    const size_t frame = i % slots_.size();
    SensorArrays& sensor = sensors_[shots[i].sensor];
    clearResult(sensor.sensorPlan(), scene_.instances(), result);
    if (sensor.beams() > 0) {
      machine_->wait(frame);
      while (sensor.cutShort(frame)) {
        waitForAll();
        sensor.growLists(frame);
        run(frame, shots[i]);
        machine_->wait(frame);
        ++result.counters.retries;
      }
      machine_->readTimings(frame, result.timings);
      readResults(sensor.sensorPlan(), sensor.results(frame), scene_.instances(), shots[i], result);
      result.counters.reused = slots_[frame].reused;
      result.counters.culledByCluster -= slots_[frame].reused;
    }
    result.timings.wallMs = std::chrono::duration<double, std::milli>(Clock::now() - slots_[frame].start).count();
  }

  const std::vector<SensorPlan> plans_;  // of every sensor
  std::unique_ptr<Machine> machine_;
  SceneArrays scene_;
  std::deque<SensorArrays> sensors_;
  std::vector<StillImage> stills_;  // of every sensor
  std::vector<Slot> slots_;
};

}  // namespace

std::unique_ptr<Backend> makeDeviceBackend(std::unique_ptr<Machine> machine, const Scene& scene,
                                           const std::vector<Sensor>& sensors, const SimulatorOptions& options) {
  return std::make_unique<DeviceBackend>(std::move(machine), scene, sensors, options);
}

}  // namespace gnosphere
