// SPDX-License-Identifier: Apache-2.0
#include "pipeline/device_backend.hpp"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <limits>

#include "base/threads.hpp"
#include "gnosphere/error.hpp"
#include "pipeline/dry_machine.hpp"
#include "pipeline/record_tables.hpp"
#include "pipeline/recorded_scans.hpp"

namespace gnosphere {
namespace {

using Clock = std::chrono::steady_clock;

// Returns the range in metres within which 95 % of a sample of the returns lie; 0 if there are hardly any.
float shellHintOf(const Scan& scan) {
  constexpr size_t kSamples = 2048, kLeast = 64;
  std::vector<float> ranges;
  // An odd step meets all columns of a grid.
  for (size_t i = 0; i < scan.ranges.size(); i += scan.ranges.size() / kSamples | 1)
    if (scan.ranges[i] > 0) ranges.push_back(scan.ranges[i]);
  if (ranges.size() < kLeast) return 0;
  const auto at = ranges.begin() + static_cast<ptrdiff_t>(ranges.size() * 95 / 100);
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
        slots_(machine_->framesInFlight()),
        recorded_(*machine_, scene_) {
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

  bool scanInto(std::span<const Shot> shots, const Places& places, Scan& sum) override {
    if (shots.empty() || !sensors_[shots[0].sensor]->arrays.leavesHitsAlone()) return false;
    scanTo(shots, {sum, places, [](size_t) {}, true});
    return true;
  }

  void record(Recording& recording) override {
    setDeformed(scene_.deformed());
    std::vector<SensorArrays*> sensors;
    for (const auto& sensor : sensors_) sensors.push_back(sensor ? &sensor->arrays : nullptr);
    recorded_.record(recording, sensors);
    machine_->throwOnMessages();
  }

  void abandon(size_t frame) override { recorded_.abandon(frame); }

  void setSensor(size_t index, std::shared_ptr<const SensorPlan> plan) override {
    waitForAll();
    std::unique_ptr<SensorState> sensor;
    if (plan) {
      if (!plan->layout.empty()) checkLayout(*plan);
      if (plan->surfaces() || plan->speeds()) scene_.geometry().addSlots();
      if (plan->holes()) scene_.geometry().addTextureCoordinates();
      sensor = std::make_unique<SensorState>(*machine_, std::move(plan), options_, scene_.instances().mostTriangles(),
                                             scene_.deformed());
      machine_->prepared();
    }
    machine_->throwOnMessages();
    sensors_.resize(std::max(sensors_.size(), index + 1));
    recorded_.forget(index);
    sensors_[index] = std::move(sensor);
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

  Plan plan(size_t sensor) const override { return sensors_[sensor]->arrays.plan(); }
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

  // The data of a frame in flight that do not depend on the sensor.
  struct Slot {
    PlacedArrays placed;
    uint64_t reused = 0;              // number of triangles that the still image replaces
    std::vector<ShotMotion> motions;  // of the shots that are scanned
    Clock::time_point start;
  };

  // A run on the device: one group of origins of a shot, or several shots of which each is a view. Most sensors have
  // one group.
  struct Part {
    std::span<const Shot> shots;
    size_t index, group;  // of the first shot, of the group
    bool last;            // of the shot's parts
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
    const auto hasViews = [](const Part& part) { return part.shots.size() > 1; };
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

  void setDeformed(bool deformed) {
    for (const auto& sensor : sensors_)
      if (sensor) sensor->arrays.setDeformed(deformed);
  }

  std::vector<Part> partsOf(std::span<const Shot> shots, size_t mostViews) const {
    std::vector<Part> parts;
    for (size_t i = 0; i < shots.size();) {
      const size_t views = viewsFrom(shots.subspan(i), mostViews);
      const size_t count = sensors_[shots[i].sensor]->arrays.groups(shots[i].frame).size();
      for (size_t group = 0; group < count; ++group)
        parts.push_back({shots.subspan(i, views), i, group, group + 1 == count});
      i += views;
    }
    return parts;
  }

  static constexpr uint64_t kMotionsPerRun = 4;  // the tables of one take 0.15 to 0.26 ms
  static constexpr size_t kAnyViews = std::numeric_limits<size_t>::max();

  // Submits the next part of a scan, or the next scan, to the device before waiting for the current one.
  void scanParts(const std::vector<Part>& parts, const Destination& to) {
    waitForAll();
    setDeformed(scene_.deformed());
    if (!parts.empty()) submit(parts, 0);
    for (size_t i = 0; i < parts.size(); ++i) {
      if (slots_.size() > 1 && i + 1 < parts.size()) submit(parts, i + 1);
      finish(parts, i, to);
      if (slots_.size() == 1 && i + 1 < parts.size()) submit(parts, i + 1);
    }
  }

  // Returns the number of shots, from the first one on, that are submitted together. A sensor that stands still is
  // scanned shot by shot, because then it can reuse its hits.
  size_t viewsFrom(std::span<const Shot> shots, size_t most) const {
    most = std::min<size_t>({most, shots.size(), sensors_[shots[0].sensor]->arrays.mostViews()});
    const uint64_t room = mostListBytes(options_, machine_->traits());
    const SensorPlan& plan = *sensors_[shots[0].sensor]->plan;
    const bool moving = moves(plan, shots[0]);
    const auto bytesOf = [&](size_t view) { return scene_.bytesOfView(shots[view].world, moving); };
    const auto standsStill = [&](const Shot& shot, const Shot& before) {
      return !moving && shot.world == before.world && std::memcmp(&shot.pose, &before.pose, sizeof(Pose)) == 0;
    };
    const auto deforms = [&](const Shot& shot) { return !shot.meshMotions.empty() && plan.has(gpu::kObjectMotion); };
    // A subgroup may work on several views, so the sensor moves in all of them or in none.
    const auto alike = [&](const Shot& shot) {
      return shot.sensor == shots[0].sensor && !deforms(shot) && moves(plan, shot) == moving &&
             (!moving || shot.motion.stamps.empty() == shots[0].motion.stamps.empty());
    };
    if (deforms(shots[0])) return 1;
    size_t views = 1;
    uint64_t bytes = most > 1 ? bytesOf(0) : 0;
    while (views < most && alike(shots[views]) && !standsStill(shots[views], shots[views - 1])) {
      bytes += bytesOf(views);
      if (bytes > room) break;
      ++views;
    }
    return views;
  }

  // Scans of several views have frames of their own, because their arrays are larger.
  size_t sensorFrame(size_t slot, const Part& part) const {
    return part.shots.size() > 1 ? slots_.size() + slot : slot;
  }

  void waitForAll() {
    for (size_t frame = 0; frame < slots_.size(); ++frame) machine_->wait(frame);
  }

  void submit(std::span<const Part> parts, size_t i) {
    const size_t frame = i % slots_.size();
    slots_[frame].start = Clock::now();
    run(frame, parts[i]);
  }

  // Decides how the scan uses the still image. If another frame is making the image, waits until it is known to be
  // valid.
  StillImage::Use useStill(StillImage& still, SensorArrays& sensor, const Shot& shot, bool moves) {
    if (still.inMaking()) {
      machine_->wait(still.frame());
      still.end(!sensor.cutShort(still.frame()));
    }
    if (!moves) return still.next(shot, scene_.instances());
    still.forget();
    return StillImage::Use::none;
  }

  void run(size_t frame, const Part& part) {
    const Shot& shot = part.shots[0];
    Slot& slot = slots_[frame];
    SensorArrays& sensor = sensors_[shot.sensor]->arrays;
    if (sensor.beams() == 0) return;
    const auto views = static_cast<uint32_t>(part.shots.size());
    StillImage& still = sensors_[shot.sensor]->still;
    StillImage::Use use = StillImage::Use::none;
    slot.reused = 0;
    if (!sensor.hasRoomForViews(views)) {
      waitForAll();
      sensor.makeRoomForViews(views);
    }
    const OriginBounds& lasers = sensor.groups(shot.frame)[part.group].lasers;
    slot.motions = motionsOf(sensor.sensorPlan(), lasers, part.shots);
    if (views > 1) {
      std::vector<ViewPlace> places;
      for (uint32_t view = 0; view < views; ++view)
        places.push_back({seenFrom(part.shots, view, slot.motions), part.shots[view].world});
      scene_.place(places, sensor.reach() + reachOf(slot.motions), sensor.sensorPlan().ignored, slot.placed);
    } else {
      use = useStill(still, sensor, shot, !slot.motions.empty() && slot.motions[0].moves);
      slot.reused = use == StillImage::Use::use ? still.triangles() : 0;
      const Pose pose = seenFrom(part.shots, 0, slot.motions);
      Selection selection = still.selection(use);
      selection.ignored = sensor.sensorPlan().ignored;
      selection.world = shot.world;
      scene_.place(pose, sensor.reach() + reachOf(slot.motions), selection, slot.placed);
    }
    if (!scene_.listsHold(slot.placed)) {
      waitForAll();
      scene_.growLists(slot.placed);
    }
    BoundArrays arrays = {};
    scene_.bind(arrays);
    slot.placed.bind(arrays);
    InstanceEntries instances = {scene_.instances().count()};
    if (views > 1) instances.inViews = slot.placed.inViews();
    const std::vector<Step> steps = sensor.prepare(sensorFrame(frame, part), part.shots, part.group, slot.motions,
                                                   instances, slot.placed.groups(), use, arrays);
    machine_->submit(frame, steps, arrays);
    if (use == StillImage::Use::make) still.begin(frame);
  }

  // Waits for part i, repeats it while its lists were too small, and reads its results. If the part after it was cut
  // short too, that is found out in its own turn from the capacities it was submitted with.
  void finish(std::span<const Part> parts, size_t i, const Destination& to) {
    const size_t slot = i % slots_.size();
    const Part& part = parts[i];
    SensorArrays& sensor = sensors_[part.shots[0].sensor]->arrays;
    const size_t frame = sensorFrame(slot, part), views = part.shots.size();
    Scan& result = to.scan;
    if (part.group == 0) {
      if (!to.batch) clearResult(sensor.sensorPlan(), scene_.instances(), part.shots[0].world, result);
      start_ = slots_[slot].start;
    }
    uint64_t retries = 0;
    Timings timings;
    if (sensor.beams() > 0) {
      machine_->wait(slot);
      sensor.checkAlive(frame);
      for (; sensor.cutShort(frame); ++retries) {
        waitForAll();
        sensor.growLists(frame);
        run(slot, part);
        machine_->wait(slot);
        sensor.checkAlive(frame);
      }
      machine_->readTimings(slot, views > 1 || to.batch ? timings : result.timings);
    }
    machine_->throwOnMessages();
    if (to.batch) {
      for (const StageTime& stage : timings.stages) result.timings.add(stage.name, stage.ms);
      result.timings.gpuMs += timings.gpuMs;
      result.counters.retries += retries;
      finishBatch(part, slot, frame, to);
      return;
    }
    const double waited = millisecondsSince(start_) / static_cast<double>(views);
    for (size_t view = 0; view < views; ++view) {
      const Clock::time_point start = Clock::now();
      if (view > 0) clearResult(sensor.sensorPlan(), scene_.instances(), part.shots[view].world, result);
      for (const StageTime& stage : timings.stages)
        result.timings.add(stage.name, stage.ms / static_cast<double>(views));
      result.timings.gpuMs += timings.gpuMs / static_cast<double>(views);
      if (sensor.beams() > 0) {
        DeviceResults results = sensor.results(frame, static_cast<uint32_t>(view));
        if (views > 1) results.inViews = slots_[slot].placed.inViews();
        readResults(workers_, sensor.sensorPlan(), results, scene_.instances(), part.shots[view],
                    motionOf(slots_[slot].motions, view), result);
        if (part.last && sensor.choosesShells()) sensor.setShellHint(shellHintOf(result));
        result.counters.reused = slots_[slot].reused;
        result.counters.culledByCluster -= slots_[slot].reused;
        if (view == 0) result.counters.retries += retries;
      }
      result.timings.wallMs = waited + millisecondsSince(start);
      if (part.last) to.receive(part.index + view);
    }
  }

  void finishBatch(const Part& part, size_t slot, size_t frame, const Destination& to) {
    SensorArrays& sensor = sensors_[part.shots[0].sensor]->arrays;
    if (sensor.beams() > 0) {
      readHits(workers_, sensor.sensorPlan(), sensor.results(frame), scene_.instances(), part.shots,
               slots_[slot].motions, to.places.from(part.index * sensor.sensorPlan().sensor.beamCount()), to.scan);
      to.scan.counters.reused += slots_[slot].reused;
      to.scan.counters.culledByCluster -= slots_[slot].reused;
    }
    for (size_t view = 0; view < part.shots.size(); ++view) to.receive(part.index + view);
  }

  // Returns the motions of shots of which the first one tells whether anything moves.
  std::vector<ShotMotion> motionsOf(const SensorPlan& plan, const OriginBounds& lasers,
                                    std::span<const Shot> shots) const {
    const auto of = [&](const Shot& shot) {
      return motionOf(plan, lasers, shot, scene_.instances(), scene_.geometry().deformables());
    };
    std::vector<ShotMotion> motions;
    std::optional<ShotMotion> first = of(shots[0]);
    if (!first) return motions;
    motions.resize(first->moves ? shots.size() : 1);
    motions[0] = std::move(*first);
    inRuns(motions.size() - 1, kMotionsPerRun, threadCount(), [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin + 1; i <= end; ++i) motions[i] = *of(shots[i]);
    });
    return motions;
  }

  static double millisecondsSince(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  }

  const SimulatorOptions options_;
  std::unique_ptr<Machine> machine_;
  std::vector<Material> materials_;
  SceneArrays scene_;
  std::vector<std::unique_ptr<SensorState>> sensors_;  // null for a removed sensor
  std::vector<Slot> slots_;
  Clock::time_point start_;  // of the scan that is being finished
  Workers workers_;
  RecordedScans recorded_;
};

}  // namespace

std::unique_ptr<Backend> makeDeviceBackend(std::unique_ptr<Machine> machine, const Scene& scene,
                                           const SensorPlans& sensors, const SimulatorOptions& options) {
  return std::make_unique<DeviceBackend>(std::move(machine), scene, sensors, options);
}

}  // namespace gnosphere
