// SPDX-License-Identifier: Apache-2.0
// A sensor on a device: its tables, the arrays of its scans, and the steps that a scan is.
#pragma once

#include <optional>
#include <vector>

#include "effects/arrays.hpp"
#include "pipeline/beam_tables.hpp"
#include "pipeline/machine.hpp"
#include "pipeline/outputs.hpp"
#include "pipeline/results.hpp"
#include "pipeline/scan_options.hpp"

namespace gnosphere {

class SensorArrays {
 public:
  /// Allocates what scans need, and has the machine compile their kernels. `triangles`: placed in the scene.
  SensorArrays(Machine& machine, const SensorPlan& plan, const SimulatorOptions& options, uint64_t triangles);

  const SensorPlan& sensorPlan() const { return plan_; }
  uint32_t beams() const { return tables_.frame.beams; }
  /// Metres: instances farther away need not be looked at.
  double reach() const { return reach_; }
  bool keepsStill() const { return keepsStill_; }

  /// The steps of a scan as frame in flight `frame`, which must not be under way. `motion`: null for a scan that stands
  /// still. Binds the arrays of the sensor and of the frame.
  std::vector<Step> prepare(size_t frame, const Shot& shot, const ShotMotion* motion, uint32_t instanceCount,
                            const PlacedGroups& placed, StillImage::Use still, BoundArrays& arrays);
  /// A list was too small for the scan that was last prepared as this frame: it must run again after growLists().
  bool cutShort(size_t frame);
  /// Makes room for what that scan has counted, where it was too small. No frame may be under way.
  void growLists(size_t frame);
  /// What that scan has left.
  DeviceResults results(size_t frame);
  void addTo(MemoryUse& use) const;
  /// Decisions, stages and buffers.
  Plan plan() const;

 private:
  /// What a frame in flight has of its own; the work arrays are shared.
  struct Frame {
    std::array<std::unique_ptr<DeviceMemory>, gpu::kArrayCount> arrays;
    Capacities capacities;  // of the lists when it was prepared
  };

  std::vector<Step> steps(const PlacedGroups& placed, StillImage::Use still, bool motion) const;
  PlacedGroups everything() const;
  uint64_t mostProjected() const;
  uint64_t tilesBehind(const Capacities& room) const;
  void makeLists(const Capacities& room);
  void allocate(gpu::Array array, uint64_t bytes);
  void addFrame();
  void load(Frame& frame, const std::vector<EffectsArray>& arrays);
  const gpu::Counters& counters(Frame& frame) const;
  uint64_t limit(uint64_t entryBytes) const;
  std::unique_ptr<DeviceMemory>& of(gpu::Array array) { return arrays_[static_cast<size_t>(array)]; }

  Machine& machine_;
  const SensorPlan& plan_;
  BeamTables tables_;
  uint32_t binning_;
  bool exact_, keepsStill_, float64_;
  Options options_;
  std::vector<float> shellEnds_;
  double reach_;
  std::vector<Output> outputs_;
  Capacities capacities_;
  std::array<std::unique_ptr<DeviceMemory>, gpu::kArrayCount> arrays_;
  std::vector<Frame> frames_;  // those beyond the first are made when first used
};

}  // namespace gnosphere
