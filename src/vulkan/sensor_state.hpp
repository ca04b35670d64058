// SPDX-License-Identifier: Apache-2.0
// What one sensor has on the device: its tables, its pipelines and the work arrays of a scan.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "beam_tables.hpp"
#include "gnosphere/scan.hpp"
#include "vulkan/geometry.hpp"
#include "vulkan/kernel.hpp"

namespace gnosphere::vulkan {

/// gpu::kWay...: how the options and the device bin.
uint32_t chooseWay(const SimulatorOptions& options, bool int64Atomics);

/// The pipelines that a way of binning dispatches, and no others.
struct Kernels {
  /// `float64` chooses the modules whose exact tests filter in double precision.
  Kernels(const Device& device, const Layout& layout, const Options& options, uint32_t way, bool float64);
  Kernel projectClusters;
  Kernel projectTriangles;
  std::vector<Kernel> bin;
  std::vector<Kernel> scan;
  Kernel resolve;
};

/// What is read back beside the counters, with its size per beam.
struct Output {
  uint32_t binding;
  uint32_t bytesPerBeam;
};
inline constexpr Output kOutputs[] = {
    {gpu::kBindPoints, 12}, {gpu::kBindRanges, 4}, {gpu::kBindTriangles, 4}, {gpu::kBindOwners, 4}};

class SensorState {
 public:
  SensorState(const Device& device, Layout& layout, const Geometry& geometry, const Sensor& sensor,
              const SimulatorOptions& options, uint32_t way);

  const gpu::Frame& frame() const { return tables_.frame; }
  const Kernels& kernels() const { return *kernels_; }
  VkDescriptorSet set() const { return set_; }
  const Buffer& buffer(uint32_t binding) const { return buffers_[binding]; }
  /// Host copies of kOutputs, then of the counters; empty where device memory is the host's.
  const std::vector<Buffer>& readback() const { return readback_; }
  /// Where the host reads output i of kOutputs, or the counters for i = size of kOutputs.
  const Buffer& hostSide(size_t output) const;
  /// Of the last scan.
  const gpu::Counters& counters() const;

  /// Writes what a scan from this pose needs.
  void writeFrame(const Geometry& geometry, const Pose& pose);
  /// True if a list was too small for the scan just run: it now has room, and the scan must run again.
  bool growLists();
  void addTo(MemoryUse& use) const;

 private:
  void makeBuffers(const Geometry& geometry);
  void growProjected(uint64_t count);
  void growTiles(uint64_t count);
  void growCandidates(uint64_t count);
  std::array<const Buffer*, gpu::kWorkBindingCount> pointers() const;

  const Device& device_;
  Layout& layout_;
  uint32_t way_;
  BeamTables tables_;
  std::unique_ptr<Kernels> kernels_;
  std::array<Buffer, gpu::kWorkBindingCount> buffers_;  // set 0, in binding order
  uint32_t projectedCapacity_ = 0, tileCapacity_ = 0, candidateCapacity_ = 0;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
  std::vector<Buffer> readback_;
};

}  // namespace gnosphere::vulkan
