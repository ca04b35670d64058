// SPDX-License-Identifier: Apache-2.0
// The border between what a scan means and the machine that computes it.
#pragma once

#include "gnosphere/simulator.hpp"

namespace gnosphere {

/// One machine with one scene on it. Implemented by vulkan/, cuda/ and reference/; none of them includes another.
class Backend {
 public:
  virtual ~Backend() = default;
  /// Scans in order, all into `result`, calling `receive` after each: every array, the counters and the timings. Name,
  /// grid size and pose are the caller's to fill.
  virtual void scanAll(std::span<const Shot> shots, Scan& result, const std::function<void(size_t)>& receive) = 0;
  /// Adds the next instance, or moves or replaces one that is there; kNoMesh removes it.
  virtual void setInstance(size_t index, uint32_t mesh, const Transform& transform) = 0;
  /// As many as the mesh has.
  virtual void setPositions(size_t mesh, std::span<const float> positions) = 0;
  virtual Plan plan(size_t sensor) const = 0;
  virtual const DeviceInfo& device() const = 0;
  virtual MemoryUse memory() const = 0;
  virtual size_t clusterCount() const = 0;
};

std::unique_ptr<Backend> makeReferenceBackend(const Scene& scene, const std::vector<Sensor>& sensors,
                                              const SimulatorOptions& options);
std::unique_ptr<Backend> makeVulkanBackend(const Scene& scene, const std::vector<Sensor>& sensors,
                                           const SimulatorOptions& options);
/// Every Vulkan device seen; empty, with the reason in `problem`, where there is no Vulkan at all.
std::vector<DeviceInfo> listVulkanDevices(std::string* problem);
DeviceInfo referenceDevice();

/// Built with GNOSPHERE_CUDA, or else absent: then every call says so.
namespace cuda {
std::unique_ptr<Backend> makeBackend(const Scene& scene, const std::vector<Sensor>& sensors,
                                     const SimulatorOptions& options);
/// Every CUDA device; empty, with the reason in `problem`, where there is none.
std::vector<DeviceInfo> devices(std::string& problem);
}  // namespace cuda

}  // namespace gnosphere
