// SPDX-License-Identifier: Apache-2.0
#include "gnosphere/simulator.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "gnosphere/error.hpp"
#include "pipeline/backend.hpp"
#include "scan/computed_columns.hpp"

namespace gnosphere {
namespace {

// As validate(scene) has it: the top bit of a triangle's number is taken.
constexpr uint64_t kMostPlacedTriangles = (uint64_t{1} << 31) - 1;

void validate(const Exactness& parts) {
  if ((parts.range == Exactness::Range::exact) != (parts.inside == Exactness::Inside::exact))
    throw Error(ErrorCode::invalidArgument, "an exact range needs the exact inside test, and the other way round");
}

// `which` begins the message.
void validate(const Pose& pose, const std::string& which) {
  const auto& [p, q] = pose;
  for (double value : {p.x, p.y, p.z, q.x, q.y, q.z, q.w})
    if (!std::isfinite(value))
      throw Error(ErrorCode::invalidArgument, which + "the pose has a value that is not finite");
  if (!(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w > 1e-12))
    throw Error(ErrorCode::invalidArgument, which + "the pose's quaternion is zero; 0,0,0,1 is no turn");
}

void validate(const Transform& transform, size_t instance) {
  for (double value : transform.rows)
    if (!std::isfinite(value))
      throw Error(ErrorCode::invalidArgument, "instance " + std::to_string(instance) + ": its transform is not finite");
}

void validate(const SensorMotion& motion, const std::string& which) {
  for (size_t i = 0; i < motion.stamps.size(); ++i) {
    const auto& [time, pose] = motion.stamps[i];
    validate(pose, which + "stamp " + std::to_string(i) + ": ");
    if (!std::isfinite(time) || (i > 0 && !(time > motion.stamps[i - 1].time)))
      throw Error(ErrorCode::invalidArgument,
                  which + "the time of stamp " + std::to_string(i) + " does not come after the one before");
  }
}

std::unique_ptr<Backend> makeBackend(const Scene& scene, const std::vector<Sensor>& sensors,
                                     const SimulatorOptions& options) {
  validate(scene);
  if (sensors.empty()) throw Error(ErrorCode::invalidArgument, "a simulator needs at least one sensor");
  for (const Sensor& sensor : sensors) validate(sensor);
  if (options.exactness) validate(*options.exactness);
  if (options.device == "reference") return makeReferenceBackend(scene, sensors, options);
  if (options.device.starts_with("cuda")) return cuda::makeBackend(scene, sensors, options);
  return makeVulkanBackend(scene, sensors, options);
}

}  // namespace

void Timings::add(const std::string& stage, double ms) {
  const auto found =
      std::find_if(stages.begin(), stages.end(), [&](const StageTime& other) { return other.name == stage; });
  if (found == stages.end())
    stages.push_back({stage, ms});
  else
    found->ms += ms;
}

Exactness exactnessOf(Accuracy accuracy) {
  using E = Exactness;
  switch (accuracy) {
    case Accuracy::paper: return {E::Bounds::paper, E::Cull::firstCorner, E::Inside::plain, E::Range::plane};
    case Accuracy::draft: return {E::Bounds::exact, E::Cull::nearestPoint, E::Inside::plain, E::Range::plane};
    case Accuracy::standard:
      return {E::Bounds::exact, E::Cull::nearestPoint, E::Inside::watertight, E::Range::edgeWeights};
    case Accuracy::exact: break;
  }
  return {E::Bounds::exact, E::Cull::nearestPoint, E::Inside::exact, E::Range::exact};
}

std::vector<DeviceInfo> listDevices(std::string* vulkanProblem) {
  std::vector<DeviceInfo> devices = listVulkanDevices(vulkanProblem);
  std::string cudaProblem;
  for (DeviceInfo& device : cuda::devices(cudaProblem)) devices.push_back(std::move(device));
  devices.push_back(referenceDevice());
  return devices;
}

Simulator::Simulator(const Scene& scene, const std::vector<Sensor>& sensors, const SimulatorOptions& options)
    : sensors_(sensors), backend_(makeBackend(scene, sensors, options)) {
  for (const Sensor& sensor : sensors) computed_.emplace_back(sensor, options.fields);
  for (const Instance& instance : scene.instances) classes_.push_back(instance.classId);
  for (const Mesh& mesh : scene.meshes) meshes_.push_back({mesh.vertexCount(), mesh.triangleCount()});
  for (const Instance& instance : scene.instances) instanceMeshes_.push_back(instance.mesh);
  placedTriangles_ = scene.placedTriangleCount();
}
Simulator::Simulator(const Scene& scene, const Sensor& sensor, const SimulatorOptions& options)
    : Simulator(scene, std::vector<Sensor>{sensor}, options) {}
Simulator::~Simulator() = default;
Simulator::Simulator(Simulator&&) noexcept = default;
Simulator& Simulator::operator=(Simulator&&) noexcept = default;

Scan Simulator::scan(const Pose& pose, size_t sensor) {
  Scan result;
  scan(pose, sensor, result);
  return result;
}

void Simulator::scan(const Pose& pose, size_t sensor, Scan& result) {
  Shot shot;
  shot.pose = pose;
  shot.sensor = sensor;
  scan(shot, result);
}

void Simulator::scan(const Shot& shot, Scan& result) {
  run({&shot, 1}, result, [](size_t) {});
}

void Simulator::scanAll(std::span<const Shot> shots, const std::function<void(size_t, const Scan&)>& receive) {
  Scan result;
  run(shots, result, [&](size_t i) { receive(i, result); });
}

void Simulator::run(std::span<const Shot> shots, Scan& result, const std::function<void(size_t)>& receive) {
  for (size_t i = 0; i < shots.size(); ++i) {
    const std::string which = shots.size() > 1 ? "shot " + std::to_string(i) + ": " : "";
    validate(shots[i].pose, which);
    validate(shots[i].motion, which);
    for (const InstanceMotion& motion : shots[i].instanceMotions) {
      checkInstance(motion.instance);
      validate(motion.end, motion.instance);
    }
    if (shots[i].sensor >= sensors_.size())
      throw Error(ErrorCode::invalidArgument, which + "sensor " + std::to_string(shots[i].sensor) +
                                                  " does not exist, there are " + std::to_string(sensors_.size()));
  }
  backend_->scanAll(shots, result, [&](size_t i) {
    const Sensor& sensor = sensors_[shots[i].sensor];
    result.sensor = sensor.name;
    result.columns = sensor.columns;
    result.channels = static_cast<uint32_t>(sensor.channels.size());
    result.pose = shots[i].pose;
    computed_[shots[i].sensor].set(classes_, result);
    receive(i);
  });
}

void Simulator::checkInstance(size_t instance) const {
  if (instance >= instanceMeshes_.size() || instanceMeshes_[instance] == kNoMesh)
    throw Error(ErrorCode::invalidArgument,
                "instance " + std::to_string(instance) +
                    (instance < instanceMeshes_.size()
                         ? " has been removed"
                         : " does not exist, there are " + std::to_string(instanceMeshes_.size())));
}

void Simulator::setTransform(size_t instance, const Transform& transform) {
  checkInstance(instance);
  validate(transform, instance);
  backend_->setInstance(instance, instanceMeshes_[instance], transform);
}

size_t Simulator::addInstance(uint32_t mesh, const Transform& transform, uint16_t classId) {
  if (mesh >= meshes_.size())
    throw Error(ErrorCode::invalidArgument,
                "mesh " + std::to_string(mesh) + " does not exist, the scene has " + std::to_string(meshes_.size()));
  const size_t index = removed_.empty() ? instanceMeshes_.size() : removed_.back();
  validate(transform, index);
  const uint64_t placed = placedTriangles_ + meshes_[mesh].triangles;
  if (placed > kMostPlacedTriangles)
    throw Error(ErrorCode::invalidArgument, "the scene would place " + std::to_string(placed) +
                                                " triangles; the limit is " + std::to_string(kMostPlacedTriangles));
  backend_->setInstance(index, mesh, transform);
  if (removed_.empty())
    instanceMeshes_.push_back(mesh);
  else
    removed_.pop_back();
  instanceMeshes_[index] = mesh;
  placedTriangles_ = placed;
  setClass(index, classId);
  return index;
}

void Simulator::setClass(size_t instance, uint16_t classId) {
  classes_.resize(std::max(classes_.size(), instance + 1));
  classes_[instance] = classId;
}

void Simulator::removeInstance(size_t instance) {
  checkInstance(instance);
  backend_->setInstance(instance, kNoMesh, {});
  placedTriangles_ -= meshes_[instanceMeshes_[instance]].triangles;
  instanceMeshes_[instance] = kNoMesh;
  removed_.push_back(instance);
}

void Simulator::setPositions(size_t mesh, std::span<const float> positions) {
  if (mesh >= meshes_.size())
    throw Error(ErrorCode::invalidArgument,
                "mesh " + std::to_string(mesh) + " does not exist, the scene has " + std::to_string(meshes_.size()));
  if (positions.size() != 3 * meshes_[mesh].vertices)
    throw Error(ErrorCode::invalidArgument,
                "mesh " + std::to_string(mesh) + " has " + std::to_string(meshes_[mesh].vertices) +
                    " vertices of three numbers each; " + std::to_string(positions.size()) + " numbers were given");
  backend_->setPositions(mesh, positions);
}

Plan Simulator::plan(size_t sensor) const {
  if (sensor >= sensors_.size())
    throw Error(ErrorCode::invalidArgument,
                "sensor " + std::to_string(sensor) + " does not exist, there are " + std::to_string(sensors_.size()));
  return backend_->plan(sensor);
}
const DeviceInfo& Simulator::device() const {
  return backend_->device();
}
MemoryUse Simulator::memory() const {
  return backend_->memory();
}
size_t Simulator::clusterCount() const {
  return backend_->clusterCount();
}

}  // namespace gnosphere
