// SPDX-License-Identifier: Apache-2.0
// Every beam against every triangle it may meet, in double: the oracle that judges the other backends. It is written
// from the mathematics and shares nothing with the shaders but the generator of random numbers.
#include "pipeline/backend.hpp"

#include <chrono>
#include <utility>

#include "base/threads.hpp"
#include "effects/trajectory.hpp"
#include "gnosphere/error.hpp"
#include "reference/results.hpp"
#include "sensor/beams.hpp"

namespace gnosphere {

namespace {

using namespace reference;

class ReferenceBackend : public Backend {
 public:
  ReferenceBackend(const Scene& scene, const std::vector<Sensor>& sensors, const SimulatorOptions& options)
      : sensors_(sensors),
        effects_(beamEffects(options, scene, sensors)),
        faces_(options.faces),
        scene_(scene),
        device_(referenceDevice()) {
    scene_.meshes.emplace_back();
    build();
  }

  void scanAll(std::span<const Shot> shots, Scan& result, const std::function<void(size_t)>& receive) override;
  Plan plan(size_t sensor) const override;
  const DeviceInfo& device() const override { return device_; }
  MemoryUse memory() const override { return {bvh_.bytes() + places_.size() * sizeof(PlacedMesh), 0, 0}; }
  size_t clusterCount() const override { return 0; }
  void setInstance(size_t index, uint32_t mesh, const Transform& transform) override;
  void setPositions(size_t mesh, std::span<const float> positions) override;

 private:
  void build();
  void scan(const Shot& shot, Scan& result) const;
  Bvh movingTree(const Shot& shot) const;

  std::vector<Sensor> sensors_;
  std::vector<BeamEffects> effects_;  // of each sensor
  Faces faces_;
  Scene scene_;  // its last mesh is empty: that of instances that were removed
  bool changed_ = false;
  Counters counters_;
  Bvh bvh_ = Bvh({});
  std::vector<PlacedMesh> places_;
  DeviceInfo device_;
};

Plan ReferenceBackend::plan(size_t sensor) const {
  Plan plan;
  plan.effects = effects_[sensor].plan.decisions;
  plan.returns = effects_[sensor].plan.returns;
  return plan;
}

void ReferenceBackend::build() {
  counters_ = {};
  Sweeps none;
  bvh_ = Bvh(placeAll(scene_, faces_, {}, 0, none, counters_));
  places_ = placedMeshesOf(scene_);
  changed_ = false;
}

/// Corners go in straight lines from where they are to the end of a turn.
Bvh ReferenceBackend::movingTree(const Shot& shot) const {
  const Sensor& sensor = sensors_[shot.sensor];
  Sweeps sweeps;
  for (size_t channel = 0; channel < sensor.channels.size(); ++channel) {
    const size_t first = channel * sensor.columns;
    sweeps.first = std::min(sweeps.first, timeOf(sensor, first));
    sweeps.last = std::max(sweeps.last, timeOf(sensor, first + sensor.columns - 1));
  }
  Counters again;
  std::vector<Triangle> triangles =
      placeAll(scene_, faces_, shot.instanceMotions, sensor.rotationPeriod, sweeps, again);
  return Bvh(std::move(triangles), std::move(sweeps));
}

void ReferenceBackend::setInstance(size_t index, uint32_t mesh, const Transform& transform) {
  if (index == scene_.instances.size()) scene_.instances.emplace_back();
  const auto none = static_cast<uint32_t>(scene_.meshes.size() - 1);
  scene_.instances[index] = {"", mesh == kNoMesh ? none : mesh, transform};
  changed_ = true;
}

void ReferenceBackend::setPositions(size_t mesh, std::span<const float> positions) {
  scene_.meshes[mesh].positions.assign(positions.begin(), positions.end());
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
  const auto start = std::chrono::steady_clock::now();
  const Sensor& sensor = sensors_.at(shot.sensor);
  const Pose& pose = shot.pose;
  const Quaternion& q = pose.orientation;
  if (!(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w > 0))
    throw Error(ErrorCode::invalidArgument, "the pose's orientation has no length; use 0 0 0 1 for no rotation");
  const size_t beams = sensor.beamCount();
  const BeamEffects& effects = effects_[shot.sensor];
  const SensorPlan& plan = effects.plan;
  resizeArrays(plan, scan, true);
  scan.ties.assign(scan.ranges.size(), 0);
  scan.tolerances.assign(scan.ranges.size(), std::numeric_limits<float>::quiet_NaN());
  scan.counters = counters_;
  scan.timings = {};
  const bool moves = plan.has(gpu::kObjectMotion) && !shot.instanceMotions.empty();
  const Bvh moving = moves ? movingTree(shot) : Bvh({});
  View view = viewOf(scene_, moves ? moving : bvh_, places_, sensor, pose, scan.counters);
  view.cutOuts = plan.has(gpu::kCutOuts);
  const Judge judge(view, shot, effects);
  std::vector<Cause> causes(beams);
  inRuns(beams, 1024, threadCount(), [&](size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) causes[i] = judge.judge(i, scan);
  });
  scan.counters.beams = beams;
  for (size_t i = 0; i < beams; ++i) {
    scan.counters.hits += causes[i] == Cause::returned;
    if (plan.signals()) ++scan.counters.causes[static_cast<size_t>(causes[i])];
    if (!scan.causes.empty()) scan.causes[i] = static_cast<uint8_t>(causes[i]);
  }
  scan.counters.misses = beams - scan.counters.hits;
  scan.timings.wallMs = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

std::unique_ptr<Backend> makeReferenceBackend(const Scene& scene, const std::vector<Sensor>& sensors,
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
