// SPDX-License-Identifier: Apache-2.0
// Records the stages of one scan: project and bin, shell by shell, then resolve, then the effects that are planned.
#pragma once

#include <vector>

#include "vulkan/commands.hpp"
#include "vulkan/sensor_state.hpp"
#include "vulkan/still_image.hpp"

namespace gnosphere::vulkan {

class Stages {
 public:
  /// Timestamps that record() takes, at most: three shells, what moves, and the start.
  static constexpr uint32_t kStamps = 11;

  Stages(const Device& device, const Geometry& geometry, Layout& layout);

  /// Everything between the frame's own arrays and the results, set 0 being bound.
  void record(Commands& commands, const SensorState& state, const PlacedInstances& placed, StillImage::Use use) const;
  /// Dispatches of a scan of everything, by stage.
  void count(Plan& plan, const SensorState& state) const;

 private:
  void clear(Commands& commands, const SensorState& state, StillImage::Use use) const;
  void scanStill(Commands& commands, const SensorState& state, const PlacedInstances& placed) const;
  void scanMoving(Commands& commands, const SensorState& state, const PlacedInstances& placed) const;
  void project(Commands& commands, const SensorState& state, std::span<const PlacedInstances::Chunk> chunks,
               gpu::Pass pass) const;
  void bin(Commands& commands, const SensorState& state, bool lastShell) const;
  void findOccluders(Commands& commands, const SensorState& state) const;
  void resolve(Commands& commands, const SensorState& state) const;
  void effects(Commands& commands, const SensorState& state) const;
  uint32_t groupCount() const;
  uint32_t cullGroupCount() const;
  uint32_t triangleGroupCount(const SensorState& state) const;

  const Device& device_;
  std::vector<VkDescriptorSet> chunkSets_;
};

}  // namespace gnosphere::vulkan
