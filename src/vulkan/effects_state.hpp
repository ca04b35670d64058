// SPDX-License-Identifier: Apache-2.0
// What the planned effects of one sensor, or of a part of it, have on the device.
#pragma once

#include <array>
#include <vector>

#include "effects/arrays.hpp"
#include "pipeline/outputs.hpp"
#include "shared.h"
#include "vulkan/buffer.hpp"

namespace gnosphere::vulkan {

/// Under their binding numbers; empty where nothing is planned for them.
using EffectsBuffers = std::array<Buffer, gpu::kWorkBindingCountEffects>;

class EffectsState {
 public:
  using Bindings = std::array<const Buffer*, gpu::kWorkBindingCountEffects>;

  /// Of the sensor or of a part of it whose beams begin at `firstBeam`.
  EffectsState(const Device& device, const SensorPlan& plan, std::span<const gpu::Row> rows, uint64_t firstBeam);

  /// Outputs that are not read in place.
  void makeOutputs(std::span<const Output> outputs, uint64_t beams);
  /// Room for so many projected triangles.
  void growProjected(uint64_t count);
  /// Writes what a scan needs beyond what every scan does to a frame in flight's own buffers, made when first used.
  void prepare(EffectsBuffers& frame, const Shot& shot, const ShotMotion* motion) const;
  void bind(const EffectsBuffers& frame, Bindings& bindings) const;
  const Buffer& buffer(uint32_t binding) const { return buffers_[binding]; }
  uint64_t bytes() const;
  void list(std::vector<Plan::Buffer>& to) const;

 private:
  void make(const std::vector<EffectsArray>& arrays);

  const Device& device_;
  const SensorPlan& plan_;
  uint64_t firstBeam_;
  EffectsBuffers buffers_;
};

}  // namespace gnosphere::vulkan
