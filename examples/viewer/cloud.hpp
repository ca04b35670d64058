// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gnosphere/gnosphere.hpp>
#include <string>

#include "camera.hpp"
#include "frames.hpp"
#include "pipeline.hpp"

namespace viewer {

enum class Colouring : uint32_t { range, intensity, instance, none };

/// The cloud of a sensor: GnoSphere writes it into a vertex buffer of ours, from which it is drawn in the same frame.
class Cloud {
 public:
  Cloud(const Device& on, VkRenderPass pass, const gnosphere::Scene& scene, const gnosphere::Sensor& sensor);
  ~Cloud();

  gnosphere::Simulator& simulator() { return simulator_; }
  /// Records a scan, outside of a render pass.
  void scan(const Frames::Frame& frame, const gnosphere::Pose& pose, uint64_t number);
  /// Draws the points of the last scan in the same command buffer.
  void draw(VkCommandBuffer commands, const glm::dmat4& toClip, Colouring colouring, float size) const;
  /// Returns the header of the last scan, once its commands have ended.
  gnosphere::RecordHeader header() const;

 private:
  const Device& on_;
  gnosphere::SensorRequest request_;
  gnosphere::Simulator simulator_;
  gnosphere::vulkan::Recorder recorder_;
  Buffer records_, header_;
  Pipeline pipeline_;
  gnosphere::Pose pose_;  // of the last scan
};

}  // namespace viewer
