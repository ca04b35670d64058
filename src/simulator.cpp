// SPDX-License-Identifier: Apache-2.0
#include "gnosphere/simulator.hpp"

#include <cmath>
#include <utility>

#include "backend.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere {
namespace {

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

std::unique_ptr<Backend> makeBackend(const Scene& scene, const std::vector<Sensor>& sensors,
                                     const SimulatorOptions& options) {
  validate(scene);
  if (sensors.empty()) throw Error(ErrorCode::invalidArgument, "a simulator needs at least one sensor");
  for (const Sensor& sensor : sensors) validate(sensor);
  if (options.exactness) validate(*options.exactness);
  return options.device == "reference" ? makeReferenceBackend(scene, sensors, options)
                                       : makeVulkanBackend(scene, sensors, options);
}

}  // namespace

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
  devices.push_back(referenceDevice());
  return devices;
}

Simulator::Simulator(const Scene& scene, const std::vector<Sensor>& sensors, const SimulatorOptions& options)
    : sensors_(sensors), backend_(makeBackend(scene, sensors, options)) {}
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
  const Shot shot = {pose, sensor};
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
    receive(i);
  });
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
