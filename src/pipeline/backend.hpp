// SPDX-License-Identifier: Apache-2.0
// The border between what a scan means and the machine that computes it.
#pragma once

#include "gnosphere/simulator.hpp"

namespace gnosphere {

struct SensorPlan;

/// One machine with one scene on it. Implemented by vulkan/, cuda/ and reference/; none of them includes another.
class Backend {
 public:
  virtual ~Backend() = default;
  /// Scans in order, all into `result`, calling `receive` after each: every array, the counters and the timings. Name,
  /// grid size and pose are the caller's to fill.
  virtual void scanAll(std::span<const Shot> shots, Scan& result, const std::function<void(size_t)>& receive) = 0;
  /// Of each of the following, an index is the next one or one that is there; null or kNoMesh removes. Where one
  /// throws, the scene and the sensors are as they were.
  virtual void setSensor(size_t index, std::shared_ptr<const SensorPlan> plan) = 0;
  /// The materials that meshes name, and their images. A device reads optics from its sensors' plans.
  virtual void setMaterials(const std::vector<Material>& materials, const std::vector<AlphaImage>& images) = 0;
  virtual void setMesh(size_t index, const Mesh* mesh) = 0;
  virtual void setInstance(size_t index, uint32_t mesh, const Transform& transform) = 0;
  /// As many as the mesh has.
  virtual void setPositions(size_t mesh, std::span<const float> positions) = 0;
  virtual Plan plan(size_t sensor) const = 0;
  virtual const DeviceInfo& device() const = 0;
  virtual MemoryUse memory() const = 0;
  virtual size_t clusterCount() const = 0;
};

/// The sensors of a new simulator.
using SensorPlans = std::vector<std::shared_ptr<const SensorPlan>>;

std::unique_ptr<Backend> makeReferenceBackend(const Scene& scene, const SensorPlans& sensors,
                                              const SimulatorOptions& options);
std::unique_ptr<Backend> makeVulkanBackend(const Scene& scene, const SensorPlans& sensors,
                                           const SimulatorOptions& options);
/// Every Vulkan device seen; empty, with the reason in `problem`, where there is no Vulkan at all.
std::vector<DeviceInfo> listVulkanDevices(std::string* problem);
DeviceInfo referenceDevice();

/// Built with GNOSPHERE_CUDA, or else absent: then every call says so.
namespace cuda {
std::unique_ptr<Backend> makeBackend(const Scene& scene, const SensorPlans& sensors, const SimulatorOptions& options);
/// Every CUDA device; empty, with the reason in `problem`, where there is none.
std::vector<DeviceInfo> devices(std::string& problem);
}  // namespace cuda

}  // namespace gnosphere
