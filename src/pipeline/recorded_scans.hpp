// SPDX-License-Identifier: Apache-2.0
// Scans that are recorded into command buffers of the caller or of a stream of batches, and what became of them.
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "pipeline/recorded_transforms.hpp"
#include "pipeline/recorded_vertices.hpp"
#include "pipeline/recording.hpp"
#include "pipeline/scene_arrays.hpp"
#include "pipeline/sensor_arrays.hpp"
#include "pipeline/submissions.hpp"

namespace gnosphere {

class RecordedScans {
 public:
  /// `listBytes` is what the lists of instances and clusters of views that are scanned together may take.
  RecordedScans(Machine& machine, SceneArrays& scene, uint64_t listBytes)
      : machine_(machine), scene_(scene), listBytes_(listBytes), vertices_(machine, scene) {}

  /// Records the scans of a frame. `sensors` has the arrays by sensor. Lists that were too small for the scans recorded
  /// before grow first.
  void record(Recording& recording, const std::vector<SensorArrays*>& sensors);
  /// The commands of the frame's last recording will never run. Throws Error(invalidArgument) if another frame has been
  /// recorded since, because its commands build on these.
  void abandon(size_t frame);
  /// The sensor has other arrays from now on, or is gone. `before` is what it had; the scans in flight keep it until
  /// their frame comes again.
  void replace(size_t sensor, std::shared_ptr<SensorArrays> before);
  /// Must be called when the vertices of a mesh come from a buffer of the caller.
  void takeVertices() { vertices_.prepare(); }
  /// Must be called when transforms of instances come from a buffer of the caller.
  void takeTransforms() { RecordedTransforms::prepare(machine_); }
  uint64_t bytes() const;

 private:
  /// The arrays of a run of the stages that do not depend on the sensor. Each part of a sensor's shots has a run.
  struct Run {
    size_t index;                                       // of its slot in the sensor's arrays
    std::unique_ptr<DeviceMemory> addresses = nullptr;  // gpu::Addresses
    PlacedArrays placed = {};
    RecordedTransforms transforms = {};
    size_t views = 0;    // of the last recording
    bool moves = false;  // whether anything moved in the last recording
  };
  /// A scan that was recorded: its number, and its runs.
  struct Recorded {
    uint64_t frame;
    size_t firstRun, lastRun;
  };
  /// One sensor's scans in one frame in flight.
  struct SensorScans {
    std::vector<Run> runs;
    std::vector<Recorded> scans;             // whose outcome is not known yet
    std::shared_ptr<SensorArrays> replaced;  // what has recorded them, if the sensor has other arrays since
  };
  /// The recorded scans of one frame in flight.
  struct Frame {
    std::map<size_t, SensorScans> sensors;   // by number
    ArrayTable classes;                      // of surfaces
    uint32_t classedInstances = 0;           // how many have a class
    std::vector<Recording::Result> results;  // that were read, but that no call has returned yet, because it failed
  };

  /// The shots of one sensor in a recording.
  struct ShotsOfSensor {
    size_t number;
    SensorArrays* sensor;
    std::vector<Shot> shots;
    std::vector<SensorArrays::RecordSpace> spaces;  // of each shot
    std::vector<Part> parts;
  };

  std::vector<ShotsOfSensor> divide(const Recording& recording, const std::vector<SensorArrays*>& sensors,
                                    size_t mostViews) const;
  void makeRoom(const std::vector<ShotsOfSensor>& all, Frame& frame);
  void readResults(Frame& frame, const std::vector<SensorArrays*>& sensors);
  void undo(size_t frame) noexcept;
  void record(const Frame& frame, const ShotsOfSensor& of, const Part& part, Run& run);

  Machine& machine_;
  SceneArrays& scene_;
  uint64_t listBytes_;
  RecordedVertices vertices_;
  std::vector<Frame> frames_;
  std::map<size_t, size_t> runs_;  // by sensor: how many runs all frames have
  std::vector<size_t> order_;      // frames in the order of their last recordings, without those that were abandoned
};

}  // namespace gnosphere
