// SPDX-License-Identifier: Apache-2.0
// Interface between the Simulator and the code that computes scans.
#pragma once

#include "gnosphere/simulator.hpp"

namespace gnosphere {

struct Places;
struct Recording;
struct SensorPlan;
struct CallerVertices;
struct CallerTransforms;

/// Computes the scans of one scene. Implemented by device_backend (on vulkan/ or cuda/) and by reference/.
class Backend {
 public:
  virtual ~Backend() = default;
  /// Makes the scans in order, each into `result`, and calls `receive` after each. Fills every array, the counters and
  /// the timings; the caller fills name, grid size and pose.
  virtual void scanAll(std::span<const Shot> shots, Scan& result, const std::function<void(size_t)>& receive) = 0;
  /// Makes the scans of shots of one sensor in order, into arrays in which the entries of one scan follow those of the
  /// other, and calls `receive` after each. Returns false, and does nothing, if scans of the sensor have more than
  /// nearest hits, or if the device has no better way than scanAll(). `sum` gets the counters and times of all scans
  /// together.
  virtual bool scanInto(std::span<const Shot> /*shots*/, const Places& /*places*/, Scan& /*sum*/,
                        const std::function<void(size_t)>& /*receive*/) {
    return false;
  }
  /// Records scans into a command buffer; see vulkan::Recorder and BatchStream. Only called if results stay on the
  /// device.
  virtual void record(Recording& /*recording*/) {}
  /// The commands of the last recording of this frame in flight will never run.
  virtual void abandon(size_t /*frame*/) {}
  /// Makes buffers for the results of recorded scans, see Machine::makeRing(). The method is only called
  /// with SimulatorOptions::resultsOnDevice.
  virtual std::unique_ptr<ResultRing> makeRing(size_t /*buffers*/, uint64_t /*bytes*/, uint64_t /*hostBytes*/);
  /// In each of the following an index is an existing one, or the next one to add an entry; null or kNoMesh removes the
  /// entry. If a call throws, the scene and the sensors are unchanged.
  virtual void setSensor(size_t index, std::shared_ptr<const SensorPlan> plan) = 0;
  /// The plan of a sensor has other optics than before, and is the same otherwise.
  virtual void setOptics(size_t sensor, std::shared_ptr<const SensorPlan> plan) = 0;
  /// Replaces the materials and their images. Devices ignore them and read optics from the plans of the sensors.
  virtual void setMaterials(const std::vector<Material>& materials, const std::vector<AlphaImage>& images) = 0;
  virtual void setMesh(size_t index, const Mesh* mesh) = 0;
  virtual void setInstance(size_t index, uint32_t mesh, const Transform& transform, uint32_t world = 0) = 0;
  /// Gives existing instances new transforms; of equal instances the last one counts.
  virtual void moveInstances(std::span<const uint32_t> instances, std::span<const Transform> transforms) = 0;
  /// Moves all vertices of the mesh; `positions` has 3 values per vertex.
  virtual void setPositions(size_t mesh, std::span<const float> positions) = 0;
  /// Deforms the mesh, which is deformable; the deformation fits it.
  virtual void setDeformation(size_t mesh, const Deformation& deformation) = 0;
  /// The vertices of the mesh, which is not deformable, are in a valid buffer of the caller. Only a device of the
  /// caller is asked for this.
  virtual void setVertices(size_t /*mesh*/, const CallerVertices& /*buffer*/) {}
  /// The transforms of instances are in a valid buffer of the caller, each until it is moved. Only a device of the
  /// caller is asked for this.
  virtual void setTransforms(const CallerTransforms& /*buffer*/) {}
  virtual Plan plan(size_t sensor) const = 0;
  /// Returns the plan that setSensor() would make of this, for a submission of so many views or as many as fit. The
  /// method allocates nothing on the device, and the backend stays as it is.
  virtual Plan planOf(std::shared_ptr<const SensorPlan> plan, size_t views) const = 0;
  virtual const DeviceInfo& device() const = 0;
  virtual MemoryUse memory() const = 0;
  virtual size_t clusterCount() const = 0;
};

/// The plans of the sensors, by index.
using SensorPlans = std::vector<std::shared_ptr<const SensorPlan>>;

/// Makes the backend of the device that the options choose.
std::unique_ptr<Backend> makeBackend(const Scene& scene, const SensorPlans& sensors, const SimulatorOptions& options);
std::unique_ptr<Backend> makeReferenceBackend(const Scene& scene, const SensorPlans& sensors,
                                              const SimulatorOptions& options);
std::unique_ptr<Backend> makeVulkanBackend(const Scene& scene, const SensorPlans& sensors,
                                           const SimulatorOptions& options);
/// Lists every Vulkan device; without Vulkan the list is empty and `problem` gives the reason.
std::vector<DeviceInfo> listVulkanDevices(std::string* problem);
DeviceInfo referenceDevice();

/// Backend for devices of CUDA. In a build without GNOSPHERE_CUDA every call reports that CUDA is not built in.
namespace cuda {
std::unique_ptr<Backend> makeBackend(const Scene& scene, const SensorPlans& sensors, const SimulatorOptions& options);
/// Lists every CUDA device; if there is none the list is empty and `problem` gives the reason.
std::vector<DeviceInfo> devices(std::string& problem);
}  // namespace cuda

}  // namespace gnosphere
