// SPDX-License-Identifier: Apache-2.0
// What one sensor, or a part of it, has on the device: its tables, its pipelines and the work arrays of a scan.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "gnosphere/scan.hpp"
#include "pipeline/beam_tables.hpp"
#include "pipeline/outputs.hpp"
#include "pipeline/results.hpp"
#include "pipeline/scan_options.hpp"
#include "vulkan/effects_state.hpp"
#include "vulkan/geometry.hpp"
#include "vulkan/kernels.hpp"

namespace gnosphere::vulkan {

/// Whether a StillImage may be kept.
bool keepsStill(const SimulatorOptions& options, uint32_t binning, const SensorPlan& plan);

/// Scans that are handed to the device at a time: it works on one while the host receives the one before.
inline constexpr size_t kFramesInFlight = 2;

/// How many entries the lists of a scan have room for.
struct Capacities {
  uint32_t projected = 0, tiles = 0, candidates = 0;
};

/// What a frame in flight has of its own; the work arrays of the stages are shared.
struct FrameInFlight {
  Buffer frame;
  EffectsBuffers effects;
  std::vector<Buffer> results;  ///< where the host reads the outputs, then the counters
  Capacities capacities;        ///< of the lists when it was prepared
  VkDescriptorSet set = VK_NULL_HANDLE;

  /// Of the scan it was last used for.
  const gpu::Counters& counters() const;
};

class SensorState {
 public:
  /// Shares the pipelines of one of `others` that needs the same; they must live as long.
  SensorState(const Device& device, Layout& layout, const Geometry& geometry, const Sensor& sensor,
              const SimulatorOptions& options, uint32_t binning, const SensorPlan& plan, uint64_t firstBeam,
              std::span<const SensorState> others);

  const gpu::Frame& frame() const { return tables_.frame; }
  /// Metres: instances farther away need not be looked at.
  double reach() const { return reach_; }
  uint32_t binning() const { return binning_; }
  /// Those of the scan that was prepared last.
  const Kernels& kernels() const { return *kernels_[moving_]; }
  /// See gnosphere::shellEnds().
  std::span<const float> shellEnds() const { return shellEnds_; }
  const Buffer& buffer(uint32_t binding) const {
    return binding < buffers_.size() ? buffers_[binding] : effects_->buffer(binding);
  }
  std::span<const Output> outputs() const { return outputs_; }
  const SensorPlan& plan() const { return plan_; }
  /// What the host reads is words alone, see resolve_words.hpp.
  bool leavesWords() const { return gnosphere::leavesWords(binning_, plan_); }
  /// Those of the scan that was prepared last.
  const Buffer& words() const { return *words_; }
  /// The words as the still instances leave them: empty until there is room.
  const Buffer& stillWords() const { return stillWords_; }
  void makeStillWords();

  /// Frame in flight `index` with what a scan of the placed instances needs. The frame must not be in use.
  /// `motion`: null for a scan that stands still.
  const FrameInFlight& prepare(size_t index, const Shot& shot, const ShotMotion* motion, uint32_t instanceCount,
                               const PlacedInstances& placed, const VisibleLists& visible);
  const FrameInFlight& inFlight(size_t index) const { return inFlight_[index]; }
  /// What the scan that it was last used for left.
  DeviceResults results(size_t index) const;
  /// True where the host reads the outputs in place; false where they must be copied to results.
  bool readsInPlace() const { return device_.unifiedMemory(); }
  /// A list was too small for the scan that the frame was used for: it must run again, after growLists().
  bool cutShort(const FrameInFlight& frame) const;
  /// Makes room for what the scan has counted, where it was too small. No frame may be in use.
  void growLists(const FrameInFlight& frame);
  void addTo(MemoryUse& use) const;
  /// Pipelines and buffers; dispatches are the stages' to add.
  void describe(Plan& plan) const;

 private:
  void makeBuffers(const Geometry& geometry);
  void growProjected(uint64_t count);
  void growTiles(uint64_t count);
  uint64_t mostTiles() const;
  void growCandidates(uint64_t count);
  FrameInFlight makeFrame() const;

  const Device& device_;
  Layout& layout_;
  uint32_t binning_;
  const SensorPlan& plan_;
  bool exact_;
  std::vector<Output> outputs_;
  std::unique_ptr<EffectsState> effects_;  // empty where nothing but geometry is planned
  std::vector<float> shellEnds_;
  double reach_ = 0;
  BeamTables tables_;
  // Of scans that stand still, and of scans in motion where those are planned.
  std::unique_ptr<Kernels> ownKernels_[2];  // empty where another sensor has them
  const Kernels* kernels_[2] = {};
  bool moving_ = false;
  std::array<Buffer, gpu::kWorkBindingCount> buffers_;  // set 0, in binding order; empty where they lie elsewhere
  Capacities capacities_;
  const Buffer* words_ = nullptr;
  Buffer stillWords_;
  std::vector<FrameInFlight> inFlight_;  // those beyond the first are made when first used
};

}  // namespace gnosphere::vulkan
