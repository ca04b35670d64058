// SPDX-License-Identifier: Apache-2.0
#include "gnosphere/simulator.hpp"

#include <algorithm>
#include <utility>

#include "base/call.hpp"
#include "base/clock.hpp"
#include "base/float_environment.hpp"
#include "base/index_pool.hpp"
#include "effects/material_table.hpp"
#include "effects/sensor_plan.hpp"
#include "effects/shot_motion.hpp"
#include "gnosphere/error.hpp"
#include "kept_scene.hpp"
#include "pipeline/backend.hpp"
#include "pipeline/recording.hpp"
#include "pipeline/result_ring.hpp"
#include "scan/batch_arrays.hpp"
#include "scan/columns.hpp"
#include "scan/computed_columns.hpp"
#include "scan/fields.hpp"
#include "scan/layout.hpp"
#include "shot_checks.hpp"
#include "simulator_warnings.hpp"

namespace gnosphere {
namespace {

// Empties a result whose call has failed, because the sizes of its arrays may not agree.
template <typename Result>
struct Unfinished {
  Result* result;
  ~Unfinished() {
    if (result) *result = Result();
  }
};

// Checks the arguments of a scan. Wrong ones leave the result as it is; if memory runs out, it is made empty.
template <typename Result, typename Check>
void checkFor(Result& result, const Check& check) {
  Unfinished<Result> unfinished{&result};
  try {
    check();
  } catch (const Error& error) {
    if (error.code() == ErrorCode::invalidArgument) unfinished.result = nullptr;
    throw;
  }
  unfinished.result = nullptr;
}

}  // namespace

class Simulator::Impl {
 public:
  const MakerProcess& maker() const { return calls_.maker; }
  CallState& calls() { return calls_; }

  Impl(const Scene& scene, const std::vector<SensorRequest>& sensors, const SimulatorOptions& options)
      : options_(options), planner_(options_), kept_(scene, planner_) {
    if (options.accuracyParts) validate(*options.accuracyParts);
    validate(options.materials);
    for (const SensorRequest& given : sensors) {
      check(given);
      const SensorRequest request = completed(given, plans_.size());
      computed_.emplace_back(request.sensor, request.fields);
      plans_.push_back(planner_.plan(kept_.scene(), request, plans_.size(), false));
      warnings_.tellPlan(*plans_.back());
      requests_.push_back(request);
      sensors_.take();
    }
    warnings_.tellScene(scene);
    backend_ = makeBackend(scene, plans_, options_);
    kept_.changeIn(*backend_);
  }

  void prepareToScan(std::span<const Shot> shots, bool numbered) {
    if (options_.device.adopted)
      throw Error(ErrorCode::invalidArgument,
                  "this simulator is on a device of the caller; its scans are recorded by vulkan::Recorder");
    if (options_.resultsOnDevice)
      throw Error(ErrorCode::invalidArgument,
                  "the results of this simulator stay on its device (results_on_device), so a BatchStream submits its "
                  "scans");
    if (options_.compileOnly)
      throw Error(ErrorCode::invalidArgument,
                  "this simulator only compiles, so it cannot scan; see SimulatorOptions::compileOnly");
    planAgain();
    for (size_t i = 0; i < shots.size(); ++i) check(shots[i], numbered ? "shot " + std::to_string(i) + ": " : "");
    for (const Shot& shot : shots) warnings_.tellLeftOut(shot, *plans_[shot.sensor]);
  }

  void run(std::span<const Shot> shots, Scan& result, const std::function<void(size_t)>& receive) {
    checkFor(result, [&] { prepareToScan(shots, shots.size() > 1); });
    Unfinished<Scan> unfinished{&result};
    backend_->scanAll(shots, result, [&](size_t i) {
      const Sensor& sensor = requests_[shots[i].sensor].sensor;
      for (const Field field : {Field::x, Field::triangle, Field::instance})
        ScanColumns(result).setUnknown(field, false);
      result.sensor = sensor.name;
      result.columns = sensor.width();
      result.channels = sensor.height();
      result.pose = shots[i].pose;
      result.poseKnown = true;
      result.gridKnown = sensor.isGrid() || sensor.height() > 1;
      result.skewed = isSkewed(*plans_[shots[i].sensor], shots[i]);
      computed_[shots[i].sensor].set(kept_.classes(), shots[i].frame, result);
      warnings_.tellLostEchoes(shots[i].sensor, *plans_[shots[i].sensor], result.counters);
      receive(i);
    });
    unfinished.result = nullptr;
  }

  void runBatch(std::span<const Shot> shots, std::span<const Field> asked, Batch& result,
                const std::function<void(size_t)>& progress, size_t sensorOfNone) {
    const Clock::time_point start = Clock::now();
    const size_t index = shots.empty() ? sensorOfNone : shots[0].sensor;
    std::vector<Field> fields;
    checkFor(result, [&] {
      prepareToScan(shots, true);
      sensors_.check(index, shots.empty() ? "a batch without shots has the beams of a sensor; " : "");
      checkSensorOfBatch(shots);
      fields = fieldsOfBatch(requests_[index], options_.device, index, asked);
    });
    Unfinished<Batch> unfinished{&result};
    const Sensor& sensor = requests_[index].sensor;
    result.sensor = sensor.name;
    result.columns = sensor.width();
    result.channels = sensor.height();
    result.returns = plans_[index]->returns;
    result.views = shots.size();
    result.beams = sensor.beamCount();
    result.counters = {};
    result.timings = {};
    BatchArrays arrays(result);
    arrays.make(fields);
    Scan& scan = scanOfBatch_;
    scan.counters = {};
    scan.timings = {};
    const bool hitsAlone = std::all_of(fields.begin(), fields.end(), &isOfEveryScan);
    const auto advance = [&](size_t view) {
      if (progress) progress(view + 1);
    };
    if (hitsAlone && backend_->scanInto(shots, arrays.places(), scan, advance)) {
      result.counters = scan.counters;
      result.timings = scan.timings;
      warnings_.tellLostEchoes(index, *plans_[index], result.counters);
    } else {
      run(shots, scan, [&](size_t view) {
        arrays.copy(scan, view);
        result.counters += scan.counters;
        result.timings.gpuMs += scan.timings.gpuMs;
        for (const StageTime& stage : scan.timings.stages) result.timings.add(stage.name, stage.ms);
        advance(view);
      });
    }
    result.timings.wallMs = millisecondsSince(start);
    unfinished.result = nullptr;
  }

  /// Returns what the simulator's only recorder holds.
  std::shared_ptr<const void> lendToRecorder() {
    if (!options_.device.adopted)
      throw Error(ErrorCode::invalidArgument,
                  "this simulator is not on a device of the caller, so it cannot record; see vulkan::adopt()");
    if (!recorder_.expired())
      throw Error(ErrorCode::invalidArgument,
                  "this simulator has a recorder already, which counts its frames in flight; use that one, or destroy "
                  "it first");
    const auto only = std::make_shared<const char>();
    recorder_ = only;
    return only;
  }

  void record(Recording& recording) {
    planAgain();
    for (size_t i = 0; i < recording.scans.size(); ++i)
      check(*recording.scans[i].shot, "shot " + std::to_string(i) + ": ");
    for (const Recording::Item& item : recording.scans) warnings_.tellLeftOut(*item.shot, *plans_[item.shot->sensor]);
    recording.classes = &kept_.classes();
    backend_->record(recording);
  }

  void abandon(size_t frame) { backend_->abandon(frame); }

  // A change of the sensors allocates what it needs first, then changes the backend, which may fail, and then notes the
  // change, which cannot.

  size_t addSensor(const SensorRequest& given) {
    check(given);
    const size_t index = sensors_.next();
    SensorRequest request = completed(given, index);
    sensors_.reserve();
    auto plan = planner_.plan(kept_.scene(), request, index, false);
    warnings_.tellPlan(*plan);
    ComputedColumns computed(request.sensor, request.fields);
    const size_t count = std::max(index + 1, sensors_.size());
    plans_.resize(count);
    requests_.resize(count);
    computed_.resize(count);
    backend_->setSensor(index, plan);
    sensors_.take();
    plans_[index] = std::move(plan);
    requests_[index] = std::move(request);
    computed_[index] = std::move(computed);
    return index;
  }

  void removeSensor(size_t index) {
    sensors_.check(index);
    SensorRequest none;
    backend_->setSensor(index, nullptr);
    plans_[index].reset();
    requests_[index] = std::move(none);
    computed_[index] = {};
    warnings_.forget(index);
    sensors_.giveBack(index);
  }

  size_t addInstance(uint32_t mesh, const Transform& transform, uint16_t classId, uint32_t world) {
    const size_t index = kept_.addInstance(mesh, transform, classId, world);
    noteInstances();
    return index;
  }

  std::vector<uint32_t> addInstances(std::span<const Instance> instances) {
    std::vector<uint32_t> indices = kept_.addInstances(instances);
    noteInstances();
    return indices;
  }

  AddedScene addScene(const Scene& scene, const Transform& transform) {
    AddedScene added = kept_.addScene(scene, transform);
    noteInstances();
    return added;
  }

  void removeInstance(size_t instance) {
    kept_.removeInstance(instance);
    noteRemoval();
  }

  void removeInstances(std::span<const uint32_t> instances) {
    kept_.removeInstances(instances);
    noteRemoval();
  }

  /// If the scene has changed since the last scan, this is what the next scan will make of the sensor; nothing is made
  /// yet.
  Plan plan(size_t sensor, size_t views) const {
    sensors_.check(sensor);
    std::shared_ptr<const SensorPlan> next = plans_[sensor];
    if (kept_.isStale()) next = SensorPlanner(planner_).plan(kept_.scene(), requests_[sensor], sensor, true);
    const bool made = views <= 1 && sameArrays(*plans_[sensor], *next);
    Plan plan = made ? backend_->plan(sensor) : backend_->planOf(next, views);
    plan.effects = next->decisions;
    return plan;
  }

  MemoryUse memory() const {
    MemoryUse use = backend_->memory();
    if (const std::shared_ptr<ResultRing> ring = ring_.lock()) use.work += ring->bytes();
    return use;
  }
  KeptScene& kept() { return kept_; }
  const Backend& backend() const { return *backend_; }
  const SensorPlans& plans() const { return plans_; }
  std::shared_ptr<ResultRing> makeRing(size_t buffers, uint64_t bytes, uint64_t hostBytes) {
    if (!options_.resultsOnDevice || options_.compileOnly)
      throw Error(ErrorCode::invalidArgument,
                  "a BatchStream needs a simulator whose results stay on its device (results_on_device)");
    if (!ring_.expired())
      throw Error(ErrorCode::invalidArgument,
                  "the simulator has a BatchStream already, and can have one at a time; let go of it first, and of "
                  "arrays that it has handed out");
    std::shared_ptr<ResultRing> ring = backend_->makeRing(buffers, bytes, hostBytes);
    ring_ = ring;
    return ring;
  }

 private:
  /// Instances have come or gone. The kept scene knows whether that changes the materials in use, but not which of them
  /// a sensor sees that ignores instances.
  void noteInstances() {
    const auto ignores = [](const SensorRequest& request) { return !request.ignoredInstances.empty(); };
    if (std::ranges::any_of(requests_, ignores)) kept_.setStale();
  }

  /// The indices of removed instances leave the lists of sensors that ignore them, because other instances may get
  /// them.
  void noteRemoval() {
    noteInstances();
    const auto isGone = [&](uint32_t instance) { return !kept_.hasInstance(instance); };
    for (SensorRequest& request : requests_) std::erase_if(request.ignoredInstances, isGone);
  }

  void check(const SensorRequest& request) const {
    validate(request.sensor);
    for (const uint32_t instance : request.ignoredInstances)
      kept_.checkInstance(instance, "sensor '" + request.sensor.name + "': it ignores an instance, but ");
    if (request.layout.empty()) return;
    if (!options_.device.adopted && !options_.compileOnly && !options_.resultsOnDevice)
      throw Error(ErrorCode::invalidArgument,
                  "sensor '" + request.sensor.name +
                      "': a layout is for results that stay on a device, see vulkan::adopt() and results_on_device");
    validate(request.layout);
  }

  // Returns the request with the fields of its layout, and with a layout if results stay on a device of our own.
  SensorRequest completed(const SensorRequest& given, size_t index) {
    SensorRequest request = given;
    if (options_.resultsOnDevice && request.layout.empty()) {
      request.layout = columnLayout({Field::range}, 0);
      const uint64_t returns = planner_.plan(kept_.scene(), withFieldsOfLayout(request), index, false)->returns;
      std::vector<Field> fields = request.fields;
      fields.insert(fields.begin(), Field::range);
      request.layout = columnLayout(fields, request.sensor.beamCount() * returns);
    }
    return withFieldsOfLayout(request);
  }

  void check(const Shot& shot, const std::string& which) const {
    validate(shot.pose, which);
    validate(shot.motion, which);
    kept_.checkMotions(shot, which);
    for (const uint32_t instance : shot.ignoredInstances)
      kept_.checkInstance(instance, which + "it ignores an instance, but ");
    sensors_.check(shot.sensor, which);
    checkTimes(shot.motion, plans_[shot.sensor]->sensor, shot.frame, which);
    if (shot.weather) checkWeather(*plans_[shot.sensor], *shot.weather, which);
  }

  // Plans the sensors again whose effects depend on the scene, after the materials or the instances that they see may
  // have changed.
  void planAgain() {
    if (!kept_.isStale()) return;
    for (size_t i = 0; i < plans_.size(); ++i) {
      if (!plans_[i]) continue;
      auto plan = planner_.plan(kept_.scene(), requests_[i], i, true);
      if (!sameButOptics(*plans_[i], *plan))
        backend_->setSensor(i, plan);
      else if (!sameArrays(*plans_[i], *plan))
        backend_->setOptics(i, plan);
      plans_[i] = std::move(plan);
    }
    kept_.setPlanned();
  }

  CallState calls_;
  const SimulatorOptions options_;
  SimulatorWarnings warnings_{options_};
  SensorPlanner planner_;
  KeptScene kept_;
  IndexPool sensors_{"sensor"};
  std::vector<SensorRequest> requests_;    // by sensor
  std::vector<ComputedColumns> computed_;  // by sensor
  SensorPlans plans_;                      // by sensor
  Scan scanOfBatch_;                       // a view, or the sums, of the last batch; its memory is used again
  std::weak_ptr<const char> recorder_;     // the one that records this simulator's scans
  std::unique_ptr<Backend> backend_;
  std::weak_ptr<ResultRing> ring_;  // of the BatchStream, while there is one
};

Simulator::Simulator(const Scene& scene, const std::vector<SensorRequest>& sensors, const SimulatorOptions& options)
    : impl_([&] {
        const DefaultFloatEnvironment environment;
        return std::make_unique<Impl>(scene, sensors, options);
      }()) {}
Simulator::Simulator(const Scene& scene, const SensorRequest& sensor, const SimulatorOptions& options)
    : Simulator(scene, std::vector{sensor}, options) {}
// A process that was forked from the one that has made the simulator cannot end the simulator's threads and device.
Simulator::~Simulator() {
  leaveToParent(impl_);
}
Simulator::Simulator(Simulator&&) noexcept = default;
Simulator& Simulator::operator=(Simulator&& other) noexcept {
  if (this == &other) return *this;
  const Simulator before(std::move(*this));
  impl_ = std::move(other.impl_);
  return *this;
}

Scan Simulator::scan(const Pose& pose, size_t sensor) {
  Shot shot;
  shot.pose = pose;
  shot.sensor = sensor;
  Scan result;
  scanInto(shot, result);
  return result;
}

void Simulator::scanInto(const Shot& shot, Scan& result) {
  Call(impl_)->run({&shot, 1}, result, [](size_t) {});
}

void Simulator::scanAll(std::span<const Shot> shots, const std::function<void(size_t, const Scan&)>& receive) {
  if (!receive) throw Error(ErrorCode::invalidArgument, "scanAll() needs a function that receives the scans");
  Scan result;
  Call(impl_)->run(shots, result, [&](size_t i) { receive(i, result); });
}

void Simulator::scanBatchInto(std::span<const Shot> shots, Batch& result, std::span<const Field> fields,
                              const std::function<void(size_t)>& progress, size_t sensorOfNone) {
  Call(impl_)->runBatch(shots, fields, result, progress, sensorOfNone);
}

Batch Simulator::scanBatch(std::span<const Shot> shots, std::span<const Field> fields, size_t sensorOfNone) {
  Batch result;
  scanBatchInto(shots, result, fields, {}, sensorOfNone);
  return result;
}

std::shared_ptr<const void> Simulator::lendToRecorder() {
  return Call(impl_)->lendToRecorder();
}
void Simulator::record(Recording& recording) {
  Call(impl_)->record(recording);
}
void Simulator::abandon(size_t frame) {
  Call(impl_)->abandon(frame);
}
const SensorPlans& Simulator::plans() const {
  return forReading(impl_).plans();
}
std::shared_ptr<ResultRing> Simulator::makeRing(size_t buffers, uint64_t bytes, uint64_t hostBytes) {
  return Call(impl_)->makeRing(buffers, bytes, hostBytes);
}
void Simulator::setVertices(size_t mesh, const CallerVertices& buffer) {
  Call(impl_)->kept().setVertices(mesh, buffer);
}
void Simulator::setTransforms(const CallerTransforms& buffer) {
  Call(impl_)->kept().setTransforms(buffer);
}

size_t Simulator::addSensor(const SensorRequest& request) {
  return Call(impl_)->addSensor(request);
}
void Simulator::removeSensor(size_t sensor) {
  Call(impl_)->removeSensor(sensor);
}
size_t Simulator::addMaterial(const Material& material, const AlphaImage* image) {
  return Call(impl_)->kept().addMaterial(material, image);
}
void Simulator::setMaterial(size_t index, const Material& material, const AlphaImage* image) {
  Call(impl_)->kept().setMaterial(index, material, image);
}
void Simulator::removeMaterial(size_t material) {
  Call(impl_)->kept().removeMaterial(material);
}
size_t Simulator::addMesh(const Mesh& mesh) {
  return Call(impl_)->kept().addMesh(mesh);
}
void Simulator::removeMesh(size_t mesh) {
  Call(impl_)->kept().removeMesh(mesh);
}
void Simulator::setDeformation(size_t mesh, const Deformation& deformation) {
  Call(impl_)->kept().setDeformation(mesh, deformation);
}
void Simulator::setPositions(size_t mesh, std::span<const float> positions) {
  Call(impl_)->kept().setPositions(mesh, positions);
}
std::vector<uint32_t> Simulator::addInstances(std::span<const Instance> instances) {
  return Call(impl_)->addInstances(instances);
}
size_t Simulator::addInstance(uint32_t mesh, const Transform& transform, uint16_t classId, uint32_t world) {
  return Call(impl_)->addInstance(mesh, transform, classId, world);
}
AddedScene Simulator::addScene(const Scene& scene, const Transform& transform) {
  return Call(impl_)->addScene(scene, transform);
}
void Simulator::removeInstance(size_t instance) {
  Call(impl_)->removeInstance(instance);
}
void Simulator::removeInstances(std::span<const uint32_t> instances) {
  Call(impl_)->removeInstances(instances);
}
void Simulator::setTransform(size_t instance, const Transform& transform) {
  Call(impl_)->kept().setTransform(instance, transform);
}
void Simulator::setTransforms(std::span<const uint32_t> instances, std::span<const double> values) {
  Call(impl_)->kept().setTransforms(instances, values);
}
void Simulator::setTransforms(std::span<const uint32_t> instances, std::span<const float> values) {
  Call(impl_)->kept().setTransforms(instances, values);
}

Plan Simulator::plan(size_t sensor, size_t views) const {
  const DefaultFloatEnvironment environment;
  return forReading(impl_).plan(sensor, views);
}
const DeviceInfo& Simulator::device() const {
  return ofThisProcess(impl_).backend().device();
}
MemoryUse Simulator::memory() const {
  return forReading(impl_).memory();
}
size_t Simulator::clusterCount() const {
  return forReading(impl_).backend().clusterCount();
}

}  // namespace gnosphere
