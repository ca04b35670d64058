// SPDX-License-Identifier: Apache-2.0
// Scans that are recorded into the caller's command buffers, and what became of them.
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "pipeline/recorded_transforms.hpp"
#include "pipeline/recorded_vertices.hpp"
#include "pipeline/recording.hpp"
#include "pipeline/scene_arrays.hpp"
#include "pipeline/sensor_arrays.hpp"

namespace gnosphere {

class RecordedScans {
 public:
  RecordedScans(Machine& machine, SceneArrays& scene) : machine_(machine), scene_(scene), vertices_(machine, scene) {}

  /// Records the scans of a frame. `sensors` has the arrays by sensor. Lists that were too small for the scans recorded
  /// before grow first.
  void record(Recording& recording, const std::vector<SensorArrays*>& sensors);
  /// The commands of the frame's last recording will never run. Throws Error(invalidArgument) if another frame has been
  /// recorded since, because its commands build on these.
  void abandon(size_t frame);
  /// Must be called before the arrays of a sensor are destroyed.
  void forget(size_t sensor);
  /// Must be called when the vertices of a mesh come from a buffer of the caller.
  void takeVertices() { vertices_.prepare(); }
  /// Must be called when transforms of instances come from a buffer of the caller.
  void takeTransforms() { RecordedTransforms::prepare(machine_); }
  uint64_t bytes() const;

 private:
  /// The arrays of a run of the stages that do not depend on the sensor. Each group of beams has a run.
  struct Run {
    std::unique_ptr<DeviceMemory> addresses;  // gpu::Addresses
    PlacedArrays placed;
    RecordedTransforms transforms;
  };
  /// One sensor's scan in one frame in flight.
  struct Slot {
    std::vector<Run> runs;  // at least as many as the scan has groups
    uint64_t frame = 0;
    bool recorded = false;
  };
  using Slots = std::map<size_t, Slot>;  // by sensor

  void readResults(size_t frame, const std::vector<SensorArrays*>& sensors);
  void undo(size_t frame) noexcept;
  void record(const Recording& recording, const Recording::Item& item, SensorArrays& sensor);
  void record(const Recording& recording, const Recording::Item& item, SensorArrays& sensor, size_t group, Run& run);

  Machine& machine_;
  SceneArrays& scene_;
  RecordedVertices vertices_;
  std::vector<Slots> frames_;
  // By frame: results that were read, but that no call has returned yet, because it failed.
  std::vector<std::vector<Recording::Result>> results_;
  std::vector<size_t> order_;  // frames in the order of their last recordings, without those that were abandoned
};

}  // namespace gnosphere
