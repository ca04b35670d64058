// SPDX-License-Identifier: Apache-2.0
// Records the step that takes the vertices of meshes from buffers of the caller, before the scans of a recording.
#pragma once

#include <deque>
#include <memory>

#include "pipeline/scene_arrays.hpp"

namespace gnosphere {

class RecordedVertices {
 public:
  RecordedVertices(Machine& machine, SceneArrays& scene) : machine_(machine), scene_(scene) {}

  /// Compiles the kernel; nothing the second time.
  void prepare();
  /// Reads how many triangles were left out when a frame in flight was recorded the last time; its commands have
  /// completed.
  void readDropped(size_t frame);
  /// Records the step for the meshes whose vertices have changed, if there are any, as a part of the recording that
  /// is under way for a frame in flight, after readDropped().
  void record(size_t frame);
  /// Vertices that the frame's last recording would have taken must be taken by the next one.
  void abandon(size_t frame) noexcept;
  uint64_t bytes() const;

 private:
  struct Frame {
    std::unique_ptr<DeviceMemory> addresses;  // gpu::Addresses
    ArrayTable arrays;  // of VertexSources::Work, and VertexSources::Dropped of each of its meshes
    std::vector<size_t> meshes;
  };

  Machine& machine_;
  SceneArrays& scene_;
  std::deque<Frame> frames_;
  bool prepared_ = false;
};

}  // namespace gnosphere
