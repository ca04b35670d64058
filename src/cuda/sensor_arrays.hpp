// SPDX-License-Identifier: Apache-2.0
// What one sensor has on a CUDA device: its tables and the work arrays of a scan.
#pragma once

#include <array>

#include "cuda/runtime.hpp"
#include "effects/arrays.hpp"
#include "pipeline/beam_tables.hpp"
#include "pipeline/outputs.hpp"
#include "pipeline/results.hpp"
#include "pipeline/scan_options.hpp"

namespace gnosphere::cuda {

class SensorArrays {
 public:
  SensorArrays(const SensorPlan& plan, const SimulatorOptions& options, uint64_t triangles);

  const SensorPlan& plan() const { return plan_; }
  uint32_t binning() const { return binning_; }
  bool leavesWords() const { return gnosphere::leavesWords(binning_, plan()); }
  const gpu::Frame& frame() const { return tables_.frame; }
  double reach() const { return reach_; }
  /// See gnosphere::shellEnds().
  std::span<const float> shellEnds() const { return shellEnds_; }

  /// Binds everything but what is placed, with nothing counted and no beam met. `motion`: null for a scan that stands
  /// still.
  void prepare(const Shot& shot, const ShotMotion* motion, uint32_t instanceCount, Job& job);
  gpu::Counters counters() const { return arrays_[gpu::kBindCounters].read<gpu::Counters>(0, 1)[0]; }
  /// Makes room for what a scan has counted; false where there was enough.
  bool grow(const gpu::Counters& needed);
  /// Of the last scan; valid until the next.
  DeviceResults results();
  /// What its kernels are specialised for beyond the simulator's options.
  void addTo(Options& options) const;
  void addTo(MemoryUse& use) const;
  void list(std::vector<Plan::Buffer>& to) const;

 private:
  void make(uint32_t binding, const char* name, uint64_t bytes);
  void make(const std::vector<EffectsArray>& arrays);
  void growProjected(uint64_t count);
  void growTiles(uint64_t count);
  void growCandidates(uint64_t count);

  std::vector<Output> outputs() const { return outputsOf(plan(), leavesWords()); }

  const SensorPlan& plan_;
  uint32_t binning_;
  bool exact_;
  BeamTables tables_;  // with the capacities of the lists
  double reach_;
  std::vector<float> shellEnds_;
  std::array<Array, gpu::kWorkBindingCountEffects> arrays_;  // set 0; empty where nothing is planned for them
  std::vector<std::vector<std::byte>> results_;              // of the outputs, on the host
};

}  // namespace gnosphere::cuda
