// SPDX-License-Identifier: Apache-2.0
// Compares CUDA's backend with the others: its kernels always run on the host, and on a CUDA device if there is one.
#pragma once

#include "effects/sensor_plan.hpp"
#include "pipeline/backend.hpp"
#include "support.hpp"

namespace gnosphere::cuda_on_host {
std::unique_ptr<Backend> makeBackend(const Scene& scene, const SensorPlans& sensors, const SimulatorOptions& options);
}

namespace gnosphere::test {

/// Returns an empty text if a CUDA device is usable, else the reason.
inline std::string cudaProblem() {
  std::string problem;
  for (const DeviceInfo& device : cuda::devices(problem)) {
    if (device.usable) return "";
    problem = device.name + ": " + device.reason;
  }
  return problem;
}

/// Skips the test if no CUDA device is usable; fails it if GNOSPHERE_REQUIRE names cuda.
inline void needCuda() {
  const std::string problem = cudaProblem();
  if (problem.empty()) return;
  const char* required = std::getenv("GNOSPHERE_REQUIRE");
  if (required && std::strstr(required, "cuda")) FAIL("no usable CUDA device: " << problem);
  SKIP("no usable CUDA device: " << problem);
}

/// True if the device rounds quotients as a CPU does, so its `standard` ranges, which are quotients, have the same
/// bytes. Graphics cards may round them differently.
inline bool dividesExactly(const DeviceInfo& device) {
  return device.type == "cpu";
}

/// The CUDA backend on the host for one scene: does the work of Simulator without its checks.
class CudaOnHost {
 public:
  CudaOnHost(const SimulatorOptions& setup, const Scene& scene, const std::vector<SensorRequest>& requests,
             decltype(&cuda_on_host::makeBackend) makeBackend = cuda_on_host::makeBackend)
      : requests_(requests), setup_(setup), planner_(setup_) {
    SensorPlans plans;
    for (const SensorRequest& request : requests) plans.push_back(planner_.plan(scene, request, plans.size(), false));
    backend_ = makeBackend(scene, plans, setup_);
  }
  CudaOnHost(const Scene& scene, const std::vector<Sensor>& sensors, const TestOptions& setup,
             decltype(&cuda_on_host::makeBackend) makeBackend = cuda_on_host::makeBackend)
      : CudaOnHost(setup, scene, requestsOf(sensors, setup), makeBackend) {}

  Scan scan(const Pose& pose, size_t sensor = 0) {
    Shot shot;
    shot.pose = pose;
    shot.sensor = sensor;
    Scan result;
    scanInto(shot, result);
    return result;
  }
  void scanInto(const Shot& shot, Scan& result) {
    backend_->scanAll({&shot, 1}, result, [](size_t) {});
    const Sensor& sensor = requests_[shot.sensor].sensor;
    result.sensor = sensor.name;
    result.columns = sensor.columns;
    result.channels = static_cast<uint32_t>(sensor.channels.size());
    result.pose = shot.pose;
  }
  Backend& backend() { return *backend_; }

 private:
  std::vector<SensorRequest> requests_;
  SimulatorOptions setup_;
  SensorPlanner planner_;
  std::unique_ptr<Backend> backend_;
};

/// Checks that `exact` has the bytes of `decided`, and that `standard` differs from the reference only in ties: on the
/// host, and on cuda:0 if it exists.
class CudaTwin {
 public:
  CudaTwin(const Scene& scene, const std::vector<Sensor>& sensors, ReflectingFaces faces = ReflectingFaces::material) {
    TestOptions options;
    options.faces = faces;
    standardOnHost_.emplace(scene, sensors, options);
    options.device = deviceByName("cuda:0");
    if (cudaProblem().empty()) standard_.emplace(makeSimulator(scene, sensors, options));
    options.accuracy = Accuracy::exact;
    if (cudaProblem().empty()) exact_.emplace(makeSimulator(scene, sensors, options));
    exactOnHost_.emplace(scene, sensors, options);
  }

  void require(const Pose& pose, size_t sensor, const Scan& reference, const Scan& decided) {
    INFO("CUDA");
    requireSame(reference, standardOnHost_->scan(pose, sensor));
    REQUIRE(sameBytes(decided, exactOnHost_->scan(pose, sensor)));
    if (standard_) requireSame(reference, standard_->scan(pose, sensor));
    if (exact_) REQUIRE(sameBytes(decided, exact_->scan(pose, sensor)));
  }

 private:
  std::optional<CudaOnHost> standardOnHost_, exactOnHost_;
  std::optional<Simulator> standard_, exact_;
};

}  // namespace gnosphere::test
