// SPDX-License-Identifier: Apache-2.0
#include "pipeline/device_backend.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "common/limits.h"
#include "gnosphere/error.hpp"
#include "pipeline/dry_machine.hpp"
#include "pipeline/record_tables.hpp"
#include "pipeline/recorded_scans.hpp"
#include "pipeline/submissions.hpp"

namespace gnosphere {
namespace {

// Returns the range in metres within which kHintPercent per cent of a sample of the returns lie. The range of a sample
// that is too small is 0.
float shellHintOf(const Scan& scan) {
  std::vector<float> ranges;
  ranges.reserve(size_t{2} * gpu::kHintSamples);
  // An odd step meets all columns of a grid.
  for (size_t i = 0; i < scan.ranges.size(); i += scan.ranges.size() / gpu::kHintSamples | 1)
    if (scan.ranges[i] > 0) ranges.push_back(scan.ranges[i]);
  if (ranges.size() < gpu::kHintReturns) return 0;
  const auto at = ranges.begin() + static_cast<ptrdiff_t>(ranges.size() * gpu::kHintPercent / 100);
  std::nth_element(ranges.begin(), at, ranges.end());
  return *at;
}

class DeviceBackend final : public Backend {
 public:
  DeviceBackend(std::unique_ptr<Machine> machine, const Scene& scene, const SensorPlans& sensors,
                const SimulatorOptions& options)
      : options_(options),
        machine_(std::move(machine)),
        materials_(scene.materials),
        scene_(*machine_),
        slots_(machine_->slots()),
        recorded_(*machine_, scene_, mostListBytes(options_, machine_->traits())) {
    scene_.geometry().add(scene.meshes, materials_);
    for (size_t i = 0; i < scene.instances.size(); ++i)
      setInstance(i, scene.instances[i].mesh, scene.instances[i].transform, scene.instances[i].world);
    for (size_t i = 0; i < sensors.size(); ++i) setSensor(i, sensors[i]);
  }

  // An exception of `receive` may have ended a run while a scan was still running.
  ~DeviceBackend() override {
    try {
      waitForAll();
    } catch (...) {  // a lost device runs nothing
    }
  }

  void scanAll(std::span<const Shot> shots, Scan& result, const std::function<void(size_t)>& receive) override {
    scanTo(shots, {result, {}, receive, false});
  }

  bool scanInto(std::span<const Shot> shots, const Places& places, Scan& sum,
                const std::function<void(size_t)>& receive) override {
    if (shots.empty() || !sensors_[shots[0].sensor]->arrays.leavesHitsAlone()) return false;
    scanTo(shots, {sum, places, receive, true});
    return true;
  }

  void record(Recording& recording) override {
    setDeformed(scene_.deformed());
    followScene();
    recorded_.record(recording, sensorArrays());
    try {
      machine_->throwOnMessages();
    } catch (...) {
      recorded_.abandon(recording.frame);
      throw;
    }
  }

  void abandon(size_t frame) override { recorded_.abandon(frame); }

  std::unique_ptr<ResultRing> makeRing(size_t buffers, uint64_t bytes, uint64_t hostBytes) override {
    return machine_->makeRing(buffers, bytes, hostBytes);
  }

  void setSensor(size_t index, std::shared_ptr<const SensorPlan> plan) override {
    waitForAll();
    std::shared_ptr<SensorState> sensor;
    const std::shared_ptr<SensorState> before = index < sensors_.size() ? sensors_[index] : nullptr;
    if (plan) {
      if (!plan->layout.empty()) checkLayout(*plan);
      if (plan->surfaces() || plan->speeds()) scene_.geometry().addSlots();
      if (plan->holes()) scene_.geometry().addTextureCoordinates();
      sensor = std::make_shared<SensorState>(*machine_, std::move(plan), options_, scene_.instances().mostTriangles(),
                                             scene_.deformed());
      if (before && sensor->arrays.keepsRecords()) growListsAs(before->arrays, sensor->arrays);
      machine_->prepared();
    }
    machine_->throwOnMessages();
    sensors_.resize(std::max(sensors_.size(), index + 1));
    if (before) recorded_.replace(index, {before, &before->arrays});
    sensors_[index] = std::move(sensor);
  }

  void setOptics(size_t sensor, std::shared_ptr<const SensorPlan> plan) override {
    waitForAll();
    sensors_[sensor]->still.forget();  // a surface may have become a pane
    sensors_[sensor]->arrays.setOptics(plan->optics);
  }

  void setMaterials(const std::vector<Material>& materials, const std::vector<AlphaImage>&) override {
    auto copy = materials;
    materials_.swap(copy);
  }

  void setMesh(size_t index, const Mesh* mesh) override {
    waitForAll();
    PackedGeometry& geometry = scene_.geometry();
    // The sensors compile what they need for a deformable mesh before there is one.
    if (mesh && mesh->deformable()) setDeformed(true);
    if (!mesh)
      geometry.remove(index);
    else if (index == geometry.meshCount())
      geometry.add({mesh, 1}, materials_);
    else
      geometry.replace(index, *mesh, materials_);
  }

  void setInstance(size_t index, uint32_t mesh, const Transform& transform, uint32_t world) override {
    scene_.instances().set(index, mesh, transform, world);
  }

  void moveInstances(std::span<const uint32_t> instances, std::span<const Transform> transforms) override {
    scene_.instances().move(instances, transforms);
  }

  void setPositions(size_t mesh, std::span<const float> positions) override {
    waitForAll();
    scene_.geometry().setPositions(mesh, positions);
  }

  void setDeformation(size_t mesh, const Deformation& deformation) override {
    waitForAll();
    scene_.geometry().setDeformation(mesh, deformation);
  }

  void setVertices(size_t mesh, const CallerVertices& buffer) override {
    recorded_.takeVertices();
    scene_.geometry().setVertices(mesh, buffer);
    machine_->throwOnMessages();
  }

  void setTransforms(const CallerTransforms& buffer) override {
    recorded_.takeTransforms();
    scene_.instances().setTransforms(buffer);
    machine_->throwOnMessages();
  }

  Plan plan(size_t sensor) const override {
    followScene();
    return sensors_[sensor]->arrays.plan();
  }
  Plan planOf(std::shared_ptr<const SensorPlan> plan, size_t views) const override {
    DryMachine machine(*machine_, options_.compileOnly);
    SensorArrays arrays(machine, *plan, options_, scene_.instances().mostTriangles(), scene_.deformed());
    return arrays.planOf(views);
  }
  const DeviceInfo& device() const override { return machine_->traits().info; }
  size_t clusterCount() const override { return scene_.geometry().clusterCount(); }
  MemoryUse memory() const override {
    MemoryUse use;
    use.scene = scene_.bytes();
    for (const Slot& slot : slots_) use.scene += slot.placed.bytes();
    use.scene += recorded_.bytes();
    for (const auto& sensor : sensors_)
      if (sensor) sensor->arrays.addTo(use);
    return use;
  }

 private:
  struct SensorState {
    SensorState(Machine& machine, std::shared_ptr<const SensorPlan> sensorPlan, const SimulatorOptions& options,
                uint64_t triangles, bool deformed)
        : plan(std::move(sensorPlan)),
          arrays(machine, *plan, options, triangles, deformed),
          still(arrays.keepsStill()) {}
    std::shared_ptr<const SensorPlan> plan;
    SensorArrays arrays;
    StillImage still;
  };

  // The data of a submission in flight that do not depend on the sensor.
  struct Slot {
    PlacedArrays placed;
    uint64_t reused = 0;              // number of triangles that the still image replaces
    std::vector<ShotMotion> motions;  // of the shots that are scanned
    Clock::time_point start;
  };

  // Where scans go: each to `scan`, or all of them to the places of a batch, with their sums in `scan`.
  struct Destination {
    Scan& scan;
    Places places;
    std::function<void(size_t)> receive;
    bool batch;
  };

  // If there is no memory for several views, the shots that are left are scanned one by one.
  void scanTo(std::span<const Shot> shots, const Destination& to) {
    size_t received = 0;
    bool receiving = false;
    Destination counted = to;
    counted.receive = [&](size_t i) {
      receiving = true;
      to.receive(i);
      receiving = false;
      ++received;
    };
    const std::vector<Part> parts = partsOf(shots, kAnyViews);
    const auto hasViews = [](const Part& part) { return part.views.size() > 1; };
    try {
      scanParts(parts, counted);
    } catch (const Error& error) {
      const bool together = std::any_of(parts.begin(), parts.end(), hasViews);
      if (receiving || error.code() != ErrorCode::outOfMemory || !together) throw;
      std::vector<Part> alone = partsOf(shots.subspan(received), 1);
      for (Part& part : alone) part.index += received;
      scanParts(alone, to);
    }
  }

  // Without memory for as large lists, the next scans make those that they need.
  static void growListsAs(const SensorArrays& before, SensorArrays& arrays) {
    try {
      arrays.growListsAs(before);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::outOfMemory) throw;
    }
  }

  void setDeformed(bool deformed) {
    for (const auto& sensor : sensors_)
      if (sensor) sensor->arrays.setDeformed(deformed);
  }

  // Tells the sensors how many triangles have come into the scene, or gone, since the last scan.
  void followScene() const {
    const InstanceTable& instances = scene_.instances();
    if (followed_ == instances.renumberedAt()) return;
    followed_ = instances.renumberedAt();
    const uint64_t triangles = instances.mostTriangles();
    for (const auto& sensor : sensors_)
      if (sensor) sensor->arrays.setTriangles(triangles);
  }

  std::vector<Part> partsOf(std::span<const Shot> shots, size_t mostViews) const {
    return gnosphere::partsOf(shots, sensorArrays(), {scene_, mostListBytes(options_, machine_->traits()), mostViews});
  }

  std::vector<SensorArrays*> sensorArrays() const {
    std::vector<SensorArrays*> arrays;
    for (const auto& sensor : sensors_) arrays.push_back(sensor ? &sensor->arrays : nullptr);
    return arrays;
  }

  // Submits the next part of a scan, or the next scan, to the device before waiting for the current one.
  void scanParts(const std::vector<Part>& parts, const Destination& to) {
    waitForAll();
    setDeformed(scene_.deformed());
    followScene();
    machine_->timeWork(parts.size() > 1 && !to.batch);
    if (!parts.empty()) submit(parts, 0);
    for (size_t i = 0; i < parts.size(); ++i) {
      if (slots_.size() > 1 && i + 1 < parts.size()) submit(parts, i + 1);
      finish(parts, i, to);
      if (slots_.size() == 1 && i + 1 < parts.size()) submit(parts, i + 1);
    }
  }

  // Scans of several views have slots of their own in the arrays of a sensor, because their arrays are larger.
  size_t sensorSlot(size_t slot, const Part& part) const { return part.views.size() > 1 ? slots_.size() + slot : slot; }

  void waitForAll() {
    for (size_t slot = 0; slot < slots_.size(); ++slot) machine_->wait(slot);
  }

  void submit(std::span<const Part> parts, size_t i) {
    const size_t slot = i % slots_.size();
    slots_[slot].start = Clock::now();
    run(slot, parts[i]);
  }

  // Decides how the scan uses the still image. If another slot is making the image, waits until it is known to be
  // valid.
  StillImage::Use useStill(StillImage& still, SensorArrays& sensor, const Shot& shot, bool forgets) {
    if (still.inMaking()) {
      machine_->wait(still.slot());
      still.end(!sensor.cutShort(still.slot()));
    }
    if (!forgets) return still.next(shot, scene_.instances());
    still.forget();
    return StillImage::Use::none;
  }

  void run(size_t slot, const Part& part) {
    auto& [placed, reused, motions, start] = slots_[slot];
    SensorArrays& sensor = sensors_[part.shots[0].sensor]->arrays;
    if (sensor.beams() == 0) return;
    const auto views = static_cast<uint32_t>(part.views.size());
    std::vector<Shot> copies;
    const std::span<const Shot> shots = shotsOfViews(part, copies);
    StillImage& still = sensors_[shots[0].sensor]->still;
    if (!sensor.hasRoomForViews(views)) {
      waitForAll();
      still.forget();  // it needs the farthest-range table, which is made anew
      sensor.makeRoomForViews(views);
    }
    motions = motionsOf(sensor.sensorPlan(), part.views, shots, scene_);
    // A submission of several views, or with motion, overwrites the farthest-range table that the still image needs.
    const bool forgets = views > 1 || (!motions.empty() && motions[0].moves);
    const StillImage::Use use = useStill(still, sensor, shots[0], forgets);
    reused = use == StillImage::Use::use ? still.triangles() : 0;
    const InstanceEntries instances = placeViews(scene_, sensor, shots, motions, still.selection(use), placed);
    if (!scene_.listsHold(placed)) {
      waitForAll();
      scene_.growLists(placed);
    }
    BoundArrays arrays = {};
    scene_.bind(arrays);
    placed.bind(arrays);
    const std::vector<Step> steps = sensor.prepare(sensorSlot(slot, part), shots, part.views, part.last, motions,
                                                   instances, placed.groups(), use, arrays);
    const Clock::duration before = machine_->compiling();
    machine_->submit(slot, steps, arrays);
    start += machine_->compiling() - before;
    if (use == StillImage::Use::make) still.begin(slot);
  }

  // Waits for part i, repeats it while its lists were too small, and reads its results. If the part after it was cut
  // short too, that is found out in its own turn from the capacities it was submitted with.
  void finish(std::span<const Part> parts, size_t i, const Destination& to) {
    const size_t slot = i % slots_.size();
    const Part& part = parts[i];
    SensorArrays& sensor = sensors_[part.shots[0].sensor]->arrays;
    const size_t ofSensor = sensorSlot(slot, part);
    Scan& result = to.scan;
    if (part.first) {
      start_ = slots_[slot].start;
      workMs_ = 0;
    }
    uint64_t retries = 0;
    Timings timings;
    if (sensor.beams() > 0) {
      retries = repeatWhileCutShort(part, slot, ofSensor);
      machine_->readTimings(slot, timings);
      workMs_ += machine_->workMs(slot);
    }
    machine_->throwOnMessages();
    if (to.batch) {
      for (const StageTime& stage : timings.stages) result.timings.add(stage.name, stage.ms);
      result.timings.gpuMs += timings.gpuMs;
      result.counters.retries += retries;
      finishBatch(part, slot, ofSensor, to);
    } else {
      finishShots(part, slot, ofSensor, timings, retries, to);
    }
  }

  // Waits for a part, repeats it while its lists were too small, and returns how often.
  uint64_t repeatWhileCutShort(const Part& part, size_t slot, size_t ofSensor) {
    SensorArrays& sensor = sensors_[part.shots[0].sensor]->arrays;
    machine_->wait(slot);
    sensor.checkAlive(ofSensor);
    uint64_t retries = 0;
    for (; sensor.cutShort(ofSensor); ++retries) {
      waitForAll();
      sensor.growLists(ofSensor);
      run(slot, part);
      machine_->wait(slot);
      sensor.checkAlive(ofSensor);
    }
    sensor.learn(ofSensor);
    return retries;
  }

  // Reads the results of a part whose shots have scans of their own, and hands over the scans that it completes.
  void finishShots(const Part& part, size_t slot, size_t ofSensor, const Timings& timings, uint64_t retries,
                   const Destination& to) {
    SensorArrays& sensor = sensors_[part.shots[0].sensor]->arrays;
    const size_t views = part.views.size();
    Scan& result = to.scan;
    // The device may have worked while a receiver took its time.
    const double waited = std::max(millisecondsSince(start_), workMs_) / static_cast<double>(part.shots.size());
    Clock::time_point start;  // of reading a shot's results
    const auto usable = [&](const View& view) {
      return scene_.instances().contentOf(part.shots[view.shot].world).usableTriangles();
    };
    uint64_t triangles = 0;  // of the views that are left
    for (const View& view : part.views) triangles += usable(view);
    gpu::Counters counters = {};  // of these views
    if (sensor.beams() > 0) counters = sensor.counters(ofSensor);
    for (size_t view = 0; view < views; ++view) {
      const size_t number = part.views[view].shot;
      const Shot& shot = part.shots[number];
      const bool comesFirst = view == 0 || part.views[view - 1].shot != number;
      if (comesFirst) start = Clock::now();
      if (comesFirst && (view > 0 || part.first))
        clearResult(sensor.sensorPlan(), scene_.instances(), shot.world, result);
      else
        countPlaced(scene_.instances(), shot.world, result.counters);
      for (const StageTime& stage : timings.stages)
        result.timings.add(stage.name, stage.ms / static_cast<double>(views));
      result.timings.gpuMs += timings.gpuMs / static_cast<double>(views);
      if (sensor.beams() > 0) {
        const uint64_t own = usable(part.views[view]);
        const gpu::Counters share = takeShare(counters, own, std::exchange(triangles, triangles - own));
        DeviceResults results = sensor.results(ofSensor, static_cast<uint32_t>(view), share);
        if (views > 1) results.inViews = slots_[slot].placed.inViews();
        readResults(workers_, sensor.sensorPlan(), results, scene_.instances(), shot,
                    motionOf(slots_[slot].motions, view), result);
        result.counters.reused = slots_[slot].reused;
        result.counters.culledByCluster -= slots_[slot].reused;
        if (view == 0) result.counters.retries += retries;
      }
      if (view + 1 == views ? !part.last : part.views[view + 1].shot == number) continue;
      if (sensor.choosesShells() && sensor.beams() > 0) sensor.setShellHint(shellHintOf(result));
      result.timings.wallMs = std::max(waited + millisecondsSince(start), result.timings.gpuMs);
      hand(part.index + number, to);
    }
  }

  /// Hands a scan to its receiver. The time of the receiver does not count as time of the scans in flight, although the
  /// device may work on these scans meanwhile.
  void hand(size_t number, const Destination& to) {
    const Clock::time_point before = Clock::now();
    to.receive(number);
    const Clock::duration outside = Clock::now() - before;
    for (Slot& slot : slots_) slot.start += outside;
    start_ += outside;
  }

  void finishBatch(const Part& part, size_t slot, size_t ofSensor, const Destination& to) {
    SensorArrays& sensor = sensors_[part.shots[0].sensor]->arrays;
    if (sensor.beams() > 0) {
      readHits(workers_, sensor.sensorPlan(), sensor.results(ofSensor), scene_.instances(), part.shots,
               slots_[slot].motions, to.places.from(part.index * sensor.sensorPlan().sensor.beamCount()), to.scan);
      to.scan.counters.reused += slots_[slot].reused;
      to.scan.counters.culledByCluster -= slots_[slot].reused;
    }
    for (size_t view = 0; view < part.shots.size(); ++view) to.receive(part.index + view);
  }

  const SimulatorOptions options_;
  std::unique_ptr<Machine> machine_;
  std::vector<Material> materials_;
  SceneArrays scene_;
  std::vector<std::shared_ptr<SensorState>> sensors_;  // null for a removed sensor
  std::vector<Slot> slots_;
  mutable uint64_t followed_ = 0;  // InstanceTable::renumberedAt() of the scene that the sensors know
  Clock::time_point start_;        // of the scan that is being finished
  double workMs_ = 0;              // of the device on this scan
  Workers workers_;
  RecordedScans recorded_;
};

}  // namespace

std::unique_ptr<Backend> makeDeviceBackend(std::unique_ptr<Machine> machine, const Scene& scene,
                                           const SensorPlans& sensors, const SimulatorOptions& options) {
  return std::make_unique<DeviceBackend>(std::move(machine), scene, sensors, options);
}

}  // namespace gnosphere
