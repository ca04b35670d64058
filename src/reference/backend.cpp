// SPDX-License-Identifier: Apache-2.0
// The reference: intersects every beam in double with every triangle that it may hit, and judges the other backends.
// The reference is written from the mathematics and shares only the generator of random numbers with the shaders.
#include "pipeline/backend.hpp"

#include <algorithm>
#include <atomic>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "base/clock.hpp"
#include "base/threads.hpp"
#include "effects/trajectory.hpp"
#include "reference/results.hpp"
#include "scan/columns.hpp"
#include "sensor/beams.hpp"

namespace gnosphere {

namespace {

using namespace reference;

class ReferenceBackend : public Backend {
 public:
  ReferenceBackend(const Scene& scene, const SensorPlans& sensors, const SimulatorOptions& options)
      : options_(options), scene_(scene), device_(referenceDevice()) {
    for (size_t i = 0; i < sensors.size(); ++i) setSensor(i, sensors[i]);
    for (size_t i = 0; i < scene.meshes.size(); ++i)
      if (scene.meshes[i].deformable()) setMesh(i, &scene.meshes[i]);
    build();
  }

  void scanAll(std::span<const Shot> shots, Scan& result, const std::function<void(size_t)>& receive) override;
  Plan plan(size_t sensor) const override { return planOf(sensors_[sensor]->plan); }
  Plan planOf(std::shared_ptr<const SensorPlan> of, size_t /*views*/) const override { return planOf(*of); }
  const DeviceInfo& device() const override { return device_; }
  MemoryUse memory() const override { return {bvh_.bytes() + places_.size() * sizeof(PlacedMesh), 0, 0}; }
  size_t clusterCount() const override { return 0; }
  void setSensor(size_t index, std::shared_ptr<const SensorPlan> plan) override;
  void setOptics(size_t sensor, std::shared_ptr<const SensorPlan> plan) override { setSensor(sensor, std::move(plan)); }
  void setMaterials(const std::vector<Material>& materials, const std::vector<AlphaImage>& images) override;
  void setMesh(size_t index, const Mesh* mesh) override;
  void setInstance(size_t index, uint32_t mesh, const Transform& transform, uint32_t world) override;
  void moveInstances(std::span<const uint32_t> instances, std::span<const Transform> transforms) override;
  void setPositions(size_t mesh, std::span<const float> positions) override;
  void setDeformation(size_t mesh, const Deformation& deformation) override;

 private:
  static Plan planOf(const SensorPlan& of);
  void build();
  void scan(const Shot& shot, Scan& result) const;
  Bvh treeOf(const Shot& shot, Counters& counters) const;

  const SimulatorOptions options_;
  std::vector<std::optional<BeamEffects>> sensors_;  // empty where one was removed
  Scene scene_;                                      // removed instances have no mesh
  std::map<size_t, Mesh> deformable_;                // by index; in scene_ their positions are the deformed ones
  bool changed_ = false;
  Counters counters_;
  Bvh bvh_ = Bvh({});
  std::vector<PlacedMesh> places_;
  DeviceInfo device_;
};

Plan ReferenceBackend::planOf(const SensorPlan& of) {
  Plan plan;
  plan.effects = of.decisions;
  plan.returns = of.returns;
  return plan;
}

void ReferenceBackend::build() {
  counters_ = {};
  Sweeps none;
  bvh_ = Bvh(placeAll(scene_, 0, options_.faces, {}, {}, none, counters_));
  places_ = placedMeshesOf(scene_);
  changed_ = false;
}

/// Builds the tree for a shot with motion, for one of a world with instances of its own, or of a sensor or a shot
/// that ignores instances. Corners move in straight lines from the start to the end of a turn. For a world, `counters`
/// becomes the counts of the world's triangles.
Bvh ReferenceBackend::treeOf(const Shot& shot, Counters& counters) const {
  const SensorPlan& plan = sensors_[shot.sensor]->plan;
  const Sensor& sensor = plan.sensor;
  const ScanTimes times = scanTimesOf(sensor, true, shot.frame);
  Sweeps sweeps = {{}, times.first, times.last};
  Movement movement;
  if (instancesMove(plan, shot)) {
    movement = {shot.instanceMotions, {}, durationOf(sensor, shot.frame)};
    for (const MeshMotion& motion : shot.meshMotions)
      movement.positions[motion.mesh] = deformedPositions(deformable_.at(motion.mesh), motion.end);
  }
  std::vector<uint8_t> ignored = plan.ignored;
  for (const uint32_t instance : shot.ignoredInstances) {
    ignored.resize(std::max<size_t>(ignored.size(), size_t{instance} + 1));
    ignored[instance] = 1;
  }
  std::vector<Triangle> triangles = placeAll(scene_, shot.world, options_.faces, ignored, movement, sweeps, counters);
  return Bvh(std::move(triangles), std::move(sweeps));
}

void ReferenceBackend::setSensor(size_t index, std::shared_ptr<const SensorPlan> plan) {
  sensors_.resize(std::max(sensors_.size(), index + 1));
  if (plan)
    sensors_[index] = beamEffects(*plan, scene_, options_.materials);
  else
    sensors_[index].reset();
}

void ReferenceBackend::setMaterials(const std::vector<Material>& materials, const std::vector<AlphaImage>& images) {
  auto newMaterials = materials;
  auto newImages = images;
  std::vector<std::optional<BeamEffects>> sensors(sensors_.size());
  const auto exchange = [&] {
    scene_.materials.swap(newMaterials);
    scene_.alphaImages.swap(newImages);
  };
  exchange();
  try {
    for (size_t i = 0; i < sensors.size(); ++i)
      if (sensors_[i]) sensors[i] = beamEffects(sensors_[i]->plan, scene_, options_.materials);
  } catch (...) {
    exchange();
    throw;
  }
  sensors_ = std::move(sensors);
}

void ReferenceBackend::setMesh(size_t index, const Mesh* mesh) {
  const bool deformable = mesh && mesh->deformable();
  Mesh added = mesh ? *mesh : Mesh{};
  std::map<size_t, Mesh> kept;
  if (deformable) {
    kept.emplace(index, *mesh);
    added.positions = deformedPositions(*mesh, mesh->deformation);
  }
  scene_.meshes.resize(std::max(scene_.meshes.size(), index + 1));
  scene_.meshes[index] = std::move(added);
  deformable_.erase(index);
  deformable_.merge(kept);
}

void ReferenceBackend::setInstance(size_t index, uint32_t mesh, const Transform& transform, uint32_t world) {
  if (index == scene_.instances.size()) scene_.instances.emplace_back();
  scene_.instances[index] = {.mesh = mesh, .transform = transform, .world = world};
  changed_ = true;
}

void ReferenceBackend::moveInstances(std::span<const uint32_t> instances, std::span<const Transform> transforms) {
  for (size_t i = 0; i < instances.size(); ++i) scene_.instances[instances[i]].transform = transforms[i];
  changed_ = true;
}

void ReferenceBackend::setPositions(size_t mesh, std::span<const float> positions) {
  scene_.meshes[mesh].positions.assign(positions.begin(), positions.end());
  changed_ = true;
}

void ReferenceBackend::setDeformation(size_t mesh, const Deformation& deformation) {
  scene_.meshes[mesh].positions = deformedPositions(deformable_.at(mesh), deformation);
  changed_ = true;
}

void ReferenceBackend::scanAll(std::span<const Shot> shots, Scan& result, const std::function<void(size_t)>& receive) {
  if (changed_) build();
  for (size_t i = 0; i < shots.size(); ++i) {
    scan(shots[i], result);
    receive(i);
  }
}

void ReferenceBackend::scan(const Shot& shot, Scan& scan) const {
  const Clock::time_point start = Clock::now();
  BeamEffects effects = *sensors_[shot.sensor];
  effects.plan.effects = effectsOf(effects.plan, shot);
  const SensorPlan& plan = effects.plan;
  const Sensor& sensor = plan.sensor;
  const size_t beams = sensor.beamCount();
  resizeArrays(plan, scan, true);
  ScanColumns columns(scan);
  columns.fill(Field::tie, uint8_t{0});
  columns.fill(Field::tolerance, std::numeric_limits<float>::quiet_NaN());
  scan.counters = counters_;
  scan.timings = {};
  const bool ownTree =
      instancesMove(plan, shot) || shot.world != 0 || !plan.ignored.empty() || !shot.ignoredInstances.empty();
  const Bvh own = ownTree ? treeOf(shot, scan.counters) : Bvh({});
  View view = viewOf(scene_, ownTree ? own : bvh_, places_, sensor, shot.pose, scan.counters);
  view.cutOuts = plan.has(gpu::kCutOuts);
  if (plan.has(gpu::kTransmission))
    for (const Optics& optics : effects.optics) view.panes.push_back(optics.transmission > 0);
  const Judge judge(view, shot, effects);
  std::vector<Cause> causes(beams);
  std::atomic<uint64_t> lost = 0;
  inRuns(beams, 1024, threadCount(), [&](size_t first, size_t last) {
    uint64_t ofRun = 0;
    for (size_t i = first; i < last; ++i) causes[i] = judge.judge(i, scan, ofRun);
    lost += ofRun;
  });
  scan.counters.lostEchoes = lost;
  scan.counters.beams = beams;
  for (size_t i = 0; i < beams; ++i) {
    scan.counters.hits += causes[i] == Cause::returned;
    if (plan.signals()) ++scan.counters.causes[static_cast<size_t>(causes[i])];
  }
  scan.counters.misses = beams - scan.counters.hits;
  scan.timings.wallMs = millisecondsSince(start);
}

}  // namespace

std::unique_ptr<Backend> makeReferenceBackend(const Scene& scene, const SensorPlans& sensors,
                                              const SimulatorOptions& options) {
  return std::make_unique<ReferenceBackend>(scene, sensors, options);
}

DeviceInfo referenceDevice() {
  DeviceInfo info;
  info.name = "reference";
  info.type = "reference";
  const unsigned threads = threadCount();
  info.driver = "double precision on the CPU, " + std::to_string(threads) + (threads == 1 ? " thread" : " threads");
  info.usable = true;
  return info;
}

}  // namespace gnosphere
